/* SPDX-License-Identifier: MIT
 *
 * Options as JSON, and JSON as text: see options_json.h.
 */
#include "io/options_json.h"

#include <stdlib.h>

static json_t *value_json(const nqm_option *o, const void *options) {
    const void *field = (const char *)options + o->offset;
    const size_t *list = field;
    char text[NQM_OPTION_TEXT_MAX];
    if (o->kind == NQM_OPTION_DOUBLE)
        return json_real(*(const double *)field);
    if (o->kind == NQM_OPTION_SIZE)
        return json_integer((json_int_t)*list);
    if (o->kind == NQM_OPTION_BOOL)
        return json_boolean(*(const int *)field != 0);
    if (o->kind != NQM_OPTION_SIZES)
        return json_string(nqm_option_format(o, options, text));
    json_t *array = json_array();
    for (size_t i = 1; i <= list[0]; ++i)
        if (json_array_append_new(array, json_integer((json_int_t)list[i])) != 0) {
            json_decref(array);
            return NULL;
        }
    return array;
}

json_t *nqm_json_from_options(const nqm_option_table *table, const void *options) {
    json_t *json = json_object();
    char text[NQM_OPTION_TEXT_MAX];
    for (size_t i = 0; json && i < table->n; ++i) {
        const nqm_option *o = &table->rows[i];
        const char *zero = o->words ? o->words[0] : "0";
        if (o->storage == NQM_NOT_STORED ||
            (o->storage == NQM_STORED_UNLESS_ZERO && strcmp(nqm_option_format(o, options, text), zero) == 0))
            continue;
        if (json_object_set_new(json, o->key, value_json(o, options)) != 0) {
            json_decref(json);
            json = NULL;
        }
    }
    return json;
}

char *nqm_json_text(json_t *json, size_t n_digits) {
    char *dump = json ? json_dumps(json, JSON_COMPACT | JSON_REAL_PRECISION(n_digits)) : NULL;
    char *text = dump ? nqm_strdup(dump) : NULL;
    free(dump);
    json_decref(json);
    return text;
}
