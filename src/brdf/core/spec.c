/* SPDX-License-Identifier: MIT
 *
 * Specs: parsing against a model's list of keys, the canonical form, and derivatives by the keys' values as differences.
 */
#include "brdf/core/spec.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

/* ---- parsing ----------------------------------------------------------------------------------------------------- */

enum { KEYS_TEXT = 384 };

/* "kd, ks, alpha" */
static const char *list_keys(const nqm_spec_schema *schema, char text[KEYS_TEXT]) {
    size_t used = 0;
    for (size_t k = 0; k < schema->n_keys && used < KEYS_TEXT; ++k)
        used += (size_t)snprintf(text + used, KEYS_TEXT - used, "%s%s", k ? ", " : "", schema->keys[k].name);
    return text;
}

/* Text without any setting, as of "ggx:" or "ggx:x". */
static nqm_status fail_settings(const nqm_spec_schema *schema, const char *settings, nqm_error *err) {
    char known[KEYS_TEXT] = "";
    return nqm_fail(err, NQM_ERR_ARG, -1, "%s: needs parameters, %s:key=value;..., not '%.40s'; the keys are %s",
                    schema->model, schema->model, settings, list_keys(schema, known));
}

static nqm_status fail_unknown(const nqm_spec_schema *schema, const char *key, int n_key, nqm_error *err) {
    char known[KEYS_TEXT] = "", wanted[64];
    snprintf(wanted, sizeof wanted, "%.*s", n_key, key);
    nqm_nearest nearest = nqm_nearest_begin(wanted);
    for (size_t k = 0; k < schema->n_keys; ++k)
        nqm_nearest_add(&nearest, schema->keys[k].name);
    list_keys(schema, known);
    return nqm_fail(err, NQM_ERR_ARG, -1, "%s: there is no key '%s'%s; the keys are %s", schema->model, wanted,
                    nearest.advice, known);
}

static nqm_status fail_value(const nqm_spec_schema *schema, const nqm_spec_key *key, const char *text, nqm_error *err) {
    char low[32], high[32];
    return nqm_fail(err, NQM_ERR_ARG, -1, "%s: %s needs %s from %s to %s, not '%.*s'", schema->model, key->name,
                    key->n == 3  ? "one number or three separated by commas, each"
                    : key->n > 1 ? "one number or two separated by a comma, each"
                    : key->whole ? "a whole number"
                                 : "one number",
                    nqm_format_double(low, sizeof low, key->low), nqm_format_double(high, sizeof high, key->high),
                    (int)strcspn(text, ";") < 40 ? (int)strcspn(text, ";") : 40, text);
}

static bool in_range(const nqm_spec_key *key, double v) {
    return v >= key->low && v <= key->high && (!key->whole || v == floor(v));
}

/* Parse "v", or as many values as the key has, up to the end of the setting; false when it is anything else. */
static bool parse_values(const nqm_spec_key *key, const char *text, const char **end, double v[3]) {
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
static nqm_status parse_setting(const nqm_spec_schema *schema, const char *text, const char **end,
                                nqm_spec_values *values, nqm_error *err) {
    size_t n_name = strcspn(text, "=;");
    if (text[n_name] != '=')
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s: expected key=value, not '%.*s'", schema->model,
                        n_name < 40 ? (int)n_name : 40, text);
    size_t k = 0;
    while (k < schema->n_keys &&
           !(strlen(schema->keys[k].name) == n_name && !strncmp(schema->keys[k].name, text, n_name)))
        ++k;
    if (k == schema->n_keys)
        return fail_unknown(schema, text, n_name < 40 ? (int)n_name : 40, err);
    if (values->given >> k & 1)
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s: %s is given twice", schema->model, schema->keys[k].name);
    if (!parse_values(&schema->keys[k], text + n_name + 1, end, values->v[k]))
        return fail_value(schema, &schema->keys[k], text + n_name + 1, err);
    values->given |= UINT64_C(1) << k;
    return NQM_OK;
}

static bool has_defaults(const nqm_spec_schema *schema) {
    size_t k = 0;
    while (k < schema->n_keys && !schema->keys[k].required)
        ++k;
    return k == schema->n_keys;
}

nqm_status nqm_spec_parse(const nqm_spec_schema *schema, const char *text, nqm_spec_values *values, nqm_error *err) {
    *values = (nqm_spec_values){.given = 0};
    if (!strchr(text, '=') && (*text || !has_defaults(schema)))
        return fail_settings(schema, text, err);
    while (*text) {
        nqm_status status = parse_setting(schema, text, &text, values, err);
        if (status != NQM_OK)
            return status;
        text += *text == ';'; /* a trailing semicolon is allowed */
    }
    for (size_t k = 0; k < schema->n_keys; ++k) {
        const nqm_spec_key *key = &schema->keys[k];
        if (values->given >> k & 1)
            continue;
        if (key->required)
            return nqm_fail(err, NQM_ERR_ARG, -1, "%s: %s is missing", schema->model, key->name);
        values->v[k][0] = values->v[k][1] = values->v[k][2] = key->fallback;
    }
    return NQM_OK;
}

