/* SPDX-License-Identifier: MIT
 *
 * Derivatives of models by the values of their keys, as differences.
 */
#include "brdf/core/spec.h"

#include <math.h>

enum { MAX_PAIRS = 64 };

/* The derivative by a value of a key: the sum of f_r at two changed values times weights, and times `own` at the value itself. */
typedef struct stencil {
    double v[2], weight[2], own;
} stencil;

static stencil stencil_at(const nqm_schema_key *key, double v) {
    const double step = 1e-5 * fmin(1, key->high - key->low);
    const double side = v - step < key->low ? 1 : v + step > key->high ? -1 : 0;
    if (side == 0)
        return (stencil){{v + step, v - step}, {0.5 / step, -0.5 / step}, 0};
    return (stencil){{v + side * step, v + side * 2 * step}, {side * 2 / step, side * -0.5 / step}, side * -1.5 / step};
}

/* Prepare the state with another value of a key. */
static void prepare_changed(const nqm_spec_state *state, size_t key, size_t channel, double v, void *changed) {
    nqm_values values = state->values;
    for (size_t c = 0; c < 3; ++c)
        if (c == channel || state->model->schema->keys[key].n == 1)
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
    const nqm_schema *schema = state->model->schema;
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
