/* SPDX-License-Identifier: MIT
 *
 * The scalar metrics in BRDF space, one table row each: the paper's eight baselines (section 4; cube root: Fores et al.
 * 2012, DOI 10.2352/CIC.2012.20.1.art00025; logarithm: Low et al. 2012, DOI 10.1145/2077341.2077350) and the mean
 * absolute log difference. Sums over directions and channels are in double.
 */
#include "kernel/kernel.h"
#include "math/math.h"
#include "metric/scaled.h"

#include <math.h>
#include <string.h>

/* ---- the table --------------------------------------------------------------------------------------------------- */

/* Sums over a stretch (NQM_STRETCH directions). a, b: (3 NQM_STRETCH) values of the reference and the test; weight:
 * (3 NQM_STRETCH) 1 where a value counts, else 0. */
static double sum_of_squares(const double *a, const double *b, const double *weight) {
    double sum = 0;
#pragma omp simd reduction(+ : sum)
    for (size_t i = 0; i < 3 * NQM_STRETCH; ++i) {
        const double d = weight[i] * (b[i] - a[i]);
        sum += d * d;
    }
    return sum;
}

static double sum_of_magnitudes(const double *a, const double *b, const double *weight) {
    double sum = 0;
#pragma omp simd reduction(+ : sum)
    for (size_t i = 0; i < 3 * NQM_STRETCH; ++i)
        sum += fabs(weight[i] * (b[i] - a[i]));
    return sum;
}

static double mean(double sum, double n) {
    return sum / n; /* n = 0: NaN, as documented */
}

static double root_mean(double sum, double n) {
    return sqrt(sum / n);
}

/* Derivatives of the two kinds of sums by b, added to by_b; slope: derivative of the result by the sum. */
static void squares_slope(double slope, const double *a, const double *b, const double *weight, double *by_b) {
#pragma omp simd
    for (size_t i = 0; i < 3 * NQM_STRETCH; ++i)
        by_b[i] += slope * weight[i] * 2 * (b[i] - a[i]);
}

static void magnitudes_slope(double slope, const double *a, const double *b, const double *weight, double *by_b) {
#pragma omp simd
    for (size_t i = 0; i < 3 * NQM_STRETCH; ++i)
        by_b[i] += slope * weight[i] * ((b[i] > a[i] ? 1. : 0.) - (b[i] < a[i] ? 1. : 0.));
}

/* Derivatives of mean() and root_mean() by the sum. */
static double mean_slope(double sum, double n) {
    (void)sum;
    return 1 / n;
}

static double root_mean_slope(double sum, double n) {
    return sum > 0 ? 0.5 / sqrt(sum * n) : 0;
}

/* A metric is finish(sum of add() over all stretches, number of values). A new metric needs an enumerator and a row;
 * its JSON key, column, option value and row in reports are derived from them. */
typedef struct metric_row {
    nqm_metric_info info;
    int scale; /* NQM_SCALE_* of the compared values */
    double (*add)(const double *a, const double *b, const double *weight);
    double (*finish)(double sum, double n);
    void (*add_slope)(double slope, const double *a, const double *b, const double *weight, double *by_b);
    double (*finish_slope)(double sum, double n);
} metric_row;

#define RMS(scale_, name_, of)                                                                                         \
    {                                                                                                                  \
        {name_, "root mean square difference of " of, of, 1}, scale_, sum_of_squares, root_mean, squares_slope,        \
            root_mean_slope                                                                                            \
    }
#define MEAN(scale_, name_, of, is_baseline_)                                                                          \
    {                                                                                                                  \
        {name_, "mean absolute difference of " of, of, is_baseline_}, scale_, sum_of_magnitudes, mean,                 \
            magnitudes_slope, mean_slope                                                                               \
    }
#define CUBE_ROOT "\xe2\x88\x9b(c f)"

static const metric_row rows[NQM_METRIC_COUNT] = {
    [NQM_METRIC_RMSE] = RMS(NQM_SCALE_F, "rmse", "f"),
    [NQM_METRIC_MAE] = MEAN(NQM_SCALE_F, "mae", "f", 1),
    [NQM_METRIC_RMS_CRWE] = RMS(NQM_SCALE_CBRT_CF, "rms_crwe", CUBE_ROOT),
    [NQM_METRIC_MA_CRWE] = MEAN(NQM_SCALE_CBRT_CF, "ma_crwe", CUBE_ROOT, 1),
    [NQM_METRIC_RMS_LOGE] = RMS(NQM_SCALE_LOG1P_F, "rms_loge", "log(1 + f)"),
    [NQM_METRIC_MA_LOGE] = MEAN(NQM_SCALE_LOG1P_F, "ma_loge", "log(1 + f)", 1),
    [NQM_METRIC_RMS_LOGWE] = RMS(NQM_SCALE_LOG1P_CF, "rms_logwe", "log(1 + c f)"),
    [NQM_METRIC_MA_LOGWE] = MEAN(NQM_SCALE_LOG1P_CF, "ma_logwe", "log(1 + c f)", 1),
    [NQM_METRIC_LOG_DIFF] = MEAN(NQM_SCALE_LOG_F, "log_diff", "log(f + 0.003)", 0),
};

