/* SPDX-License-Identifier: MIT
 *
 * Values of a schema, and their text: parsing against the list of keys, and the canonical form.
 */
#include "schema/schema.h"

#include <math.h>

/* ---- values ------------------------------------------------------------------------------------------------------- */

nqm_values nqm_values_of(const nqm_schema *schema) {
    nqm_values values = {.schema = schema};
    for (size_t k = 0; k < schema->n_keys; ++k)
        for (size_t c = 0; c < 3; ++c)
            values.v[k][c] = schema->keys[k].fallback;
    return values;
}

void nqm_values_set(nqm_values *values, const char *key, size_t n, const double *v) {
    const size_t k = nqm_schema_key_named(values->schema, key, strlen(key));
    if (k == values->schema->n_keys)
        return;
    for (size_t c = 0; c < 3; ++c)
        values->v[k][c] = v[nqm_smaller(c, n - 1)];
    values->given |= UINT64_C(1) << k;
}

const double *nqm_values_given(const nqm_values *values, const char *key) {
    const size_t k = nqm_schema_key_named(values->schema, key, strlen(key));
    return values->given >> k & 1 ? values->v[k] : NULL;
}

/* Whether one number is written for all values of the key. */
static bool is_one_number(const nqm_schema_key *key, const double v[3]) {
    size_t c = 1;
    while (c < key->n && v[c] == v[0])
        ++c;
    return c >= key->n;
}

bool nqm_values_are_isotropic(const nqm_values *values) {
    bool is_isotropic = true;
    for (size_t k = 0; k < values->schema->n_keys; ++k) {
        const nqm_schema_key *key = &values->schema->keys[k];
        is_isotropic &= (key->n != 2 || is_one_number(key, values->v[k])) &&
                        !(nqm_schema_is_anisotropic(key->role) && values->v[k][0] != 0);
    }
    return is_isotropic;
}

/* ---- parsing ----------------------------------------------------------------------------------------------------- */

enum { KEYS_TEXT = 384, NUMBER_SIZE = 32, SETTING_SIZE = 48 + 3 * NUMBER_SIZE };

static const char *format_values(const nqm_schema_key *key, const double v[3], char text[3 * NUMBER_SIZE]) {
    return nqm_format_doubles(text, 3 * NUMBER_SIZE, is_one_number(key, v) ? 1 : key->n, v, ",");
}

/* "kd, ks, alpha" */
static const char *list_keys(const nqm_schema *schema, char text[KEYS_TEXT]) {
    size_t used = 0;
    for (size_t k = 0; k < schema->n_keys && used < KEYS_TEXT; ++k)
        used += (size_t)snprintf(text + used, KEYS_TEXT - used, "%s%s", k ? ", " : "", schema->keys[k].name);
    return text;
}

/* Text without any setting, as of "ggx:" or "ggx:x". */
static nqm_status fail_settings(const nqm_schema *schema, const char *settings, nqm_error *err) {
    char known[KEYS_TEXT] = "";
    return nqm_fail(err, NQM_ERR_ARG, -1, "%s: needs parameters, %s:key=value;..., not '%.40s'; the keys are %s",
                    schema->model, schema->model, settings, list_keys(schema, known));
}

static nqm_status fail_unknown(const nqm_schema *schema, const char *key, int n_key, nqm_error *err) {
    char known[KEYS_TEXT] = "", wanted[64];
    snprintf(wanted, sizeof wanted, "%.*s", n_key, key);
    nqm_nearest nearest = nqm_nearest_begin(wanted);
    for (size_t k = 0; k < schema->n_keys; ++k)
        nqm_nearest_add(&nearest, schema->keys[k].name);
    list_keys(schema, known);
    return nqm_fail(err, NQM_ERR_ARG, -1, "%s: there is no key '%s'%s; the keys are %s", schema->model, wanted,
                    nearest.advice, known);
}

static nqm_status fail_value(const nqm_schema *schema, const nqm_schema_key *key, const char *text, nqm_error *err) {
    char low[32], high[32];
    return nqm_fail(err, NQM_ERR_ARG, -1, "%s: %s needs %s from %s to %s, not '%.*s'", schema->model, key->name,
                    key->n == 3  ? "one number or three separated by commas, each"
                    : key->n > 1 ? "one number or two separated by a comma, each"
                    : key->whole ? "a whole number"
                                 : "one number",
                    nqm_format_double(low, sizeof low, key->low), nqm_format_double(high, sizeof high, key->high),
                    (int)strcspn(text, ";") < 40 ? (int)strcspn(text, ";") : 40, text);
}

