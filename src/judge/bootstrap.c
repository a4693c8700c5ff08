/* SPDX-License-Identifier: MIT
 *
 * The bootstrap over material groups (Efron 1979, DOI 10.1214/aos/1176344552). Whole groups are resampled because the
 * pairs of one material are not independent.
 *
 * A resample that draws group g w_g times contains each of its pairs w_g times. The ranks in this multiset are computed
 * from the weights and the sort order of the original values, so that resamples need no sorting.
 */
#include "judge/judge.h"
#include "math/math.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

/* ---- statistics of sums ------------------------------------------------------------------------------------------ */

/* Sum of squared deviations from the mean; 0 if it is not larger than the rounding error. */
static double deviation(double n, double sum, double squares) {
    const double rounding = 1e-13;
    double d = squares - sum * sum / n;
    return d > rounding * squares ? d : 0;
}

double nqm_statistics_of_sums(size_t n_groups, const double *sums, const double *weight,
                              double statistics[NQM_STATISTIC_COUNT]) {
    double s[NQM_SUM_COUNT] = {0};
    for (size_t g = 0; g < n_groups; ++g) {
        const double times = weight ? weight[g] : 1;
        for (size_t i = 0; times > 0 && i < NQM_SUM_COUNT; ++i)
            s[i] += times * sums[g * NQM_SUM_COUNT + i];
    }
    double n = s[NQM_SUM_N];
    double xx = deviation(n, s[NQM_SUM_X], s[NQM_SUM_XX]), yy = deviation(n, s[NQM_SUM_Y], s[NQM_SUM_YY]);
    double xy = s[NQM_SUM_XY] - s[NQM_SUM_X] * s[NQM_SUM_Y] / n;
    statistics[NQM_STATISTIC_SPEARMAN] = statistics[NQM_STATISTIC_KENDALL] = NAN;
    statistics[NQM_STATISTIC_BY_GROUP] =
        s[NQM_SUM_GROUPS_WITH_RHO] > 0 ? s[NQM_SUM_RHO] / s[NQM_SUM_GROUPS_WITH_RHO] : NAN;
    statistics[NQM_STATISTIC_PEARSON] = xx > 0 && yy > 0 ? fmax(-1, fmin(1, xy / sqrt(xx) / sqrt(yy))) : NAN;
    statistics[NQM_STATISTIC_MAE] = s[NQM_SUM_ABS_ERROR] / n;
    statistics[NQM_STATISTIC_RMSE] = sqrt(s[NQM_SUM_SQUARED_ERROR] / n);
    statistics[NQM_STATISTIC_R2] = yy > 0 ? 1 - s[NQM_SUM_SQUARED_ERROR] / yy : NAN;
    statistics[NQM_STATISTIC_ORDER] = s[NQM_SUM_ORDERED] > 0 ? s[NQM_SUM_RIGHT] / s[NQM_SUM_ORDERED] : NAN;
    return s[NQM_SUM_ORDERED];
}

/* ---- sort order of the values ------------------------------------------------------------------------------------ */

/* Data shared by all resamples. In arrays with 1 + n_predictors rows, row 0 is for the labels. */
typedef struct shared {
    const nqm_bootstrap *b;
    uint32_t *
        level; /* (1 + n_predictors, n), owns the block of all four; distinct values in ascending order have levels 0, 1, ... */
    size_t *n_levels;   /* (1 + n_predictors) */
    uint32_t *order;    /* (n_predictors, n) pairs by ascending prediction */
    uint32_t *group_of; /* (n) */
    atomic_bool out_of_memory;
} shared;

static size_t find_levels(size_t n, const double *x, nqm_indexed *order, uint32_t *level) {
    nqm_sort_indexed(n, x, order);
    uint32_t at = 0;
    for (size_t k = 0; k < n; ++k) {
        at += k > 0 && order[k].value != order[k - 1].value;
        level[order[k].index] = at;
    }
    return (size_t)at + 1;
}

