/* SPDX-License-Identifier: MIT
 *
 * Pairs with an anisotropic BRDF. The directions of the models "default" and "transport" have one azimuth, which is enough for isotropic
 * BRDFs; those of the model "rays" are pairs of directions of the standard scenes, with the tangents of their surfaces. So the
 * former hand such pairs to the latter; where the anisotropy is slight, the score is between both, and continuous.
 */
#include "metric/azimuths.h"

#include <math.h>
#include <string.h>

/* Anisotropy (nqm_brdf_check_report) from which on a pair has the score of "rays" alone. */
static const double plain_anisotropy = 0.1;

struct nqm_azimuths {
    nqm_model *model;
    nqm_scorer *scorer;
};

bool nqm_model_sees_azimuths(const nqm_model *model) {
    return model->directions->phi_h_deg;
}

nqm_status nqm_azimuths_create(const nqm_model *model, const nqm_score_options *options, nqm_azimuths **azimuths_ret,
                               nqm_error *err) {
    static const char *const served[] = {"default", "transport"};
    bool is_served = false;
    *azimuths_ret = NULL;
    for (size_t i = 0; i < sizeof served / sizeof *served; ++i)
        is_served |= strcmp(model->id, served[i]) == 0;
    if (!is_served)
        return NQM_OK;
    nqm_azimuths *a = nqm_alloc(1, sizeof *a);
    if (!a)
        return nqm_fail_nomem(err, sizeof *a);
    nqm_status status = nqm_model_builtin("rays", &a->model, err);
    if (status == NQM_OK)
        status = nqm_scorer_create(a->model, options, &a->scorer, err);
    if (status == NQM_OK)
        *azimuths_ret = a;
    else
        nqm_azimuths_free(a);
    return status;
}

void nqm_azimuths_free(nqm_azimuths *azimuths) {
    if (!azimuths)
        return;
    nqm_scorer_free(azimuths->scorer);
    nqm_model_free(azimuths->model);
    nqm_free(azimuths);
}

/* 0 for 0, 1 from plain_anisotropy on; smooth. */
static double weight_of(double anisotropy) {
    const double t = fmin(anisotropy / plain_anisotropy, 1);
    return t * t * (3 - 2 * t);
}

/* Members of a result that are between both. */
static const struct {
    size_t offset, n;
} blended[] = {{offsetof(nqm_score_result, jod), 1},
               {offsetof(nqm_score_result, delta_e), 1},
               {offsetof(nqm_score_result, jod_low), 1},
               {offsetof(nqm_score_result, jod_high), 1},
               {offsetof(nqm_score_result, parts), sizeof(nqm_label) / sizeof(double)},
               {offsetof(nqm_score_result, similarity), 3},
               {offsetof(nqm_score_result, metrics), NQM_METRIC_COUNT}};

/* The result keeps the counts of the model's own directions. */
static void take(const nqm_score_result *seen, nqm_score_result *result) {
    const double w = weight_of(result->anisotropy);
    if (seen->status != NQM_OK) {
        *result = nqm_no_score(seen->status);
        return;
    }
    result->identical = result->identical && seen->identical;
    for (size_t k = 0; k < sizeof blended / sizeof *blended; ++k) {
        const double *from = (const double *)((const char *)seen + blended[k].offset);
        double *to = (double *)((char *)result + blended[k].offset);
        for (size_t i = 0; i < blended[k].n; ++i)
            to[i] = w < 1 ? (1 - w) * to[i] + w * from[i] : from[i];
    }
}

nqm_status nqm_azimuths_score(nqm_azimuths *azimuths, size_t n, const nqm_azimuth_pairs *pairs,
                              nqm_score_result *results, nqm_error *err) {
    const nqm_brdf *tests[NQM_SCORE_BLOCK];
    nqm_named_pair named[NQM_SCORE_BLOCK];
    nqm_score_result seen[NQM_SCORE_BLOCK];
    size_t place[NQM_SCORE_BLOCK], m = 0;
    for (size_t i = 0; i < n; ++i) {
        if (results[i].status != NQM_OK || !(results[i].anisotropy > 0))
            continue;
        if (!azimuths) {
            results[i] = nqm_no_score(NQM_ERR_INCOMPATIBLE);
            continue;
        }
        if (pairs->named)
            named[m] = pairs->named[i];
        else
            tests[m] = pairs->tests[i];
        place[m++] = i;
    }
    nqm_status status = NQM_OK;
    if (m && pairs->named)
        status = nqm_scorer_run_named(azimuths->scorer, m, named, seen, NULL, err);
    else if (m)
        status = nqm_scorer_run(azimuths->scorer, pairs->ref, m, tests, seen, err);
    for (size_t k = 0; status == NQM_OK && k < m; ++k)
        take(&seen[k], &results[place[k]]);
    return status;
}
