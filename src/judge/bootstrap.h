/* SPDX-License-Identifier: MIT
 *
 * bootstrap.h - statistics of agreement over resamples of groups. Most are computed from sums per group; only the rank
 * correlations over all pairs require the individual pairs.
 */
#ifndef NQM_SRC_JUDGE_BOOTSTRAP_H
#define NQM_SRC_JUDGE_BOOTSTRAP_H

#include "judge/agreement.h"

/** Sums over the pairs of a group; x is the prediction and y the label, each minus a constant. */
enum {
    NQM_SUM_N,
    NQM_SUM_X,
    NQM_SUM_Y,
    NQM_SUM_XX,
    NQM_SUM_YY,
    NQM_SUM_XY,
    NQM_SUM_ABS_ERROR,
    NQM_SUM_SQUARED_ERROR,
    NQM_SUM_GROUPS_WITH_RHO,
    NQM_SUM_RHO,     /* Spearman within the group */
    NQM_SUM_ORDERED, /* pairs of pairs whose labels have an order */
    NQM_SUM_RIGHT,   /* those of them that are predicted in that order; ties count half */
    NQM_SUM_COUNT
};

enum {
    NQM_STATISTIC_SPEARMAN,
    NQM_STATISTIC_BY_GROUP,
    NQM_STATISTIC_PEARSON,
    NQM_STATISTIC_KENDALL,
    NQM_STATISTIC_MAE,
    NQM_STATISTIC_RMSE,
    NQM_STATISTIC_R2,
    NQM_STATISTIC_ORDER,
    NQM_STATISTIC_COUNT
};

/** Compute all statistics except NQM_STATISTIC_SPEARMAN and NQM_STATISTIC_KENDALL, which become NaN, from sums
 *  (NQM_SUM_COUNT) over groups. NaN if a statistic is undefined. */
void nqm_statistics_of_sums(const double *sums, double statistics[NQM_STATISTIC_COUNT]);

/** Input of the resampling of one judgement. */
typedef struct nqm_bootstrap {
    const nqm_judgement *judgement;
    const double *sums; /* (n_predictors, n_groups, NQM_SUM_COUNT) */
    uint64_t seed;
    size_t n_resamples;
    bool without_kendall; /* skip Kendall (NaN), the slowest statistic */
} nqm_bootstrap;

/** Draw resample `index`: sets weight (n_groups) to how often each group is drawn. */
void nqm_bootstrap_draw(uint64_t seed, size_t index, size_t n_groups, double *weight);

/** Compute statistics (n_predictors, NQM_STATISTIC_COUNT, n_resamples). The result does not depend on the number of
 *  threads. */
NQM_MUST_CHECK nqm_status nqm_bootstrap_run(const nqm_bootstrap *bootstrap, double *statistics, nqm_error *err);

#endif
