/* SPDX-License-Identifier: MIT
 *
 * azimuths.h - scores of pairs with an anisotropic BRDF, for models whose directions have one azimuth.
 */
#ifndef NQM_SRC_METRIC_AZIMUTHS_H
#define NQM_SRC_METRIC_AZIMUTHS_H

#include "metric/metric.h"

/** A scorer of the model "rays". */
typedef struct nqm_azimuths nqm_azimuths;

/** Whether the model's own directions have azimuths. */
bool nqm_model_sees_azimuths(const nqm_model *model);
/** NULL in *azimuths_ret, without an error, if the model is not one of those that predict the labels of the standard scenes. */
NQM_MUST_CHECK nqm_status nqm_azimuths_create(const nqm_model *model, const nqm_score_options *options,
                                              nqm_azimuths **azimuths_ret, nqm_error *err);
void nqm_azimuths_free(nqm_azimuths *azimuths);

/** Pairs as nqm_scorer_run_named() or nqm_scorer_run() takes them. */
typedef struct nqm_azimuth_pairs {
    const nqm_named_pair *named; /* NULL: the others */
    const nqm_brdf *ref;
    const nqm_brdf *const *tests;
} nqm_azimuth_pairs;
/** Score again those of n <= NQM_SCORE_BLOCK results whose anisotropy is above 0. azimuths NULL: they have no score
 *  (NQM_ERR_INCOMPATIBLE). */
NQM_MUST_CHECK nqm_status nqm_azimuths_score(nqm_azimuths *azimuths, size_t n, const nqm_azimuth_pairs *pairs,
                                             nqm_score_result *results, nqm_error *err);

#endif