static nqm_status prepare(shared *s, nqm_error *err) {
    const nqm_judgement *j = s->b->judgement;
    nqm_indexed *order; /* (n) scratch */
    nqm_status status =
        nqm_alloc_arrays(NQM_ARRAYS({&s->level, 1 + j->n_predictors, j->n * sizeof *s->level},
                                    {&s->n_levels, 1 + j->n_predictors, sizeof *s->n_levels},
                                    {&s->order, j->n_predictors, j->n * sizeof *s->order},
                                    {&s->group_of, j->n, sizeof *s->group_of}, {&order, j->n, sizeof *order}),
                         err);
    if (status != NQM_OK)
        return status;
    for (size_t g = 0; g < j->n_groups; ++g)
        for (size_t i = j->group_begin[g]; i < j->group_begin[g + 1]; ++i)
            s->group_of[i] = (uint32_t)g;
    for (size_t r = 0; r <= j->n_predictors; ++r) {
        const double *x = r ? j->prediction + (r - 1) * j->n : j->label;
        s->n_levels[r] = find_levels(j->n, x, order, s->level + r * j->n);
        for (size_t k = 0; r && k < j->n; ++k)
            s->order[(r - 1) * j->n + k] = (uint32_t)order[k].index;
    }
    return NQM_OK;
}

/* ---- one resample ------------------------------------------------------------------------------------------------ */

/* Scratch of a resample. */
typedef struct resample {
    double *weight;       /* (n_groups) how often each group was drawn */
    double *label_rank;   /* (n) rank of each label level minus the mean rank */
    double *rank;         /* (n) the same for the levels of a predictor */
    double *level_weight; /* (n) number of pairs at each level, with repetition */
    double *tree;         /* (n + 1) Fenwick tree of label levels */
    double n;             /* number of pairs, with repetition */
    double label_squares; /* sum of label_rank squared over the pairs */
    double label_untied;  /* number of pairs of pairs with different labels */
} resample;

/* Compute the mean rank of each level of row r, minus the mean rank. Returns their sum of squares over the pairs. */
static double rank_levels(const shared *sh, const resample *s, size_t r, double *rank) {
    const nqm_judgement *j = sh->b->judgement;
    const uint32_t *level = sh->level + r * j->n;
    for (size_t k = 0; k < sh->n_levels[r]; ++k)
        s->level_weight[k] = 0;
    for (size_t g = 0; g < j->n_groups; ++g)
        for (size_t i = j->group_begin[g]; i < j->group_begin[g + 1]; ++i)
            s->level_weight[level[i]] += s->weight[g];
    double below = 0, squares = 0;
    for (size_t k = 0; k < sh->n_levels[r]; ++k) {
        double w = s->level_weight[k];
        rank[k] = below + 0.5 * (w + 1) - 0.5 * (s->n + 1);
        squares += w * rank[k] * rank[k];
        below += w;
    }
    return squares;
}

/* Pearson correlation between the ranks of the labels and of row r. */
static double resample_spearman(const shared *sh, const resample *s, size_t r) {
    const nqm_judgement *j = sh->b->judgement;
    const uint32_t *label_level = sh->level, *level = sh->level + r * j->n;
    double squares = rank_levels(sh, s, r, s->rank), products = 0;
    for (size_t g = 0; g < j->n_groups; ++g)
        for (size_t i = j->group_begin[g]; s->weight[g] > 0 && i < j->group_begin[g + 1]; ++i)
            products += s->weight[g] * s->label_rank[label_level[i]] * s->rank[level[i]];
    return squares > 0 && s->label_squares > 0 ? products / sqrt(squares) / sqrt(s->label_squares) : NAN;
}

static double pairs_among(double n) {
    return 0.5 * n * (n - 1);
}

/* Total weight of the levels below `level`. The tree (Fenwick 1994, DOI 10.1002/spe.4380240306) is indexed from 1. */
static double tree_below(const double *tree, size_t level) {
    double sum = 0;
    for (size_t k = level; k > 0; k &= k - 1)
        sum += tree[k];
    return sum;
}

static void tree_add(double *tree, size_t n_levels, size_t level, double weight) {
    for (size_t k = level + 1; k <= n_levels; k += k & (~k + 1))
        tree[k] += weight;
}

/* Kendall's tau-b. Pairs are visited in ascending order of their predictions; the tree contains the labels of those
 * with smaller predictions. All values before the last line are integers, so that sums are exact. */
