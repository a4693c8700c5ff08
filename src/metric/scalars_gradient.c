/* SPDX-License-Identifier: MIT
 *
 * Derivatives of metrics and scalar features by the samples of the test: reverse-mode differentiation of sums.c and
 * scalars.c, by hand. A first pass over the directions computes the sums; from them follow the derivatives by each sum, and a
 * second pass continues to the samples. Derivatives have the type of what they are derivatives by.
 */
#include "math/math.h"
#include "metric/sums.h"

#include <math.h>

/* ---- from features to sums --------------------------------------------------------------------------------------- */

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

/* Derivatives by each sum; pair->metrics.n > 0. metric_weights or scalar_weights may be NULL. */
static nqm_pair_sums sum_slopes(const nqm_pair_sums *pair, const double *metric_weights, const double *scalar_weights) {
    nqm_pair_sums by = {0};
    double metrics[NQM_METRIC_COUNT], weights[NQM_METRIC_COUNT];
    nqm_metric_sums_finish(&pair->metrics, metrics);
    for (size_t m = 0; m < NQM_METRIC_COUNT; ++m) {
        weights[m] = metric_weights ? metric_weights[m] : 0;
        if (scalar_weights && m < NQM_SCALAR_RMS)
            weights[m] += scalar_weights[NQM_SCALAR_METRICS + m] / (metrics[m] + NQM_LOG_METRIC_OFFSET);
    }
    by.metrics = nqm_metric_slopes(&pair->metrics, weights);
    if (scalar_weights) {
        whole_slopes(&pair->scalars, scalar_weights, &by.scalars);
        zone_slopes(&pair->scalars, scalar_weights, &by.scalars);
    }
    return by;
}

/* ---- from sums to samples ---------------------------------------------------------------------------------------- */

typedef double scale_slopes[NQM_SCALES][3 * NQM_STRETCH];

/* Derivative by log luminance of one direction. by->max_l and by->peak_test become 0 where they are used up: the first
 * direction that attains a maximum takes them. */
static double by_log_luminance(const nqm_scalar_sums *s, double l, size_t zone, bool is_grazing, nqm_scalar_sums *by) {
    const double sign = (l > 0) - (l < 0);
    const double large = fmax(fabs(l), NQM_SMALL_ROOT);
    double slope = by->l + 2 * l * (by->l2 + by->zone_l2[zone]) + 4 * l * l * l * by->l4;
    slope += by->root_l * 0.5 * l / (large * sqrt(large));
    if (is_grazing)
        slope += by->grazing_l + 2 * l * by->grazing_l2;
    if (fabs(l) >= s->max_l) {
        slope += sign * by->max_l;
        by->max_l = 0;
    }
    return slope;
}

/* Add the derivatives by direction i of a stretch. */
static void direction_slopes(const nqm_scalar_sums *s, const double *degrees, double cosines, const nqm_scaled *ref,
                             const nqm_scaled *test, size_t i, nqm_scalar_sums *by, scale_slopes by_scale) {
    static const double unit[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const nqm_log_difference x = nqm_difference_at(ref, test, i);
    const size_t cell = nqm_cell_of(degrees);
    double by_luminance =
        by_log_luminance(s, x.l, cell / NQM_ZONES_D, nqm_is_grazing(cosines), by) / (test->luminance[i] + NQM_DARK);
    if (test->luminance[i] >= s->peak_test) {
        by_luminance += by->peak_test;
        by->peak_test = 0;
    }
    const double by_u = by->u + 2 * x.u * by->uv2, by_v = by->v + 2 * x.v * by->uv2;
    const double by_opponents[3] = {by_u - 0.5 * by_v, -by_u - 0.5 * by_v, by_v};
    for (size_t k = 0; k < 3; ++k) {
        by_scale[NQM_SCALE_LOG_F][3 * i + k] += 2 * x.d[k] * by->squares + by_opponents[k];
        by_scale[NQM_SCALE_F][3 * i + k] +=
            by->cell[cell].test[k] + cosines * by->weighted.test[k] + by_luminance * nqm_luminance(unit[k]);
    }
}

/* Set one stretch of the gradient of test k. */
static void stretch_gradient(const nqm_comparison *c, size_t k, size_t stretch, const nqm_scaled *ref,
                             const nqm_pair_sums *pair, bool with_scalars, nqm_pair_sums *by, double *gradient) {
    const nqm_directions *directions = c->directions;
    const size_t first = stretch * NQM_STRETCH, n = nqm_stretch_size(directions->n, stretch);
    nqm_test_stretch s;
    scale_slopes by_scale = {0};
    nqm_test_stretch_read(c, k, stretch, &s);
    nqm_metric_slopes_add(&by->metrics, ref, &s.test, s.weight, by_scale);
    for (size_t i = 0; with_scalars && i < n; ++i)
        if (s.weight[3 * i] > 0)
            direction_slopes(&pair->scalars, directions->degrees + 3 * (first + i), directions->cosines[first + i], ref,
                             &s.test, i, &by->scalars, by_scale);
    nqm_unscale_stretch(directions, stretch, &s.test, by_scale, gradient);
}

void nqm_compare_gradient(const nqm_comparison *c, const nqm_pair_sums *pair, const double *metric_weights,
                          const double *scalar_weights, double *gradient) {
    nqm_pair_sums by[NQM_COMPARE_MAX] = {0}; /* stays 0 for a test without directions */
    for (size_t k = 0; k < c->n; ++k)
        if (pair[k].metrics.n > 0)
            by[k] = sum_slopes(&pair[k], metric_weights ? metric_weights + k * NQM_METRIC_COUNT : NULL,
                               scalar_weights ? scalar_weights + k * NQM_SCALAR_COUNT : NULL);
    for (size_t stretch = 0; stretch * NQM_STRETCH < c->directions->n; ++stretch) {
        nqm_scaled ref;
        nqm_scale_stretch(c->directions, stretch, c->ref, &ref);
        for (size_t k = 0; k < c->n; ++k)
            stretch_gradient(c, k, stretch, &ref, &pair[k], scalar_weights != NULL, &by[k],
                             gradient + k * 3 * c->directions->n);
    }
}

void nqm_metrics_gradient(const nqm_directions *directions, const float *ref, const float *test, const uint8_t *used,
                          const double *weights, double *gradient) {
    const nqm_comparison comparison = {directions, ref, 1, &test, used, NULL};
    nqm_pair_sums sums;
    nqm_compare_sums(&comparison, false, &sums);
    nqm_compare_gradient(&comparison, &sums, weights, NULL, gradient);
}

void nqm_scalars_gradient(const nqm_directions *directions, const float *ref, const float *test, const uint8_t *used,
                          const double *weights, double *gradient) {
    const nqm_comparison comparison = {directions, ref, 1, &test, used, NULL};
    nqm_pair_sums sums;
    nqm_compare_sums(&comparison, true, &sums);
    nqm_compare_gradient(&comparison, &sums, NULL, weights, gradient);
}
