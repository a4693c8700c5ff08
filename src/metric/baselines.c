/* SPDX-License-Identifier: MIT
 *
 * The scalar metrics in BRDF space: the paper's eight baselines (section 4: cube root after Fores et al. 2012, DOI
 * 10.2352/CIC.2012.20.1.art00025; logarithm after Low et al. 2012, DOI 10.1145/2077341.2077350) and the mean absolute
 * log difference. Means run over directions and channels, in double.
 */
#include "kernel/kernel.h"
#include "math/math.h"
#include "metric/scaled.h"

#include <math.h>
#include <string.h>

static const char *const names[NQM_METRIC_COUNT] = {"rmse",    "mae",       "rms_crwe", "ma_crwe", "rms_loge",
                                                    "ma_loge", "rms_logwe", "ma_logwe", "log_diff"};

const char *nqm_metric_name(nqm_metric metric) {
    return names[metric];
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

/* ---- sums -------------------------------------------------------------------------------------------------------- */

void nqm_metric_sums_add(nqm_metric_sums *sums, const nqm_scaled *ref, const nqm_scaled *test, const double *weight) {
    for (size_t k = 0; k < NQM_SCALES; ++k) {
        const double *a = ref->scale[k], *b = test->scale[k];
        double squares = 0, absolutes = 0;
#pragma omp simd reduction(+ : squares, absolutes)
        for (size_t i = 0; i < 3 * NQM_STRETCH; ++i) {
            double d = weight[i] * (b[i] - a[i]);
            squares += d * d;
            absolutes += fabs(d);
        }
        sums->squares[k] += squares;
        sums->absolutes[k] += absolutes;
    }
    for (size_t i = 0; i < 3 * NQM_STRETCH; ++i)
        sums->n += weight[i];
}

void nqm_metric_sums_finish(const nqm_metric_sums *sums, double *metrics) {
    for (int k = 0; k < NQM_SCALES_PAPER; ++k) { /* 0/0 is the NaN that is promised */
        metrics[NQM_METRIC_RMSE + 2 * k] = sqrt(sums->squares[k] / sums->n);
        metrics[NQM_METRIC_MAE + 2 * k] = sums->absolutes[k] / sums->n;
    }
    metrics[NQM_METRIC_LOG_DIFF] = sums->absolutes[NQM_SCALE_LOG_F] / sums->n;
}
