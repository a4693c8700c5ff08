/* SPDX-License-Identifier: MIT
 *
 * Agreement of predictions with labels, and its bootstrap over material groups: percentile intervals (Efron 1979, DOI
 * 10.1214/aos/1176344552); whole groups are drawn because the pairs of one material are not independent.
 *
 * A resample that draws group g w_g times holds each of its pairs w_g times. The ranks of such a multiset follow from
 * the weights and the order of the values in the whole, so that nothing is sorted a second time.
 */
#include "train/agreement.h"

#include <math.h>
#include <stdatomic.h>

/* What the resamples of one judgement share. Row 0 of the arrays with 1 + n_predictors rows is that of the labels. */
typedef struct bootstrap {
    const nqm_judgement *j;
    uint64_t seed;
    size_t n_resamples;
    uint32_t *level; /* (1 + n_predictors, n) values in ascending order have levels 0, 1, ...; equal values share one */
    size_t *n_levels;  /* (1 + n_predictors) */
    double *group_rho; /* (n_predictors, n_groups) Spearman inside a group; NaN where it has none */
    size_t *occurring; /* (n_occurring) groups that hold pairs */
    size_t n_occurring;
    double *pooled;   /* (n_predictors, n_resamples) Spearman over all pairs of a resample */
    double *by_group; /* (n_predictors, n_resamples) mean over the groups of a resample */
    atomic_bool out_of_memory;
} bootstrap;

/* ---- figures of the pairs as they are ---------------------------------------------------------------------------- */

static void error_figures(const nqm_judgement *j, const double *prediction, nqm_agreement *a) {
    double mean = nqm_mean(j->n, j->label), sum_abs = 0, sum_squares = 0, variance = 0;
    for (size_t i = 0; i < j->n; ++i) {
        double d = prediction[i] - j->label[i], from_mean = j->label[i] - mean;
        sum_abs += fabs(d);
        sum_squares += d * d;
        variance += from_mean * from_mean;
    }
    a->mae = sum_abs / (double)j->n;
    a->rmse = sqrt(sum_squares / (double)j->n);
    a->r2 = variance > 0 ? 1 - sum_squares / variance : NAN;
}

/* Mean over the occurring groups that have a correlation; weight (n_groups), NULL: 1. NaN where no group counts. */
static double group_mean(const bootstrap *b, size_t predictor, const double *weight) {
    const double *rho = b->group_rho + predictor * b->j->n_groups;
    double sum = 0, n = 0;
    for (size_t k = 0; k < b->n_occurring; ++k) {
        size_t g = b->occurring[k];
        if (isnan(rho[g]))
            continue;
        double w = weight ? weight[g] : 1;
        sum += w * rho[g];
        n += w;
    }
    return n > 0 ? sum / n : NAN;
}

static void plain_figures(const bootstrap *b, size_t predictor, nqm_agreement *a) {
    const nqm_judgement *j = b->j;
    const double *prediction = j->prediction + predictor * j->n;
    *a = (nqm_agreement){.n = j->n, .n_materials = b->n_occurring};
    a->spearman = nqm_spearman(j->n, prediction, j->label);
    a->pearson = nqm_pearson(j->n, prediction, j->label);
    a->kendall = nqm_kendall(j->n, prediction, j->label);
    a->spearman_mean_by_material = group_mean(b, predictor, NULL);
    error_figures(j, prediction, a);
}

/* ---- preparation ------------------------------------------------------------------------------------------------- */

static size_t find_levels(size_t n, const double *x, double *rank, size_t *order, uint32_t *level) {
    nqm_ranks(n, x, rank, order);
    uint32_t at = 0;
    for (size_t k = 0; k < n; ++k) {
        at += k > 0 && rank[order[k]] != rank[order[k - 1]];
        level[order[k]] = at;
    }
    return (size_t)at + 1;
}

static nqm_status prepare(bootstrap *b, nqm_error *err) {
    const nqm_judgement *j = b->j;
    double *rank = nqm_alloc(j->n, sizeof *rank);
    size_t *order = nqm_alloc(j->n, sizeof *order);
    b->level = nqm_alloc(1 + j->n_predictors, j->n * sizeof *b->level);
    b->n_levels = nqm_alloc(1 + j->n_predictors, sizeof *b->n_levels);
    b->group_rho = nqm_alloc(j->n_predictors, j->n_groups * sizeof *b->group_rho);
    b->occurring = nqm_alloc(j->n_groups, sizeof *b->occurring);
    b->pooled = nqm_alloc(j->n_predictors, (b->n_resamples + 1) * sizeof *b->pooled);
    b->by_group = nqm_alloc(j->n_predictors, (b->n_resamples + 1) * sizeof *b->by_group);
    bool ok = rank && order && b->level && b->n_levels && b->group_rho && b->occurring && b->pooled && b->by_group;
    for (size_t g = 0; ok && g < j->n_groups; ++g)
        if (j->group_begin[g + 1] > j->group_begin[g])
            b->occurring[b->n_occurring++] = g;
    for (size_t r = 0; ok && r <= j->n_predictors; ++r) {
        const double *x = r ? j->prediction + (r - 1) * j->n : j->label;
        b->n_levels[r] = find_levels(j->n, x, rank, order, b->level + r * j->n);
    }
    for (size_t i = 0; ok && i < j->n_predictors * j->n_groups; ++i) {
        size_t g = i % j->n_groups, begin = j->group_begin[g], n = j->group_begin[g + 1] - begin;
        const double *prediction = j->prediction + i / j->n_groups * j->n;
        b->group_rho[i] = n < NQM_MIN_PAIRS_OF_GROUP ? NAN : nqm_spearman(n, prediction + begin, j->label + begin);
    }
    nqm_free(rank);
    nqm_free(order);
    return ok ? NQM_OK : nqm_fail_nomem(err, (2 + j->n_predictors) * j->n * sizeof *b->level);
}

