/* SPDX-License-Identifier: MIT
 *
 * agreement.h - how well predictions agree with labels over pairs that come in groups, with bootstrap intervals, and how
 * much better one predictor agrees than another.
 */
#ifndef NQM_SRC_JUDGE_AGREEMENT_H
#define NQM_SRC_JUDGE_AGREEMENT_H

#include "data/data.h"
#include <nqm/judge.h>

enum { NQM_MIN_PAIRS_OF_GROUP = 3 }; /* a group with fewer has no rank correlation worth a mean */

/** Predictions and labels of n pairs, those of a group side by side. Higher predictions must mean higher labels. */
typedef struct nqm_judgement {
    size_t n, n_groups, n_predictors;
    const size_t *group_begin; /* (n_groups + 1) pairs of group g: [group_begin[g], group_begin[g + 1]); may be empty */
    const double *label;       /* (n) */
    const double *prediction;  /* (n_predictors, n) finite */
    double order_margin;       /* two pairs of a group have an order when their labels differ by more; >= 0 */
} nqm_judgement;

/** results (n_predictors): everything but name and flags. The intervals are the 2.5 and 97.5 percentiles over
 * n_bootstrap resamples of the groups that hold pairs, with replacement (0: NaN); every predictor sees the same
 * resamples. */
NQM_MUST_CHECK nqm_status nqm_judge(const nqm_judgement *judgement, size_t n_bootstrap, uint64_t seed,
                                    nqm_agreement *results, nqm_error *err);

/** Fill contrasts (n_contrasts), whose `first` and `second` are predictors of the judgement, on the resamples that
 * nqm_judge() draws for this seed. */
NQM_MUST_CHECK nqm_status nqm_judge_contrasts(const nqm_judgement *judgement, size_t n_bootstrap, uint64_t seed,
                                              size_t n_contrasts, nqm_contrast *contrasts, nqm_error *err);

/** Set the flags best_of_family and best_baseline of metrics (NQM_METRIC_COUNT), by their statistic `spearman`. */
void nqm_mark_best(nqm_agreement *metrics);

/** 2.5 and 97.5 percentiles of the values of x (n) that are numbers; x is reordered. */
void nqm_interval95(size_t n, double *x, double ci95[2]);
/** first - second over resamples (n, NaN left out), with the difference `value` of the pairs as they are. scratch (n). */
nqm_difference nqm_difference_of(double value, size_t n, const double *first, const double *second, double *scratch);

#endif
