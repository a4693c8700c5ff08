/* SPDX-License-Identifier: MIT
 *
 * The two parts of an analytic model at fixed directions: its base with kd = 1 and its lobe with ks = 1, and the
 * derivatives of the lobe by the positions of its shape in their ranges.
 */
#include "brdf/core/spec.h"
#include "fit/fit.h"

#include <assert.h>

nqm_status nqm_fit_eval_spec(const char *spec, size_t n, const double *wi, const double *wo, double *rgb,
                             nqm_error *err) {
    nqm_brdf *brdf;
    nqm_status status = nqm_brdf_open(spec, &brdf, err);
    if (status == NQM_OK)
        nqm_brdf_eval(brdf, n, wi, wo, rgb, NULL);
    nqm_brdf_free(brdf);
    return status;
}

/* The red channel of a model with these values: part (n). */
static nqm_status eval_part(nqm_fit_lobes *lobes, const nqm_fit_values *values, double *part, nqm_error *err) {
    char spec[512];
    nqm_fit_write_spec(lobes->model, values, spec);
    nqm_status status = nqm_fit_eval_spec(spec, lobes->n, lobes->wi, lobes->wo, lobes->rgb, err);
    for (size_t i = 0; status == NQM_OK && i < lobes->n; ++i)
        part[i] = lobes->rgb[3 * i];
    return status;
}

nqm_status nqm_fit_lobes_make(const nqm_fit_entry *model, size_t n, const double *wi, const double *wo,
                              nqm_fit_lobes *lobes, nqm_error *err) {
    *lobes = (nqm_fit_lobes){.model = model, .n = n, .wi = wi, .wo = wo};
    nqm_status status =
        nqm_alloc_arrays(NQM_ARRAYS({&lobes->rgb, n, 3 * sizeof(double)}, {&lobes->diffuse, n, sizeof(double)},
                                    {&lobes->lobe, n, sizeof(double)}),
                         err);
    if (status != NQM_OK)
        return status;
    nqm_fit_values base = {.kd = {1, 1, 1}};
    for (size_t k = 0; k < model->n_shape; ++k)
        base.shape[k] = nqm_fit_shape_value(&model->shape[k], 0.5);
    return eval_part(lobes, &base, lobes->diffuse, err);
}

nqm_status nqm_fit_lobes_set(nqm_fit_lobes *lobes, const double *shape, nqm_error *err) {
    size_t n_bytes = lobes->model->n_shape * sizeof *shape;
    if (memcmp(lobes->shape, shape, n_bytes) == 0)
        return NQM_OK;
    memcpy(lobes->shape, shape, n_bytes);
    nqm_fit_values unit = {.ks = {1, 1, 1}};
    memcpy(unit.shape, shape, n_bytes);
    return eval_part(lobes, &unit, lobes->lobe, err);
}

void nqm_fit_lobes_combine(const nqm_fit_lobes *lobes, const nqm_fit_values *v, double *rgb) {
    for (size_t i = 0; i < lobes->n; ++i)
        for (size_t c = 0; c < 3; ++c)
            rgb[3 * i + c] = v->kd[c] * lobes->diffuse[i] + v->ks[c] * lobes->lobe[i];
}

/* Where a key is among the parameters of nqm_brdf_jacobian(): the first of an RGB key, whose lobe is the red channel. */
static size_t parameter_index(const nqm_spec_schema *schema, const char *key) {
    size_t index = 0;
    for (size_t k = 0; strcmp(schema->keys[k].name, key) != 0; ++k)
        index += schema->keys[k].n;
    return index;
}

nqm_status nqm_fit_lobes_slopes(nqm_fit_lobes *lobes, double *slopes, nqm_error *err) {
    enum { CHUNK = 64, MAX_PARAMETERS = 16 };
    const nqm_fit_entry *model = lobes->model;
    double jacobian[CHUNK * 3 * MAX_PARAMETERS], rgb[CHUNK * 3], scale[NQM_FIT_MAX_SHAPE];
    size_t index[NQM_FIT_MAX_SHAPE], n = lobes->n;
    char spec[512];
    nqm_brdf *brdf;
    nqm_fit_values unit = {.ks = {1, 1, 1}};
    memcpy(unit.shape, lobes->shape, sizeof unit.shape);
    nqm_fit_write_spec(model, &unit, spec);
    nqm_status status = nqm_brdf_open(spec, &brdf, err);
    if (status != NQM_OK)
        return status;
    size_t n_parameters = nqm_brdf_get_info(brdf).n_values;
    assert(n_parameters <= MAX_PARAMETERS);
    for (size_t k = 0; k < model->n_shape; ++k) {
        index[k] =
            parameter_index(&nqm_analytic_model_find(model->name, strlen(model->name))->schema, model->shape[k].key);
        scale[k] = nqm_fit_shape_derivative(&model->shape[k], lobes->shape[k]);
    }
    for (size_t begin = 0; status == NQM_OK && begin < n; begin += CHUNK) {
        size_t count = nqm_smaller(CHUNK, n - begin);
        status = nqm_brdf_jacobian(brdf, count, lobes->wi + 3 * begin, lobes->wo + 3 * begin, rgb, jacobian, err);
        for (size_t k = 0; k < model->n_shape; ++k)
            for (size_t i = 0; i < count; ++i)
                slopes[k * n + begin + i] = jacobian[i * 3 * n_parameters + index[k]] * scale[k];
    }
    nqm_brdf_free(brdf);
    return status;
}
