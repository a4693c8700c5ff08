/* SPDX-License-Identifier: MIT
 *
 * Options as JSON, and JSON as text: see options_json.h.
 */
#include "io/options_json.h"

#include <stdlib.h>

static json_t *value_json(const nqm_option *o, const void *options) {
    const void *field = (const char *)options + o->offset;
    char text[NQM_OPTION_TEXT_MAX];
    switch (o->kind) {
    case NQM_OPTION_DOUBLE:
        return json_real(*(const double *)field);
    case NQM_OPTION_SIZE:
        return json_integer((json_int_t) * (const size_t *)field);
    case NQM_OPTION_BOOL:
        return json_boolean(*(const int *)field != 0);
    case NQM_OPTION_SIZES: {
        const size_t *list = field;
        json_t *array = json_array();
        for (size_t i = 1; i <= list[0]; ++i)
            if (json_array_append_new(array, json_integer((json_int_t)list[i])) != 0) {
                json_decref(array);
                return NULL;
            }
        return array;
    }
    case NQM_OPTION_U64:
    case NQM_OPTION_ENUM:
    case NQM_OPTION_TEXT:
        break;
    }
    return json_string(nqm_option_format(o, options, text));
}

/* Whether a number, bool or enum is 0. */
static bool is_zero(const nqm_option *o, const void *options) {
    char text[NQM_OPTION_TEXT_MAX];
    return strcmp(nqm_option_format(o, options, text), o->words ? o->words[0] : "0") == 0;
}

json_t *nqm_json_from_options(const nqm_option_table *table, const void *options) {
    json_t *json = json_object();
    for (size_t i = 0; json && i < table->n; ++i) {
        const nqm_option *o = &table->rows[i];
        if (o->storage == NQM_NOT_STORED || (o->storage == NQM_STORED_UNLESS_ZERO && is_zero(o, options)))
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
