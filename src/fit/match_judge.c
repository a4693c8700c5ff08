/* SPDX-License-Identifier: MIT
 *
 * Delta-E on random rays of a scene, which judges fits: no step of an optimiser has seen these directions.
 */
#include "fit/match.h"

#include <math.h>

enum { N_RAYS = 32768 };

static double evaluate(void *user, const double *rgb, double *gradient) {
    nqm_match_judge *j = user;
    nqm_label label;
    return nqm_rays_compare(&j->rays, j->ref, rgb, &label, gradient, &j->failure) == NQM_OK ? label.delta_e : NAN;
}

nqm_status nqm_match_judge_make(const nqm_scene *scene, const nqm_brdf *ref, uint64_t seed, nqm_match_judge *judge,
                                nqm_error *err) {
    *judge = (nqm_match_judge){.ref = NULL};
    nqm_status status = nqm_rays_draw(scene, N_RAYS, seed, &judge->rays, err);
    if (status != NQM_OK)
        return status;
    const nqm_rays *rays = &judge->rays;
    judge->visual = (nqm_fit_visual){.n = rays->n, .wi = rays->wi, .wo = rays->wo, .eval = evaluate, .user = judge};
    uint8_t *flag;
    status = nqm_alloc_arrays(
        NQM_ARRAYS({&judge->ref, rays->n, 3 * sizeof *judge->ref}, {&flag, rays->n, sizeof *flag}), err);
    if (status != NQM_OK)
        return status;
    nqm_brdf_eval(ref, rays->n, rays->wi, rays->wo, judge->ref, flag);
    for (size_t i = 0; i < 3 * rays->n; ++i)
        if (!nqm_has_value(flag[i / 3])) /* the ray is left out, as in the fits */
            rays->weight[i] = 0;
    return NQM_OK;
}

void nqm_match_judge_free(nqm_match_judge *judge) {
    nqm_rays_clear(&judge->rays);
    nqm_free(judge->ref);
}
