/* SPDX-License-Identifier: MIT
 *
 * Computes the agreement of predictions with labels, with bootstrap percentile intervals, and contrasts between
 * predictors. bootstrap.c draws the resamples.
 */
#include "judge/judge.h"
#include "math/math.h"

#include <math.h>
#include <string.h>

/* ---- sums of a group --------------------------------------------------------------------------------------------- */

/* Count the pairs of tests whose labels differ by more than the margin, and those that the predictions order
 * correctly. */
static void count_orders(size_t n, const double *prediction, const double *label, double margin, double *sums) {
    for (size_t i = 0; i < n; ++i)
        for (size_t k = i + 1; k < n; ++k) {
            double by_label = label[i] - label[k], by_prediction = prediction[i] - prediction[k];
            if (!(fabs(by_label) > margin))
                continue;
            sums[NQM_SUM_ORDERED] += 1;
            sums[NQM_SUM_RIGHT] += by_prediction == 0 ? 0.5 : (by_prediction > 0) == (by_label > 0);
        }
}

static void sum_group(const nqm_judgement *j, size_t predictor, size_t g, double *sums) {
    const double *prediction = j->prediction + predictor * j->n + j->group_begin[g];
    const double *label = j->label + j->group_begin[g];
    size_t n = j->group_begin[g + 1] - j->group_begin[g];
    /* Subtracting the first value avoids cancellation when the mean is large; constant values give exact zeros. */
    double x0 = j->prediction[predictor * j->n], y0 = j->label[0];
    for (size_t i = 0; i < n; ++i) {
        double x = prediction[i] - x0, y = label[i] - y0, error = prediction[i] - label[i];
        sums[NQM_SUM_X] += x;
        sums[NQM_SUM_Y] += y;
        sums[NQM_SUM_XX] += x * x;
        sums[NQM_SUM_YY] += y * y;
        sums[NQM_SUM_XY] += x * y;
        sums[NQM_SUM_ABS_ERROR] += fabs(error);
        sums[NQM_SUM_SQUARED_ERROR] += error * error;
    }
    sums[NQM_SUM_N] = (double)n;
    double rho = n < NQM_MIN_PAIRS_OF_GROUP ? NAN : nqm_spearman(n, prediction, label);
    sums[NQM_SUM_GROUPS_WITH_RHO] = !isnan(rho);
    sums[NQM_SUM_RHO] = isnan(rho) ? 0 : rho;
    count_orders(n, prediction, label, j->order_margin, sums);
}

/* ---- preparation ------------------------------------------------------------------------------------------------- */

/* Allocate, sum and resample. */
static nqm_status begin(nqm_bootstrap *b, nqm_error *err) {
    const nqm_judgement *j = b->judgement;
    b->n_resamples = nqm_bootstrap_count(j->n_groups, b->n_resamples);
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&b->sums, j->n_predictors * j->n_groups, NQM_SUM_COUNT * sizeof *b->sums},
                   {&b->statistics, j->n_predictors * NQM_STATISTIC_COUNT, b->n_resamples * sizeof *b->statistics},
                   {&b->scratch, b->n_resamples, sizeof *b->scratch}),
        err);
    if (status != NQM_OK)
        return status;
    for (size_t i = 0; i < j->n_predictors * j->n_groups; ++i)
        sum_group(j, i / j->n_groups, i % j->n_groups, b->sums + i * NQM_SUM_COUNT);
    return nqm_bootstrap_run(b, err);
}

static double *resampled(const nqm_bootstrap *b, size_t predictor, int statistic) {
    return b->statistics + (predictor * NQM_STATISTIC_COUNT + (size_t)statistic) * b->n_resamples;
}

/* ---- results ----------------------------------------------------------------------------------------------------- */

/* Statistics of the original pairs, without resampling. Returns the number of pairs of tests with an order. */
static size_t plain_statistics(const nqm_bootstrap *b, size_t predictor, double statistics[NQM_STATISTIC_COUNT]) {
    const nqm_judgement *j = b->judgement;
    const double *sums = b->sums + predictor * j->n_groups * NQM_SUM_COUNT;
    const double n_ordered = nqm_statistics_of_sums(j->n_groups, sums, NULL, statistics);
    statistics[NQM_STATISTIC_SPEARMAN] = nqm_spearman(j->n, j->prediction + predictor * j->n, j->label);
    return (size_t)n_ordered;
}

size_t nqm_bootstrap_count(size_t n_groups, size_t n_bootstrap) {
    return n_groups < 4 ? 0 : n_bootstrap;
}

double nqm_share_of(size_t n_groups, size_t stride, const double *met, const double *all, const double *weight) {
    double sum = 0, n = 0;
    for (size_t g = 0; g < n_groups; ++g) {
        const double times = weight ? weight[g] : 1;
        sum += times * met[g * stride];
        n += times * all[g];
    }
    return sum / n;
}

void nqm_interval95(size_t n, double *x, double ci95[2]) {
    size_t n_numbers = 0;
    for (size_t i = 0; i < n; ++i)
        if (!isnan(x[i]))
            x[n_numbers++] = x[i];
    ci95[0] = nqm_quantile(n_numbers, x, 0.025);
    ci95[1] = nqm_quantile(n_numbers, x, 0.975);
}