static bool in_range(const nqm_schema_key *key, double v) {
    return v >= key->low && v <= key->high && (!key->whole || v == floor(v));
}

/* Parse "v", or as many values as the key has, up to the end of the setting; false when it is anything else. */
static bool parse_values(const nqm_schema_key *key, const char *text, const char **end, double v[3]) {
    size_t n = 0;
    do {
        if (n == key->n || !nqm_parse_double(text, &text, &v[n]) || !in_range(key, v[n]))
            return false;
        ++n;
    } while (*text++ == ',');
    *end = text - 1;
    for (size_t c = n; c < 3; ++c)
        v[c] = v[n - 1];
    return (n == 1 || n == key->n) && (**end == ';' || **end == 0);
}

/* Parse the setting at `text`; *end receives a pointer to its end. */
static nqm_status parse_setting(const nqm_schema *schema, const char *text, const char **end, nqm_values *values,
                                nqm_error *err) {
    size_t n_name = strcspn(text, "=;");
    if (text[n_name] != '=')
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s: expected key=value, not '%.*s'", schema->model,
                        n_name < 40 ? (int)n_name : 40, text);
    const size_t k = nqm_schema_key_named(schema, text, n_name);
    if (k == schema->n_keys)
        return fail_unknown(schema, text, n_name < 40 ? (int)n_name : 40, err);
    if (values->given >> k & 1)
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s: %s is given twice", schema->model, schema->keys[k].name);
    if (!parse_values(&schema->keys[k], text + n_name + 1, end, values->v[k]))
        return fail_value(schema, &schema->keys[k], text + n_name + 1, err);
    values->given |= UINT64_C(1) << k;
    return NQM_OK;
}

static nqm_status find_missing(const nqm_values *values, nqm_error *err) {
    const nqm_schema *schema = values->schema;
    for (size_t k = 0; k < schema->n_keys; ++k)
        if (schema->keys[k].required && !(values->given >> k & 1))
            return nqm_fail(err, NQM_ERR_ARG, -1, "%s: %s is missing", schema->model, schema->keys[k].name);
    return NQM_OK;
}

nqm_status nqm_values_parse(const nqm_schema *schema, const char *text, nqm_values *values, nqm_error *err) {
    *values = nqm_values_of(schema);
    if (!strchr(text, '=') && (*text || find_missing(values, NULL) != NQM_OK))
        return fail_settings(schema, text, err);
    while (*text) {
        nqm_status status = parse_setting(schema, text, &text, values, err);
        if (status != NQM_OK)
            return status;
        text += *text == ';'; /* a trailing semicolon is allowed */
    }
    return find_missing(values, err);
}

nqm_status nqm_values_parse_spec(const char *spec, nqm_values *values, nqm_error *err) {
    const size_t n = strcspn(spec, ":");
    const nqm_schema *schema = spec[n] ? nqm_schema_find(spec, n) : NULL;
    if (!schema)
        return nqm_fail(err, NQM_ERR_ARG, -1, "%.200s: not a spec of a shading model (MODEL:key=value;...)", spec);
    return nqm_values_parse(schema, spec + n + 1, values, err);
}

nqm_status nqm_values_check(const nqm_values *values, nqm_error *err) {
    for (size_t k = 0; k < values->schema->n_keys; ++k) {
        const nqm_schema_key *key = &values->schema->keys[k];
        char text[3 * NUMBER_SIZE];
        size_t c = 0;
        while (c < key->n && in_range(key, values->v[k][c]))
            ++c;
        if (values->given >> k & 1 && c < key->n)
            return fail_value(values->schema, key, format_values(key, values->v[k], text), err);
    }
    return find_missing(values, err);
}

/* ---- canonical form ---------------------------------------------------------------------------------------------- */

char *nqm_values_spec(const nqm_values *values) {
    const nqm_schema *schema = values->schema;
    size_t size = strlen(schema->model) + 2 + schema->n_keys * SETTING_SIZE;
    char *text = nqm_alloc(size, 1), numbers[3 * NUMBER_SIZE];
    if (!text)
        return NULL;
    size_t used = (size_t)snprintf(text, size, "%s:", schema->model);
    const char *separator = "";
    for (size_t k = 0; k < schema->n_keys; ++k) {
        if (!(values->given >> k & 1))
            continue;
        used += (size_t)snprintf(text + used, size - used, "%s%s=%s", separator, schema->keys[k].name,
                                 format_values(&schema->keys[k], values->v[k], numbers));
        separator = ";";
    }
    return text;
}
