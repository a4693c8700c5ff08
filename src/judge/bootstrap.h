/* SPDX-License-Identifier: MIT
 *
 * bootstrap.h - statistics of agreement over resamples of groups. Most follow from sums that each group adds to; only the
 * rank correlations over all pairs need the pairs themselves.
 */
#ifndef NQM_SRC_JUDGE_BOOTSTRAP_H
#define NQM_SRC_JUDGE_BOOTSTRAP_H

#include "judge/agreement.h"

/** What a group adds up to; x is the prediction and y the label, each less a constant. */
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
    NQM_SUM_RHO, /* Spearman inside the group */
    NQM_SUM_ORDERED,
    NQM_SUM_RIGHT, /* of the ordered: predicted so; ties count half */
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

/** All statistics but NQM_STATISTIC_SPEARMAN and NQM_STATISTIC_KENDALL, of sums (NQM_SUM_COUNT) over groups; NaN where there is no such statistic. */
void nqm_statistics_of_sums(const double *sums, double statistics[NQM_STATISTIC_COUNT]);

/** What the resamples of one judgement start from. */
typedef struct nqm_bootstrap {
    const nqm_judgement *judgement;
    const double *sums; /* (n_predictors, n_groups, NQM_SUM_COUNT) */
    uint64_t seed;
    size_t n_resamples;
    bool without_kendall; /* which takes longer than all others: leave it NaN */
    size_t n_occurring;
    const size_t *occurring; /* (n_occurring) groups that hold pairs, ascending */
} nqm_bootstrap;

/** How often resample `index` draws each group: weight (n_groups), zeroed by the caller. */
void nqm_bootstrap_draw(uint64_t seed, size_t index, size_t n_occurring, const size_t *occurring, double *weight);

/** statistics (n_predictors, NQM_STATISTIC_COUNT, n_resamples). The same bits whatever the number of threads. */
NQM_MUST_CHECK nqm_status nqm_bootstrap_run(const nqm_bootstrap *bootstrap, double *statistics, nqm_error *err);

#endif
