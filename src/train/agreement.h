/* SPDX-License-Identifier: MIT
 *
 * agreement.h - how well predictions agree with labels over pairs that come in groups, with bootstrap intervals.
 */
#ifndef NQM_SRC_TRAIN_AGREEMENT_H
#define NQM_SRC_TRAIN_AGREEMENT_H

#include "train/train.h"

enum { NQM_MIN_PAIRS_OF_GROUP = 3 }; /* a group with fewer has no rank correlation worth a mean */

/** Predictions and labels of n pairs, those of a group side by side. Higher predictions must mean higher labels. */
typedef struct nqm_judgement {
    size_t n, n_groups, n_predictors;
    const size_t *group_begin; /* (n_groups + 1) pairs of group g: [group_begin[g], group_begin[g + 1]); may be empty */
    const double *label;       /* (n) */
    const double *prediction;  /* (n_predictors, n) finite */
} nqm_judgement;

/** results (n_predictors): everything but the name. The intervals are the 2.5 and 97.5 percentiles over n_bootstrap
 * resamples of the groups that hold pairs, with replacement (0: NaN); every predictor sees the same resamples. */
NQM_MUST_CHECK nqm_status nqm_judge(const nqm_judgement *judgement, size_t n_bootstrap, uint64_t seed,
                                    nqm_agreement *results, nqm_error *err);

#endif