static void fill_agreement(const nqm_bootstrap *b, size_t predictor, nqm_agreement *a) {
    const nqm_judgement *j = b->judgement;
    double statistics[NQM_STATISTIC_COUNT];
    nqm_estimate *const estimates[NQM_STATISTIC_COUNT] = {[NQM_STATISTIC_SPEARMAN] = &a->spearman,
                                                          [NQM_STATISTIC_BY_GROUP] = &a->spearman_mean_by_material,
                                                          [NQM_STATISTIC_PEARSON] = &a->pearson,
                                                          [NQM_STATISTIC_KENDALL] = &a->kendall,
                                                          [NQM_STATISTIC_MAE] = &a->mae,
                                                          [NQM_STATISTIC_RMSE] = &a->rmse,
                                                          [NQM_STATISTIC_R2] = &a->r2,
                                                          [NQM_STATISTIC_ORDER] = &a->order};
    *a = (nqm_agreement){.n = j->n, .n_materials = j->n_groups};
    a->n_ordered = plain_statistics(b, predictor, statistics);
    if (!j->without_kendall)
        statistics[NQM_STATISTIC_KENDALL] = nqm_kendall(j->n, j->prediction + predictor * j->n, j->label);
    for (int f = 0; f < NQM_STATISTIC_COUNT; ++f) {
        estimates[f]->value = statistics[f];
        nqm_interval95(b->n_resamples, resampled(b, predictor, f), estimates[f]->ci95);
    }
}

nqm_status nqm_judge(const nqm_judgement *j, size_t n_bootstrap, uint64_t seed, nqm_agreement *results,
                     nqm_error *err) {
    nqm_bootstrap b = {.judgement = j, .seed = seed, .n_resamples = n_bootstrap};
    nqm_status status = begin(&b, err);
    for (size_t p = 0; status == NQM_OK && p < j->n_predictors; ++p)
        fill_agreement(&b, p, &results[p]);
    nqm_free(b.sums);
    return status;
}

/* ---- contrasts --------------------------------------------------------------------------------------------------- */

nqm_difference nqm_difference_of(double value, size_t n, const double *first, const double *second, double *scratch) {
    nqm_difference d = {.value = value, .share_below_0 = NAN};
    size_t n_numbers = 0, n_below = 0;
    for (size_t i = 0; i < n; ++i) {
        double difference = first[i] - second[i];
        if (isnan(difference))
            continue;
        scratch[n_numbers++] = difference;
        n_below += difference < 0;
    }
    if (n_numbers)
        d.share_below_0 = (double)n_below / (double)n_numbers;
    nqm_interval95(n_numbers, scratch, d.ci95);
    return d;
}

static void fill_contrast(const nqm_bootstrap *b, nqm_contrast *c) {
    double first[NQM_STATISTIC_COUNT], second[NQM_STATISTIC_COUNT];
    plain_statistics(b, c->first, first);
    plain_statistics(b, c->second, second);
    nqm_difference *const differences[NQM_STATISTIC_COUNT] = {
        [NQM_STATISTIC_SPEARMAN] = &c->spearman,
        [NQM_STATISTIC_BY_GROUP] = &c->spearman_mean_by_material,
        [NQM_STATISTIC_ORDER] = &c->order,
    };
    for (int f = 0; f < NQM_STATISTIC_COUNT; ++f)
        if (differences[f])
            *differences[f] = nqm_difference_of(first[f] - second[f], b->n_resamples, resampled(b, c->first, f),
                                                resampled(b, c->second, f), b->scratch);
}

nqm_status nqm_judge_contrasts(const nqm_judgement *j, size_t n_bootstrap, uint64_t seed, size_t n_contrasts,
                               nqm_contrast *contrasts, nqm_error *err) {
    nqm_bootstrap b = {.judgement = j, .seed = seed, .n_resamples = n_bootstrap};
    nqm_status status = begin(&b, err);
    for (size_t i = 0; status == NQM_OK && i < n_contrasts; ++i)
        fill_contrast(&b, &contrasts[i]);
    nqm_free(b.sums);
    return status;
}

/* ---- best metrics ------------------------------------------------------------------------------------------------ */

/* Find the baseline with the largest Spearman in a family (NULL: in all); the first one if tied, NQM_METRIC_COUNT if
 * none. */
static size_t find_best(const nqm_agreement *metrics, const char *family) {
    size_t best = NQM_METRIC_COUNT;
    for (size_t m = 0; m < NQM_METRIC_COUNT; ++m) {
        const nqm_metric_info info = nqm_metric_get_info((nqm_metric)m);
        const bool counts = info.is_baseline && (!family || strcmp(family, info.family) == 0);
        if (counts && !isnan(metrics[m].spearman.value) &&
            (best == NQM_METRIC_COUNT || metrics[m].spearman.value > metrics[best].spearman.value))
            best = m;
    }
    return best;
}

void nqm_mark_best(nqm_agreement *metrics) {
    for (size_t m = 0; m < NQM_METRIC_COUNT; ++m) {
        metrics[m].best_of_family = find_best(metrics, nqm_metric_get_info((nqm_metric)m).family) == m;
        metrics[m].best_baseline = find_best(metrics, NULL) == m;
    }
}
