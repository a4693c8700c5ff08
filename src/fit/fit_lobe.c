/* SPDX-License-Identifier: MIT
 *
 * The two parts of an analytic model at fixed directions: its base with kd = 1 and its lobe with ks = 1, and the
 * derivatives of the lobe by the positions of its shape in their ranges.
 */
#include "fit/fit.h"

#include <math.h>

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

static nqm_status eval_shape(nqm_fit_lobes *lobes, const double *shape, double *part, nqm_error *err) {
    nqm_fit_values unit = {.ks = {1, 1, 1}};
    memcpy(unit.shape, shape, lobes->model->n_shape * sizeof *shape);
    return eval_part(lobes, &unit, part, err);
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
    return eval_shape(lobes, shape, lobes->lobe, err);
}

void nqm_fit_lobes_combine(const nqm_fit_lobes *lobes, const nqm_fit_values *v, double *rgb) {
    for (size_t i = 0; i < lobes->n; ++i)
        for (size_t c = 0; c < 3; ++c)
            rgb[3 * i + c] = v->kd[c] * lobes->diffuse[i] + v->ks[c] * lobes->lobe[i];
}

nqm_status nqm_fit_lobes_slope(nqm_fit_lobes *lobes, size_t k, double *slope, double *scratch, nqm_error *err) {
    const double step = 1e-5; /* of the position in the range */
    const nqm_fit_shape *range = &lobes->model->shape[k];
    double position = nqm_fit_shape_position(range, lobes->shape[k]);
    double low[NQM_FIT_MAX_SHAPE], high[NQM_FIT_MAX_SHAPE];
    memcpy(low, lobes->shape, sizeof low);
    memcpy(high, lobes->shape, sizeof high);
    double before = fmax(position - step, 0), after = fmin(position + step, 1);
    low[k] = nqm_fit_shape_value(range, before);
    high[k] = nqm_fit_shape_value(range, after);
    nqm_status status = eval_shape(lobes, high, slope, err);
    if (status == NQM_OK)
        status = eval_shape(lobes, low, scratch, err);
    for (size_t i = 0; status == NQM_OK && i < lobes->n; ++i)
        slope[i] = (slope[i] - scratch[i]) / (after - before);
    return status;
}