static void release(bootstrap *b) {
    nqm_free(b->level);
    nqm_free(b->n_levels);
    nqm_free(b->group_rho);
    nqm_free(b->occurring);
    nqm_free(b->pooled);
    nqm_free(b->by_group);
}

/* ---- one resample ------------------------------------------------------------------------------------------------ */

/* Scratch of a resample. */
typedef struct resample {
    double *weight;       /* (n_groups) how often each group was drawn */
    double *label_rank;   /* (n) by level, minus the mean rank */
    double *rank;         /* (n) by level, likewise */
    double *level_weight; /* (n) */
    double n;             /* pairs, with repetition */
} resample;

/* Mean ranks of the levels of row r, less the mean of all ranks; returns the sum of their squares over the pairs. */
static double rank_levels(const bootstrap *b, const resample *s, size_t r, double *rank) {
    const nqm_judgement *j = b->j;
    const uint32_t *level = b->level + r * j->n;
    for (size_t k = 0; k < b->n_levels[r]; ++k)
        s->level_weight[k] = 0;
    for (size_t k = 0; k < b->n_occurring; ++k) {
        size_t g = b->occurring[k];
        for (size_t i = j->group_begin[g]; i < j->group_begin[g + 1]; ++i)
            s->level_weight[level[i]] += s->weight[g];
    }
    double below = 0, squares = 0;
    for (size_t k = 0; k < b->n_levels[r]; ++k) {
        double w = s->level_weight[k];
        rank[k] = below + 0.5 * (w + 1) - 0.5 * (s->n + 1);
        squares += w * rank[k] * rank[k];
        below += w;
    }
    return squares;
}

/* Pearson's r of the ranks of labels and of row r. */
static double resample_spearman(const bootstrap *b, const resample *s, size_t r, double label_squares) {
    const nqm_judgement *j = b->j;
    const uint32_t *label_level = b->level, *level = b->level + r * j->n;
    double squares = rank_levels(b, s, r, s->rank), products = 0;
    for (size_t k = 0; k < b->n_occurring; ++k) {
        size_t g = b->occurring[k];
        for (size_t i = j->group_begin[g]; s->weight[g] > 0 && i < j->group_begin[g + 1]; ++i)
            products += s->weight[g] * s->label_rank[label_level[i]] * s->rank[level[i]];
    }
    return squares > 0 && label_squares > 0 ? products / sqrt(squares) / sqrt(label_squares) : NAN;
}

static void draw_groups(const bootstrap *b, size_t index, resample *s) {
    const nqm_judgement *j = b->j;
    nqm_rng rng = nqm_rng_make(b->seed, index);
    s->n = 0;
    for (size_t k = 0; k < b->n_occurring; ++k) {
        size_t g = b->occurring[nqm_rng_below(&rng, b->n_occurring)];
        s->weight[g] += 1;
        s->n += (double)(j->group_begin[g + 1] - j->group_begin[g]);
    }
}

static void run_resample(void *user, size_t index) {
    bootstrap *b = user;
    const nqm_judgement *j = b->j;
    resample s = {.weight = nqm_alloc(j->n_groups, sizeof(double)),
                  .label_rank = nqm_alloc(j->n, sizeof(double)),
                  .rank = nqm_alloc(j->n, sizeof(double)),
                  .level_weight = nqm_alloc(j->n, sizeof(double))};
    if (s.weight && s.label_rank && s.rank && s.level_weight) {
        draw_groups(b, index, &s);
        double label_squares = rank_levels(b, &s, 0, s.label_rank);
        for (size_t p = 0; p < j->n_predictors; ++p) {
            b->pooled[p * b->n_resamples + index] = resample_spearman(b, &s, p + 1, label_squares);
            b->by_group[p * b->n_resamples + index] = group_mean(b, p, s.weight);
        }
    } else {
        atomic_store(&b->out_of_memory, true);
    }
    nqm_free(s.weight);
    nqm_free(s.label_rank);
    nqm_free(s.rank);
    nqm_free(s.level_weight);
}

/* 2.5 and 97.5 percentiles of the values that are numbers; x (n) is sorted. */
static void find_interval(size_t n, double *x, double ci95[2]) {
    size_t n_numbers = 0;
    for (size_t i = 0; i < n; ++i)
        if (!isnan(x[i]))
            x[n_numbers++] = x[i];
    ci95[0] = nqm_quantile(n_numbers, x, 0.025);
    ci95[1] = nqm_quantile(n_numbers, x, 0.975);
}

nqm_status nqm_judge(const nqm_judgement *j, size_t n_bootstrap, uint64_t seed, nqm_agreement *results,
                     nqm_error *err) {
    if (j->n_groups < 2)
        n_bootstrap = 0; /* resampling one material gives it again: an interval without width would be a lie */
    bootstrap b = {.j = j, .seed = seed, .n_resamples = n_bootstrap};
    nqm_status status = prepare(&b, err);
    if (status == NQM_OK) {
        nqm_parallel_for(n_bootstrap, run_resample, &b);
        if (atomic_load(&b.out_of_memory))
            status = nqm_fail_nomem(err, 3 * j->n * sizeof(double));
    }
    for (size_t p = 0; status == NQM_OK && p < j->n_predictors; ++p) {
        plain_figures(&b, p, &results[p]);
        find_interval(n_bootstrap, b.pooled + p * n_bootstrap, results[p].spearman_ci95);
        find_interval(n_bootstrap, b.by_group + p * n_bootstrap, results[p].spearman_mean_by_material_ci95);
    }
    release(&b);
    return status;
}
