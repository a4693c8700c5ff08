/* SPDX-License-Identifier: MIT
 *
 * Derivatives of metrics and scalar features by the sums over directions from which they are computed: reverse-mode differentiation
 * of scalars.c by hand. sums.c continues to the samples. Derivatives have the type of what they are derivatives by.
 */
#include "math/math.h"
#include "metric/sums.h"

#include <math.h>

/* Derivative of log(x + NQM_SIZE_OFFSET). */
static double log_size_slope(double x) {
    return 1 / (x + NQM_SIZE_OFFSET);
}

/* Derivative by `sum` of the size of the root of the mean. */
static double root_mean_slope(double sum, double n) {
    if (!(sum > 0 && n > 0))
        return 0;
    const double root = fmax(sqrt(sum / n), NQM_SMALL_MEAN);
    return log_size_slope(root) / (2 * n * root);
}

static double mean_slope(double n) {
    return n > 0 ? 1 / n : 0;
}

/* Add the derivatives by the sums of n parts; `by`: those by the contrast of all parts together, whose light is `sum`. */
static void contrast_slope(const nqm_light_sum *sum, nqm_light_ratio by, size_t n, nqm_light_sum *parts) {
    static const double unit[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const double floor = NQM_DARK * sum->n, by_ratio[3] = {by.u - 0.5 * by.v, -by.u - 0.5 * by.v, by.v};
    if (!(sum->n > 0))
        return;
    const double by_luminance = by.l / (nqm_luminance(sum->test) + floor);
    for (size_t k = 0; k < 3; ++k) {
        const double by_test = by_luminance * nqm_luminance(unit[k]) + by_ratio[k] / (sum->test[k] + floor);
        for (size_t i = 0; i < n; ++i)
            parts[i].test[k] += by_test;
    }
}

/* The same for the log ratio of luminance of n of the cells. */
static void bias_slope(const nqm_light_sum *cells, double weight, size_t n, nqm_light_sum *by_cells) {
    const nqm_light_sum sum = nqm_lights_join(cells, n);
    contrast_slope(&sum, (nqm_light_ratio){.l = weight}, n, by_cells);
}

static void smooth_slopes(const nqm_scalar_sums *s, const double *w, nqm_scalar_sums *by) {
    nqm_light_ratio c[NQM_CELLS];
    double l2 = 0, uv2 = 0;
    for (size_t i = 0; i < NQM_CELLS; ++i) {
        c[i] = nqm_light_contrast(&s->cell[i]);
        l2 += s->cell[i].n * c[i].l * c[i].l;
        uv2 += s->cell[i].n * (c[i].u * c[i].u + c[i].v * c[i].v);
    }
    const double by_l2 = w[NQM_SCALAR_SMOOTH] * root_mean_slope(l2, s->n);
    const double by_uv2 = w[NQM_SCALAR_SMOOTH_CHROMA] * root_mean_slope(uv2, s->n);
    for (size_t i = 0; i < NQM_CELLS; ++i) {
        const double n2 = 2 * s->cell[i].n;
        const nqm_light_ratio by_c = {by_l2 * n2 * c[i].l, by_uv2 * n2 * c[i].u, by_uv2 * n2 * c[i].v};
        contrast_slope(&s->cell[i], by_c, 1, &by->cell[i]);
    }
}

static void zone_slopes(const nqm_scalar_sums *s, const double *w, nqm_scalar_sums *by) {
    for (size_t z = 0; z < NQM_ZONES_H; ++z) {
        const size_t first = z * NQM_ZONES_D;
        const double n = nqm_lights_join(s->cell + first, NQM_ZONES_D).n;
        bias_slope(s->cell + first, w[NQM_SCALAR_ZONE_BIAS + z], NQM_ZONES_D, by->cell + first);
        by->zone_l2[z] = w[NQM_SCALAR_ZONE_RMS + z] * root_mean_slope(s->zone_l2[z], n);
    }
    const size_t first = NQM_HIGHLIGHT_CELLS;
    bias_slope(s->cell, w[NQM_SCALAR_WIDTH], first, by->cell);
    bias_slope(s->cell + first, -w[NQM_SCALAR_WIDTH], NQM_CELLS - first, by->cell + first);
    by->grazing_l = w[NQM_SCALAR_GRAZING_BIAS] * mean_slope(s->grazing_n);
    by->grazing_l2 = w[NQM_SCALAR_GRAZING_RMS] * root_mean_slope(s->grazing_l2, s->grazing_n);
    smooth_slopes(s, w, by);
}

static void energy_slopes(const nqm_scalar_sums *s, const double *w, nqm_scalar_sums *by) {
    const nqm_light_ratio c = nqm_light_contrast(&s->weighted);
    const double chroma = hypot(c.u, c.v);
    const double by_chroma = chroma > 0 ? w[NQM_SCALAR_ENERGY_CHROMA] * log_size_slope(chroma) / chroma : 0;
    const nqm_light_ratio by_c = {w[NQM_SCALAR_ENERGY], by_chroma * c.u, by_chroma * c.v};
    contrast_slope(&s->weighted, by_c, 1, &by->weighted);
}

static void whole_slopes(const nqm_scalar_sums *s, const double *w, nqm_scalar_sums *by) {
    const double n = s->n, bias = s->l / n, variance = s->l2 / n - bias * bias;
    const double tail = sqrt(sqrt(s->l4 / n)), root = s->root_l / n;
    const double by_variance = w[NQM_SCALAR_SHAPE] * root_mean_slope(variance, 1);
    by->squares = w[NQM_SCALAR_RMS] * root_mean_slope(s->squares, 3 * n);
    by->max_l = w[NQM_SCALAR_MAX] * log_size_slope(s->max_l);
    by->l4 = s->l4 > 0 ? w[NQM_SCALAR_TAIL] * log_size_slope(tail) * tail / (4 * s->l4) : 0;
    by->root_l = w[NQM_SCALAR_BULK] * log_size_slope(root * root) * 2 * root / n;
    by->l = (w[NQM_SCALAR_BIAS] - by_variance * 2 * bias) / n;
    by->l2 = by_variance / n;
    by->uv2 = w[NQM_SCALAR_CHROMA] * root_mean_slope(s->uv2, n);
    by->u = w[NQM_SCALAR_CHROMA_RG] / n;
    by->v = w[NQM_SCALAR_CHROMA_B] / n;
    by->peak_test = w[NQM_SCALAR_PEAK] / (s->peak_test + NQM_DARK);
    energy_slopes(s, w, by);
}

/* The derivatives of weighted scalar features (NQM_SCALAR_COUNT) by the sums of a pair. Features from
 * NQM_SCALAR_ESTIMATE are the caller's: their weights are ignored. */
static nqm_pair_sums sum_slopes(const nqm_pair_sums *sums, const double *scalar_weights) {
    nqm_pair_sums by = {0};
    double metrics[NQM_METRIC_COUNT], weights[NQM_METRIC_COUNT] = {0};
    if (!(sums->metrics.n > 0))
        return by;
    nqm_metric_sums_finish(&sums->metrics, metrics);
    for (size_t m = 0; m < NQM_SCALAR_RMS; ++m)
        weights[m] += scalar_weights[NQM_SCALAR_METRICS + m] / (metrics[m] + NQM_LOG_METRIC_OFFSET);
    by.metrics = nqm_metric_slopes(&sums->metrics, weights);
    whole_slopes(&sums->scalars, scalar_weights, &by.scalars);
    zone_slopes(&sums->scalars, scalar_weights, &by.scalars);
    return by;
}

void nqm_compare_gradient(const nqm_compared_pair *p, const double *scalar_weights, float *gradient) {
    const nqm_pair_sums sums = nqm_exact_sums(p);
    nqm_sums_gradient(p, sum_slopes(&sums, scalar_weights), gradient);
}
