/* SPDX-License-Identifier: MIT
 *
 * Values from which the search for the best fit starts.
 */
#include "fit/fit.h"

#include <math.h>

static void set_all(const nqm_fit_space *space, nqm_spec_values *values, size_t key, double v) {
    nqm_fit_set(space, values, key, (const double[3]){v, v, v});
}

static bool start_analytic(const nqm_fit_space *space, size_t i, size_t n_widths, nqm_spec_values *values) {
    static const double low = 0.001, high = 0.8;
    const nqm_fit_entry *entry = space->entry;
    const double u = ((double)(i / entry->n_start) + 0.5) / (double)n_widths;
    double shape[NQM_FIT_MAX_SHAPE];
    if (i >= n_widths * entry->n_start)
        return false;
    entry->start(low * pow(high / low, u), i % entry->n_start, shape);
    *values = space->defaults;
    for (size_t k = 0; k < entry->n_shape; ++k)
        set_all(space, values, nqm_fit_key(&space->model->schema, entry->shape[k].key), shape[k]);
    return true;
}

static void start_layer(const nqm_fit_space *space, size_t layer, nqm_spec_values *values) {
    const nqm_spec_schema *schema = &space->model->schema;
    set_all(space, values, nqm_fit_layer_key(schema, layer, "roughness"), nqm_fit_layer_width(schema, layer));
    set_all(space, values, nqm_fit_layer_key(schema, layer, "gloss"), 0.8);
}

bool nqm_fit_start(const nqm_fit_space *space, size_t i, size_t n_widths, const double *diffuse, const double *albedo,
                   nqm_spec_values *values) {
    static const double widths[NQM_FIT_N_WIDTHS] = {0.1, 0.3, 0.6};
    const nqm_spec_schema *schema = &space->model->schema;
    const size_t width = nqm_fit_base_key(schema, NQM_FIT_BASE_WIDTH);
    const size_t metal = nqm_fit_base_key(schema, NQM_FIT_BASE_METAL);
    const bool is_metallic = i / NQM_FIT_N_WIDTHS == 1;
    if (space->entry->n_shape)
        return start_analytic(space, i, n_widths, values);
    if (i >= NQM_FIT_N_WIDTHS * (metal < schema->n_keys ? 2 : 1))
        return false;
    double r = widths[i % NQM_FIT_N_WIDTHS];
    if (width < schema->n_keys && strcmp(schema->keys[width].name, "alpha") == 0)
        r *= r;
    *values = space->defaults;
    for (size_t k = 0; k < schema->n_keys; ++k)
        if (nqm_fit_is_layer(&schema->keys[k]))
            start_layer(space, k, values);
    set_all(space, values, width, r);
    set_all(space, values, metal, is_metallic);
    nqm_fit_set(space, values, nqm_fit_base_key(schema, NQM_FIT_BASE_COLOR), is_metallic ? albedo : diffuse);
    return true;
}

bool nqm_fit_add_layer(const nqm_fit_space *space, size_t i, bool rough, nqm_spec_values *values) {
    const nqm_spec_schema *schema = &space->model->schema;
    const size_t base = nqm_fit_base_key(schema, NQM_FIT_BASE_WIDTH);
    size_t k = 0;
    while (k < schema->n_keys && (!nqm_fit_is_layer(&schema->keys[k]) || i-- > 0))
        ++k;
    if (space->entry->n_shape || k == schema->n_keys)
        return false;
    if (rough && base < schema->n_keys)
        set_all(space, values, base, fmin(3 * values->v[base][0], 0.8));
    set_all(space, values, k, 0.3);
    start_layer(space, k, values);
    return true;
}
