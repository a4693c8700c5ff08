/* SPDX-License-Identifier: MIT
 *
 * Derivatives of models by the values of their keys, as differences; and BRDFs made of other BRDFs, of their opened bases.
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

static void free_owned(const nqm_between_bases *bases) {
    if (bases->owns_of)
        nqm_brdf_free(bases->of);
    if (bases->owns_with)
        nqm_brdf_free(bases->with);
}

void nqm_wrapper_free(void *state) {
    free_owned(state);
    nqm_free(state);
}

/* The spec of a base, or its name when it is a file. */
static const char *spec_of(const nqm_brdf *brdf) {
    return brdf->info.spec ? brdf->info.spec : brdf->info.name;
}

/* nqm_free(); NULL when out of memory. */
static char *canonical_spec(const nqm_values *values, const nqm_between_bases *bases) {
    const char *of = spec_of(bases->of), *with = bases->with ? spec_of(bases->with) : "";
    char *own = nqm_values_spec(values);
    char *spec = own ? nqm_strdupf("%s%s%s%s;of=%s", own, *with ? ";with=(" : "", with, *with ? ")" : "", of) : NULL;
    nqm_free(own);
    return spec;
}

nqm_status nqm_wrapper_parse(const nqm_spec_wrapper *w, const char *settings, nqm_values *values, nqm_error *err) {
    nqm_status status = nqm_values_parse(&w->schema, settings, values, err);
    if (status == NQM_OK && !(values->given & ~w->idle))
        status = nqm_fail(err, NQM_ERR_ARG, -1,
                          "%s: nothing is changed: give scale, tint, gloss, peak, ... before 'of='", w->schema.model);
    return status;
}

nqm_status nqm_wrapper_make(const nqm_spec_wrapper *w, const nqm_values *values, const nqm_between_bases *bases,
                            const char *name, nqm_brdf **brdf_ret, nqm_error *err) {
    const nqm_brdf_info *of = &bases->of->info, *with = bases->with ? &bases->with->info : NULL;
    char layout[160], remark[NQM_REMARK_SIZE] = "", *spec = canonical_spec(values, bases);
    nqm_brdf_info info = {.name = name ? name : spec, .spec = spec, .layout = layout, .remark = remark};
    info.source_doi = with ? NULL : of->source_doi;
    info.reciprocal = of->reciprocal && (!with || with->reciprocal);
    info.isotropic = of->isotropic && (!with || with->isotropic);
    if (with)
        snprintf(layout, sizeof layout, "of %s with %s", of->format, with->format);
    else
        snprintf(layout, sizeof layout, "over %s, %.100s", of->format, of->layout ? of->layout : "");
    for (size_t i = 0; i < 2; ++i)
        if ((i ? with : of) && (i ? with : of)->remark)
            nqm_remark_add(remark, sizeof remark, "%s", (i ? with : of)->remark);
    void *state = NULL;
    *brdf_ret = NULL;
    nqm_status status = spec ? w->create(values, bases, &info, &state, err) : nqm_fail_nomem(err, sizeof layout);
    if (status == NQM_OK) {
        *(nqm_between_bases *)state = *bases;
        status = nqm_brdf_wrap(&w->class_, state, &info, brdf_ret, err);
    } else {
        free_owned(bases);
    }
    nqm_free(spec);
    return status;
}
