/* SPDX-License-Identifier: MIT
 *
 * Values from which the search for the best fit starts.
 */
#include "fit/fit.h"

#include <math.h>
#include <string.h>

/* ---- what the roles of keys mean to a search: bounds, scale, and which keys it leaves alone ---------------------- */

static bool is_index_of_refraction(nqm_role role) {
    return role == NQM_ROLE_IOR || role == NQM_ROLE_COAT_IOR || role == NQM_ROLE_FILM_IOR;
}

/* Films make f_r oscillate with their thickness: no fit finds it. */
bool nqm_fit_is_kept(const nqm_schema_key *key) {
    return key->whole || nqm_schema_is_anisotropic(key->role) || nqm_schema_is_film(key->role) ||
           key->role == NQM_ROLE_SPECULAR_LEVEL;
}

double nqm_fit_default(const nqm_schema_key *key) {
    const double value = !key->required                      ? key->fallback
                         : is_index_of_refraction(key->role) ? 1.5
                         : nqm_schema_is_width(key->role)    ? 0.3
                                                             : 0.5;
    return fmin(fmax(value, key->low), key->high);
}

/* Coordinates are scaled so that a step of 1 changes f_r by about the factor e; that of a roughness is its square, alpha. */
nqm_fit_parameter nqm_fit_describe(const nqm_schema *schema, size_t k) {
    const nqm_schema_key *key = &schema->keys[k];
    nqm_fit_parameter p = {.key = k,
                           .layer = nqm_schema_layer_of(schema, k),
                           .low = key->low,
                           .high = key->high,
                           .units = 1,
                           .is_log = true};
    double offset = 0.05; /* of the logarithm, from the lower end */
    if (is_index_of_refraction(key->role)) {
        p.low = fmax(key->low, 1);
        p.high = fmin(key->high, 5);
        p.units = 4;
        offset = p.low;
    } else if (key->unit == NQM_UNIT_GLOSS) {
        p.units = 4;
        p.is_log = false;
    } else if (key->unit == NQM_UNIT_ALPHA) {
        offset = 4e-4;
    } else if (nqm_schema_is_width(key->role)) {
        p.units = 2;
        offset = 0.02;
    } else if (key->role == NQM_ROLE_METAL) {
        p.units = 2;
        p.is_log = false;
    }
    p.zero = p.low - offset;
    /* Weights and colours that renderers and their editors take, although the formats allow more. */
    if (!is_index_of_refraction(key->role) && key->fallback <= 1)
        p.high = fmin(p.high, 1);
    return p;
}

/* ---- starts ------------------------------------------------------------------------------------------------------ */

static void set_all(const nqm_fit_space *space, nqm_values *values, size_t key, double v) {
    nqm_fit_set(space, values, key, (const double[3]){v, v, v});
}

static bool start_analytic(const nqm_fit_space *space, size_t i, size_t n_widths, nqm_values *values) {
    static const double low = 0.001, high = 0.8;
    const nqm_fit_entry *entry = space->entry;
    const double u = ((double)(i / entry->n_start) + 0.5) / (double)n_widths;
    double shape[NQM_FIT_MAX_SHAPE];
    if (i >= n_widths * entry->n_start)
        return false;
    entry->start(low * pow(high / low, u), i % entry->n_start, shape);
    *values = space->defaults;
    for (size_t k = 0; k < entry->n_shape; ++k)
        set_all(space, values,
                nqm_schema_key_named(space->model->schema, entry->shape[k].key, strlen(entry->shape[k].key)), shape[k]);
    return true;
}

/* A mirror, which is the default of some layers, would have no effect at most directions. */
static void start_layer(const nqm_fit_space *space, size_t layer, nqm_values *values) {
    const nqm_schema *schema = space->model->schema;
    const bool is_coat = schema->keys[layer].role == NQM_ROLE_COAT_WEIGHT;
    const size_t width = nqm_schema_key_of(schema, is_coat ? NQM_ROLE_COAT_WIDTH : NQM_ROLE_SHEEN_WIDTH);
    if (width < schema->n_keys)
        set_all(space, values, width, schema->keys[width].unit == NQM_UNIT_GLOSS ? 0.8 : is_coat ? 0.1 : 0.4);
}

bool nqm_fit_start(const nqm_fit_space *space, size_t i, size_t n_widths, const double *diffuse, const double *albedo,
                   nqm_values *values) {
    static const double widths[NQM_FIT_N_WIDTHS] = {0.1, 0.3, 0.6};
    const nqm_schema *schema = space->model->schema;
    const size_t width = nqm_schema_key_of(schema, NQM_ROLE_WIDTH), metal = nqm_schema_key_of(schema, NQM_ROLE_METAL);
    const bool is_metallic = i / NQM_FIT_N_WIDTHS == 1;
    if (space->entry->n_shape)
        return start_analytic(space, i, n_widths, values);
    if (i >= NQM_FIT_N_WIDTHS * (metal < schema->n_keys ? 2 : 1))
        return false;
    double r = widths[i % NQM_FIT_N_WIDTHS];
    if (width < schema->n_keys && schema->keys[width].unit == NQM_UNIT_ALPHA)
        r *= r;
    *values = space->defaults;
    for (size_t k = 0; k < schema->n_keys; ++k)
        if (nqm_schema_is_layer(schema, k))
            start_layer(space, k, values);
    set_all(space, values, width, r);
    set_all(space, values, metal, is_metallic);
    nqm_fit_set(space, values, nqm_schema_key_of(schema, NQM_ROLE_BASE_COLOR), is_metallic ? albedo : diffuse);
    return true;
}

bool nqm_fit_add_layer(const nqm_fit_space *space, size_t i, bool rough, nqm_values *values) {
    const nqm_schema *schema = space->model->schema;
    const size_t base = nqm_schema_key_of(schema, NQM_ROLE_WIDTH);
    size_t k = 0;
    while (k < schema->n_keys && (!nqm_schema_is_layer(schema, k) || i-- > 0))
        ++k;
    if (space->entry->n_shape || k == schema->n_keys)
        return false;
    if (rough && base < schema->n_keys)
        set_all(space, values, base, fmin(3 * values->v[base][0], 0.8));
    set_all(space, values, k, 0.3);
    start_layer(space, k, values);
    return true;
}