nqm_metric_info nqm_metric_get_info(nqm_metric metric) {
    return rows[metric].info;
}

const char *nqm_metric_name(nqm_metric metric) {
    return rows[metric].info.name;
}

void nqm_metric_sums_add(nqm_metric_sums *sums, const nqm_scaled *ref, const nqm_scaled *test, const double *weight) {
    for (size_t m = 0; m < NQM_METRIC_COUNT; ++m)
        sums->sum[m] += rows[m].add(ref->scale[rows[m].scale], test->scale[rows[m].scale], weight);
    for (size_t i = 0; i < 3 * NQM_STRETCH; ++i)
        sums->n += weight[i];
}

void nqm_metric_sums_add_scale(nqm_metric_sums *sums, int scale, double magnitudes, double squares) {
    for (size_t m = 0; m < NQM_METRIC_COUNT; ++m)
        if (rows[m].scale == scale)
            sums->sum[m] += rows[m].add == sum_of_squares ? squares : magnitudes;
}

void nqm_metric_sums_finish(const nqm_metric_sums *sums, double *metrics) {
    for (size_t m = 0; m < NQM_METRIC_COUNT; ++m)
        metrics[m] = rows[m].finish(sums->sum[m], sums->n);
}

void nqm_metric_slopes(const nqm_metric_sums *sums, double *slopes) {
    for (size_t m = 0; m < NQM_METRIC_COUNT; ++m)
        slopes[m] = rows[m].finish_slope(sums->sum[m], sums->n);
}

void nqm_metric_slopes_add(const double *slopes, const nqm_scaled *ref, const nqm_scaled *test, const double *weight,
                           double by_scale[NQM_SCALES][3 * NQM_STRETCH]) {
    for (size_t m = 0; m < NQM_METRIC_COUNT; ++m) {
        const int scale = rows[m].scale;
        rows[m].add_slope(slopes[m], ref->scale[scale], test->scale[scale], weight, by_scale[scale]);
    }
}

/* ---- scales ------------------------------------------------------------------------------------------------------ */

/* y = log(x + NQM_DARK) */
static void log_of(size_t n, const double *x, double *y) {
    double above[3 * NQM_STRETCH];
    for (size_t i = 0; i < n; ++i)
        above[i] = x[i] + (NQM_DARK - 1);
    nqm_kernels_get()->log_1p(n, above, y);
}

void nqm_scale_stretch(const nqm_directions *directions, size_t stretch, const float *rgb, nqm_scaled *scaled) {
    const nqm_kernels *kernels = nqm_kernels_get();
    const size_t first = stretch * NQM_STRETCH, n = nqm_stretch_size(directions->n, stretch);
    double weighted[3 * NQM_STRETCH];
    double *f = scaled->scale[NQM_SCALE_F];
    if (n < NQM_STRETCH)
        memset(scaled, 0, sizeof *scaled);
    for (size_t i = 0; i < 3 * n; ++i) {
        f[i] = (double)rgb[3 * first + i];
        weighted[i] = directions->cosines[first + i / 3] * f[i];
    }
    for (size_t i = 0; i < n; ++i)
        scaled->luminance[i] = nqm_luminance(f + 3 * i);
    kernels->cube_root(3 * n, weighted, scaled->scale[NQM_SCALE_CBRT_CF]);
    kernels->log_1p(3 * n, f, scaled->scale[NQM_SCALE_LOG1P_F]);
    kernels->log_1p(3 * n, weighted, scaled->scale[NQM_SCALE_LOG1P_CF]);
    log_of(3 * n, f, scaled->scale[NQM_SCALE_LOG_F]);
    log_of(n, scaled->luminance, scaled->log_luminance);
}

void nqm_unscale_stretch(const nqm_directions *directions, size_t stretch, const nqm_scaled *scaled,
                         double by_scale[NQM_SCALES][3 * NQM_STRETCH], double *gradient) {
    const size_t first = stretch * NQM_STRETCH, n = nqm_stretch_size(directions->n, stretch);
    const double *f = scaled->scale[NQM_SCALE_F], *root = scaled->scale[NQM_SCALE_CBRT_CF];
    const double min_root = cbrt(NQM_CUBE_ROOT_FLOOR);
    double cosines[3 * NQM_STRETCH];
    for (size_t i = 0; i < 3 * n; ++i)
        cosines[i] = directions->cosines[first + i / 3];
    for (size_t i = 0; i < 3 * n; ++i) {
        const double c = cosines[i], r = root[i] > min_root ? root[i] : min_root;
        gradient[3 * first + i] = by_scale[NQM_SCALE_F][i] + by_scale[NQM_SCALE_CBRT_CF][i] * c / (3 * r * r) +
                                  by_scale[NQM_SCALE_LOG1P_F][i] / (1 + f[i]) +
                                  by_scale[NQM_SCALE_LOG1P_CF][i] * c / (1 + c * f[i]) +
                                  by_scale[NQM_SCALE_LOG_F][i] / (f[i] + NQM_DARK);
    }
}
