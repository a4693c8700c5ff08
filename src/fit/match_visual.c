/* SPDX-License-Identifier: MIT
 *
 * Differences as losses of fits: the scores and gradients of nqm_score_grad() at the directions of a model, and Delta-E on random
 * rays of a scene. Directions at which the reference has no value are left out.
 */
#include "brdf/brdf.h"
#include "fit/fit.h"

#include <math.h>

static nqm_status score(nqm_match_visual *v, double *value, nqm_error *err) {
    const nqm_sample_pair pair = {.ref = v->ref, .test = v->test, .used = v->used};
    return nqm_score_grad(v->scorer, v->quantity, 1, &pair, value, v->slopes, err);
}

static double evaluate(void *user, const double *rgb, double *gradient) {
    nqm_match_visual *v = user;
    size_t n = 3 * v->visual.n;
    double value;
    for (size_t i = 0; i < n; ++i)
        v->test[i] = v->used[i / 3] ? (float)rgb[i] : 0;
    if (score(v, &value, &v->failure) != NQM_OK)
        return NAN;
    double sign = v->quantity == NQM_SCORE_JOD ? -1 : 1;
    for (size_t i = 0; i < n; ++i)
        gradient[i] = sign * (double)v->slopes[i];
    return v->quantity == NQM_SCORE_JOD ? 10 - value : value;
}

/* The reference at the directions of the model, of which enough must have a value. */
static nqm_status sample(const nqm_model *model, const nqm_brdf *ref, double min_valid, nqm_match_visual *v,
                         nqm_error *err) {
    const nqm_model_info info = nqm_model_get_info(model);
    const double *wi = nqm_directions_get_info(info.directions).wi, *wo = nqm_directions_get_info(info.directions).wo;
    size_t n_used = 0;
    nqm_status status = nqm_sample(ref, info.directions, NQM_INVALID_DROP, v->ref, v->used, NULL, err);
    for (size_t i = 0; i < v->visual.n; ++i)
        n_used += v->used[i] = nqm_has_value(v->used[i]) && wi[3 * i + 2] > 0 && wo[3 * i + 2] > 0;
    if (status == NQM_OK && (double)n_used >= min_valid * (double)v->visual.n)
        return NQM_OK;
    return nqm_fail(
        err, NQM_ERR_INCOMPATIBLE, -1,
        "%s: values at only %zu of the %zu directions of the model '%s'; the loss auto or ma_crwe uses those "
        "that there are",
        nqm_brdf_get_info(ref).name, n_used, v->visual.n, info.id);
}

nqm_status nqm_match_visual_make(const nqm_model *model, const nqm_brdf *ref, nqm_match_visual *v, nqm_error *err) {
    const nqm_directions *directions = nqm_model_get_info(model).directions;
    size_t n = nqm_directions_get_info(directions).n;
    nqm_score_options options = nqm_score_options_default();
    options.metrics = 0;
    *v = (nqm_match_visual){.quantity = NQM_SCORE_DELTA_E};
    if (nqm_brdf_anisotropy(ref) > 0)
        return nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1,
                        "%s: anisotropic; the losses 'nqm' and 'transport' are made for isotropic BRDFs: use 'auto', "
                        "or a loss of values, as 'ma_crwe'",
                        nqm_brdf_get_info(ref).name);
    nqm_status status = nqm_alloc_arrays(NQM_ARRAYS({&v->ref, n, 3 * sizeof(float)}, {&v->test, n, 3 * sizeof(float)},
                                                    {&v->slopes, n, 3 * sizeof(float)}, {&v->used, n, 1}),
                                         err);
    if (status != NQM_OK)
        return status;
    v->visual = (nqm_fit_visual){.n = n,
                                 .wi = nqm_directions_get_info(directions).wi,
                                 .wo = nqm_directions_get_info(directions).wo,
                                 .eval = evaluate,
                                 .user = v};
    status = sample(model, ref, options.min_valid_fraction, v, err);
    if (status == NQM_OK)
        status = nqm_scorer_create(model, &options, &v->scorer, err);
    if (status != NQM_OK)
        return status;
    /* The reference against itself shows whether the model predicts a Delta-E. */
    double value;
    nqm_error fault = {0};
    memcpy(v->test, v->ref, 3 * n * sizeof *v->test);
    if (score(v, &value, &fault) == NQM_ERR_ARG)
        v->quantity = NQM_SCORE_JOD;
    return score(v, &value, err);
}

/* ---- rays of a scene --------------------------------------------------------------------------------------------- */

static double compare_rays(void *user, const double *rgb, double *gradient) {
    nqm_match_visual *v = user;
    nqm_label label;
    return nqm_rays_compare(&v->rays, v->ref_rgb, rgb, &label, gradient, &v->failure) == NQM_OK ? label.delta_e : NAN;
}

nqm_status nqm_match_rays_make(const nqm_scene *scene, const nqm_brdf *ref, size_t n, uint64_t seed,
                               nqm_match_visual *v, nqm_error *err) {
    *v = (nqm_match_visual){.scorer = NULL};
    nqm_status status = nqm_rays_draw(scene, n, seed, &v->rays, err);
    if (status != NQM_OK)
        return status;
    const nqm_rays *rays = &v->rays;
    v->visual = (nqm_fit_visual){.n = rays->n, .wi = rays->wi, .wo = rays->wo, .eval = compare_rays, .user = v};
    uint8_t *flag;
    status = nqm_alloc_arrays(
        NQM_ARRAYS({&v->ref_rgb, rays->n, 3 * sizeof *v->ref_rgb}, {&flag, rays->n, sizeof *flag}), err);
    if (status != NQM_OK)
        return status;
    nqm_brdf_eval(ref, rays->n, rays->wi, rays->wo, v->ref_rgb, flag);
    for (size_t i = 0; i < 3 * rays->n; ++i)
        if (!nqm_has_value(flag[i / 3])) /* the ray is left out, as in the fits */
            rays->weight[i] = 0;
    return NQM_OK;
}

void nqm_match_visual_free(nqm_match_visual *v) {
    nqm_scorer_free(v->scorer);
    nqm_free(v->ref);
    nqm_rays_clear(&v->rays);
    nqm_free(v->ref_rgb);
}