/* ---- canonical form ---------------------------------------------------------------------------------------------- */

enum { NUMBER_SIZE = 32, KEY_SIZE = 3 * NUMBER_SIZE + 16 };

/* Whether one number is written for all values of the key. */
static bool is_one_number(const nqm_spec_key *key, const double v[3]) {
    size_t c = 1;
    while (c < key->n && v[c] == v[0])
        ++c;
    return c >= key->n;
}

static size_t format_setting(char *text, size_t n_text, const nqm_spec_key *key, const double v[3]) {
    char numbers[3 * NUMBER_SIZE];
    nqm_format_doubles(numbers, sizeof numbers, is_one_number(key, v) ? 1 : key->n, v, ",");
    return (size_t)snprintf(text, n_text, "%s=%s", key->name, numbers);
}

char *nqm_spec_format(const nqm_spec_schema *schema, const nqm_spec_values *values) {
    size_t size = strlen(schema->model) + 2 + schema->n_keys * KEY_SIZE;
    char *text = nqm_alloc(size, 1);
    if (!text)
        return NULL;
    size_t used = (size_t)snprintf(text, size, "%s:", schema->model);
    const char *separator = "";
    for (size_t k = 0; k < schema->n_keys; ++k) {
        if (!(values->given >> k & 1))
            continue;
        used += (size_t)snprintf(text + used, size - used, "%s", separator);
        used += format_setting(text + used, size - used, &schema->keys[k], values->v[k]);
        separator = ";";
    }
    return text;
}

bool nqm_spec_is_isotropic(const nqm_spec_schema *schema, const nqm_spec_values *values) {
    bool is_isotropic = true;
    for (size_t k = 0; k < schema->n_keys; ++k) {
        const nqm_spec_key *key = &schema->keys[k];
        is_isotropic &= (key->n != 2 || is_one_number(key, values->v[k])) && !(key->turns && values->v[k][0] != 0);
    }
    return is_isotropic;
}

/* ---- derivatives by differences ---------------------------------------------------------------------------------- */

enum { MAX_PAIRS = 64 };

/* The derivative by a value of a key: the sum of f_r at two changed values times weights, and times `own` at the value itself. */
typedef struct stencil {
    double v[2], weight[2], own;
} stencil;

static stencil stencil_at(const nqm_spec_key *key, double v) {
    const double step = 1e-5 * fmin(1, key->high - key->low);
    const double side = v - step < key->low ? 1 : v + step > key->high ? -1 : 0;
    if (side == 0)
        return (stencil){{v + step, v - step}, {0.5 / step, -0.5 / step}, 0};
    return (stencil){{v + side * step, v + side * 2 * step}, {side * 2 / step, side * -0.5 / step}, side * -1.5 / step};
}

/* Prepare the state with another value of a key. */
static void prepare_changed(const nqm_spec_state *state, size_t key, size_t channel, double v, void *changed) {
    nqm_spec_values values = state->values;
    for (size_t c = 0; c < 3; ++c)
        if (c == channel || state->model->schema.keys[key].n == 1)
            values.v[key][c] = v;
    *(nqm_spec_state *)changed = (nqm_spec_state){state->model, values};
    state->model->prepare(&values, changed);
}

/* Add weight * rgb (n, 3) to a column of a Jacobian of n_columns. */
static void add_to_column(size_t n, double weight, const double *rgb, size_t n_columns, double *column) {
    for (size_t i = 0; i < 3 * n; ++i)
        column[i * n_columns] += weight * rgb[i];
}

void nqm_spec_jacobian(const void *self, size_t n, const double *wi, const double *wo, double *rgb, double *jacobian) {
    const nqm_spec_state *state = self;
    const nqm_spec_schema *schema = &state->model->schema;
    _Alignas(max_align_t) char changed[NQM_SPEC_MAX_STATE];
    double near[3 * MAX_PAIRS];
    size_t n_columns = 0;
    for (size_t k = 0; k < schema->n_keys; ++k)
        n_columns += schema->keys[k].n;
    state->model->class_.eval(self, n, wi, wo, rgb);
    for (size_t k = 0; k < schema->n_keys; ++k)
        for (size_t c = 0; c < schema->keys[k].n; ++c, ++jacobian) {
            const stencil s = stencil_at(&schema->keys[k], state->values.v[k][c]);
            for (int p = 0; p < 2; ++p) {
                prepare_changed(state, k, c, s.v[p], changed);
                state->model->class_.eval(changed, n, wi, wo, near);
                add_to_column(n, s.weight[p], near, n_columns, jacobian);
            }
            if (s.own != 0)
                add_to_column(n, s.own, rgb, n_columns, jacobian);
        }
}