static double resample_kendall(const shared *sh, const resample *s, size_t predictor) {
    const nqm_judgement *j = sh->b->judgement;
    const uint32_t *order = sh->order + predictor * j->n, *level = sh->level + (predictor + 1) * j->n;
    double in_order = 0, passed = 0, untied = pairs_among(s->n);
    for (size_t k = 0; k <= sh->n_levels[0]; ++k)
        s->tree[k] = 0;
    for (size_t begin = 0, end; begin < j->n; begin = end) {
        double tied = 0;
        for (end = begin; end < j->n && level[order[end]] == level[order[begin]]; ++end) {
            double w = s->weight[sh->group_of[order[end]]];
            size_t label = sh->level[order[end]];
            if (w > 0)
                in_order += w * (tree_below(s->tree, label) - (passed - tree_below(s->tree, label + 1)));
            tied += w;
        }
        for (size_t k = begin; k < end; ++k)
            if (s->weight[sh->group_of[order[k]]] > 0)
                tree_add(s->tree, sh->n_levels[0], sh->level[order[k]], s->weight[sh->group_of[order[k]]]);
        passed += tied;
        untied -= pairs_among(tied);
    }
    return untied > 0 && s->label_untied > 0 ? in_order / sqrt(untied) / sqrt(s->label_untied) : NAN;
}

void nqm_bootstrap_draw(uint64_t seed, size_t index, size_t n_groups, double *weight) {
    nqm_rng rng = nqm_rng_make(seed, index);
    memset(weight, 0, n_groups * sizeof *weight);
    for (size_t k = 0; k < n_groups; ++k)
        weight[nqm_rng_below(&rng, n_groups)] += 1;
}

static void fill_resample(shared *sh, size_t index, resample *s) {
    const nqm_bootstrap *b = sh->b;
    const nqm_judgement *j = b->judgement;
    nqm_bootstrap_draw(b->seed, index, j->n_groups, s->weight);
    for (size_t g = 0; g < j->n_groups; ++g)
        s->n += s->weight[g] * (double)(j->group_begin[g + 1] - j->group_begin[g]);
    s->label_squares = rank_levels(sh, s, 0, s->label_rank);
    s->label_untied = pairs_among(s->n);
    for (size_t k = 0; k < sh->n_levels[0]; ++k)
        s->label_untied -= pairs_among(s->level_weight[k]);
    for (size_t p = 0; p < j->n_predictors; ++p) {
        double statistics[NQM_STATISTIC_COUNT];
        nqm_statistics_of_sums(j->n_groups, b->sums + p * j->n_groups * NQM_SUM_COUNT, s->weight, statistics);
        statistics[NQM_STATISTIC_SPEARMAN] = resample_spearman(sh, s, p + 1);
        if (!j->without_kendall)
            statistics[NQM_STATISTIC_KENDALL] = resample_kendall(sh, s, p);
        for (size_t f = 0; f < NQM_STATISTIC_COUNT; ++f)
            b->statistics[(p * NQM_STATISTIC_COUNT + f) * b->n_resamples + index] = statistics[f];
    }
}

static void run_resample(void *user, size_t index) {
    shared *sh = user;
    const nqm_judgement *j = sh->b->judgement;
    resample s = {0};
    if (nqm_alloc_arrays(NQM_ARRAYS({&s.weight, j->n_groups, sizeof(double)}, {&s.label_rank, j->n, sizeof(double)},
                                    {&s.rank, j->n, sizeof(double)}, {&s.level_weight, j->n, sizeof(double)},
                                    {&s.tree, j->n + 1, sizeof(double)}),
                         NULL) == NQM_OK)
        fill_resample(sh, index, &s);
    else
        atomic_store(&sh->out_of_memory, true);
    nqm_free(s.weight);
}

nqm_status nqm_bootstrap_run(const nqm_bootstrap *bootstrap, nqm_error *err) {
    if (bootstrap->n_resamples == 0)
        return NQM_OK;
    shared sh = {.b = bootstrap};
    nqm_status status = prepare(&sh, err);
    if (status == NQM_OK) {
        nqm_parallel_for(bootstrap->n_resamples, run_resample, &sh);
        if (atomic_load(&sh.out_of_memory))
            status = nqm_fail_nomem(err, 4 * bootstrap->judgement->n * sizeof(double));
    }
    nqm_free(sh.level);
    return status;
}
