/* SPDX-License-Identifier: MIT
 *
 * azimuths.h - scores of pairs with an anisotropic BRDF, for models whose directions have one azimuth.
 */
#ifndef NQM_SRC_METRIC_AZIMUTHS_H
#define NQM_SRC_METRIC_AZIMUTHS_H

#include "brdf/brdf.h"
#include "metric/metric.h"

/** The model "anisotropic". */
typedef struct nqm_azimuths nqm_azimuths;

/** NULL in *azimuths_ret, without an error, if the model is none for anisotropic BRDFs and not the built-in "default" or
 *  "transport": it may predict labels of other scenes. The model must outlive it. */
NQM_MUST_CHECK nqm_status nqm_azimuths_create(const nqm_model *model, nqm_azimuths **azimuths_ret, nqm_error *err);
void nqm_azimuths_free(nqm_azimuths *azimuths);

/** Pairs as nqm_scorer_run_named() or nqm_scorer_run() takes them. */
typedef struct nqm_azimuth_pairs {
    const nqm_named_pair *named; /* NULL: the others */
    const nqm_brdf *ref;
    const nqm_brdf *const *tests;
} nqm_azimuth_pairs;
/** Whether a result of the model must be replaced. */
bool nqm_azimuths_needed(const nqm_model *model, const nqm_score_result *result);
/** Replace those of n <= NQM_SCORE_BLOCK results. azimuths NULL: they have no score (NQM_ERR_INCOMPATIBLE). */
NQM_MUST_CHECK nqm_status nqm_azimuths_score(const nqm_azimuths *azimuths, size_t n, const nqm_azimuth_pairs *pairs,
                                             const nqm_model *model, nqm_score_result *results, nqm_error *err);

/** The light of all slopes together: totals (3, n_slope_points). */
void nqm_azimuths_totals(const nqm_model *model, float *totals);
/** The light of the points of a BRDF's picture, by half vectors that suit a lobe: rgb (3, n_slope_points) cd/m2. false:
 *  out of memory. */
bool nqm_azimuths_light(const nqm_model *model, const float *totals, const nqm_brdf *brdf, const nqm_lobe *lobe,
                        double *rgb);
/** The score of two means of BRDFs, as of pictures whose light is averaged: lobes of any width and lean, which one set of half vectors
 *  could not have.
 *
 * @param members  (n) of the reference and of the test
 * @param weights  (n) of both; their sum is 1
 * @return NQM_ERR_INCOMPATIBLE: azimuths is NULL; the error of a BRDF that cannot be opened; NQM_ERR_CANCELLED */
NQM_MUST_CHECK nqm_status nqm_azimuths_score_means(const nqm_azimuths *azimuths, size_t n,
                                                   const nqm_named_pair *members, const double *weights,
                                                   nqm_ticker *ticker, nqm_score_result *result, nqm_error *err);

#endif
