/* SPDX-License-Identifier: MIT
 *
 * Values from which the search for the best fit starts.
 */
#include "fit/fit.h"

#include <math.h>
#include <string.h>

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
