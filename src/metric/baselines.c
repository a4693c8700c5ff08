/* SPDX-License-Identifier: MIT
 *
 * The scalar metrics in BRDF space, by the table of math/values.h: the paper's eight baselines (section 4; cube root: Fores et al.
 * 2012, DOI 10.2352/CIC.2012.20.1.art00025; logarithm: Low et al. 2012, DOI 10.1145/2077341.2077350) and the mean
 * absolute log difference. Sums over directions and channels are in double.
 */
#include "math/math.h"
#include "metric/scaled.h"
#include "sample/loops.h"

#include <math.h>
#include <string.h>

/* ---- the table --------------------------------------------------------------------------------------------------- */

static const nqm_value_difference rows[NQM_METRIC_COUNT] = {NQM_VALUE_METRICS(NQM_VALUE_ROW)};

#define MEAN_1                                        "mean absolute difference of "
#define MEAN_2                                        "root mean square difference of "
#define DESCRIPTION(name, of, curve, weighted, power) MEAN_##power of,
static const char *const descriptions[NQM_METRIC_COUNT] = {NQM_VALUE_METRICS(DESCRIPTION)};

nqm_metric_info nqm_metric_get_info(nqm_metric metric) {
    return (nqm_metric_info){.name = rows[metric].name,
                             .description = descriptions[metric],
                             .family = rows[metric].of,
                             .is_baseline = metric < NQM_METRIC_LOG_DIFF};
}

const char *nqm_metric_name(nqm_metric metric) {
    return rows[metric].name;
}

/* NQM_SCALE_* of a metric. */
static int scale_of(size_t metric) {
    static const int by_curve[] = {[NQM_VALUE_LINEAR] = NQM_SCALE_F,
                                   [NQM_VALUE_CUBE_ROOT] = NQM_SCALE_CBRT_CF,
                                   [NQM_VALUE_LOG] = NQM_SCALE_LOG1P_CF,
                                   [NQM_VALUE_LOG_DARK] = NQM_SCALE_LOG_F};
    const nqm_value_difference *row = &rows[metric];
    return row->curve == NQM_VALUE_LOG && !row->weighted ? NQM_SCALE_LOG1P_F : by_curve[row->curve];
}

/* ---- sums -------------------------------------------------------------------------------------------------------- */

void nqm_metric_sums_add(nqm_metric_sums *sums, const nqm_scaled *ref, const nqm_scaled *test, const double *weight) {
    for (size_t s = 0; s < NQM_SCALES; ++s) {
        const double *a = ref->scale[s], *b = test->scale[s];
        double magnitudes = 0, squares = 0;
#pragma omp simd reduction(+ : magnitudes, squares)
        for (size_t i = 0; i < 3 * NQM_STRETCH; ++i) {
            const double d = weight[i] * (b[i] - a[i]);
            magnitudes += fabs(d);
            squares += d * d;
        }
        sums->magnitudes[s] += magnitudes;
        sums->squares[s] += squares;
    }
    for (size_t i = 0; i < 3 * NQM_STRETCH; ++i)
        sums->n += weight[i];
}

void nqm_metric_sums_finish(const nqm_metric_sums *sums, double *metrics) {
    for (size_t m = 0; m < NQM_METRIC_COUNT; ++m) {
        const int s = scale_of(m);
        metrics[m] = rows[m].power == 2 ? sqrt(sums->squares[s] / sums->n) : sums->magnitudes[s] / sums->n;
    }
}

nqm_metric_sums nqm_metric_slopes(const nqm_metric_sums *sums, const double *weights) {
    nqm_metric_sums by = {0};
    for (size_t m = 0; m < NQM_METRIC_COUNT; ++m) {
        const int s = scale_of(m);
        const double sum = sums->squares[s];
        if (rows[m].power == 1)
            by.magnitudes[s] += weights[m] / sums->n;
        else if (sum > 0)
            by.squares[s] += weights[m] * 0.5 / sqrt(sum * sums->n);
    }
    return by;
}

/* ---- scales ------------------------------------------------------------------------------------------------------ */

/* y = log(x + NQM_DARK) */
static void log_of(size_t n, const double *x, double *y) {
    double above[3 * NQM_STRETCH];
    for (size_t i = 0; i < n; ++i)
        above[i] = x[i] + (NQM_DARK - 1);
    nqm_sample_log_1p(n, above, y);
}

void nqm_scale_stretch(const nqm_directions *directions, size_t stretch, const float *rgb, nqm_scaled *scaled) {
    const size_t first = stretch * NQM_STRETCH, n = nqm_stretch_size(directions->n, stretch);
    double weighted[3 * NQM_STRETCH] = {0};
    double *f = scaled->scale[NQM_SCALE_F];
    if (n < NQM_STRETCH)
        memset(scaled, 0, sizeof *scaled);
    for (size_t i = 0; i < 3 * n; ++i) {
        f[i] = (double)rgb[3 * first + i];
        weighted[i] = directions->cosines[first + i / 3] * f[i];
    }
    for (size_t i = 0; i < n; ++i)
        scaled->luminance[i] = nqm_luminance(f + 3 * i);
    nqm_sample_cube_roots(3 * n, weighted, scaled->scale[NQM_SCALE_CBRT_CF]);
    nqm_sample_log_1p(3 * n, f, scaled->scale[NQM_SCALE_LOG1P_F]);
    nqm_sample_log_1p(3 * n, weighted, scaled->scale[NQM_SCALE_LOG1P_CF]);
    log_of(3 * n, f, scaled->scale[NQM_SCALE_LOG_F]);
    log_of(n, scaled->luminance, scaled->log_luminance);
}
