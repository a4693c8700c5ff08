/* SPDX-License-Identifier: MIT
 *
 * agreement.h - agreement of predictions with labels over grouped pairs, with bootstrap intervals, and differences in
 * agreement between predictors. Most statistics of a resample are computed from sums per group; only the rank
 * correlations over all pairs require the individual pairs.
 */
#ifndef NQM_SRC_JUDGE_AGREEMENT_H
#define NQM_SRC_JUDGE_AGREEMENT_H

#include "data/data.h"
#include "judge/judge.h"

enum { NQM_MIN_PAIRS_OF_GROUP = 3 }; /* with fewer, the rank correlation of a group is not meaningful */

/** Predictions and labels of n pairs, sorted by group. Higher predictions must mean higher labels. */
typedef struct nqm_judgement {
    size_t n, n_groups, n_predictors;
    const size_t *group_begin; /* (n_groups + 1) pairs of group g: [group_begin[g], group_begin[g + 1]); not empty */
    const double *label;       /* (n) */
    const double *prediction;  /* (n_predictors, n) finite */
    double order_margin;       /* two pairs of a group have an order if their labels differ by more than this; >= 0 */
    bool without_kendall;      /* skip Kendall (NaN), the slowest statistic */
} nqm_judgement;

/** Compute results (n_predictors), except name and flags. The intervals are the 2.5 and 97.5 percentiles over
 * n_bootstrap resamples, with replacement, of the groups; NaN where nqm_bootstrap_count() is 0. All predictors use the
 * same resamples. */
NQM_MUST_CHECK nqm_status nqm_judge(const nqm_judgement *judgement, size_t n_bootstrap, uint64_t seed,
                                    nqm_agreement *results, nqm_error *err);

/** Compute contrasts (n_contrasts) between their predictors `first` and `second`, with the same resamples as
 * nqm_judge() for this seed. */
NQM_MUST_CHECK nqm_status nqm_judge_contrasts(const nqm_judgement *judgement, size_t n_bootstrap, uint64_t seed,
                                              size_t n_contrasts, nqm_contrast *contrasts, nqm_error *err);

/** Set the flags best_of_family and best_baseline of metrics (NQM_METRIC_COUNT) according to `spearman`. */
void nqm_mark_best(nqm_agreement *metrics);

/** 2.5 and 97.5 percentiles of x (n), ignoring NaN; reorders x. */
void nqm_interval95(size_t n, double *x, double ci95[2]);
/** The number of resamples to draw: n_bootstrap, or 0 with fewer than 4 groups. A resample is n times the same group
 *  with probability n^-n for each group; where this exceeds 2.5 %, the ends of the interval would be statistics of
 *  single groups. */
size_t nqm_bootstrap_count(size_t n_groups, size_t n_bootstrap);
/** Statistics of first - second over resamples (n, NaN ignored). value: difference without resampling; scratch (n). */
nqm_difference nqm_difference_of(double value, size_t n, const double *first, const double *second, double *scratch);

/* ---- resamples (bootstrap.c) ------------------------------------------------------------------------------------- */

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
    NQM_SUM_RIGHT,   /* pairs of tests predicted in the right order; ties count half */
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
 *  (n_groups, NQM_SUM_COUNT); weight (n_groups): how often each group counts; NULL: once. NaN if a statistic is undefined.
 *  Returns the total of NQM_SUM_ORDERED. */
double nqm_statistics_of_sums(size_t n_groups, const double *sums, const double *weight,
                              double statistics[NQM_STATISTIC_COUNT]);

/** Resampling of one judgement. */
typedef struct nqm_bootstrap {
    const nqm_judgement *judgement;
    uint64_t seed;
    size_t n_resamples;
    double *sums;       /* (n_predictors, n_groups, NQM_SUM_COUNT); owns the block of all three */
    double *statistics; /* (n_predictors, NQM_STATISTIC_COUNT, n_resamples) */
    double *scratch;    /* (n_resamples) */
} nqm_bootstrap;

/** Draw resample `index`: sets weight (n_groups) to how often each group is drawn. */
void nqm_bootstrap_draw(uint64_t seed, size_t index, size_t n_groups, double *weight);

/** Compute the statistics from the judgement and the sums. The result does not depend on the number of threads. */
NQM_MUST_CHECK nqm_status nqm_bootstrap_run(const nqm_bootstrap *bootstrap, nqm_error *err);

#endif
