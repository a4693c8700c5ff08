/* SPDX-License-Identifier: MIT
 *
 * The scalar metrics in BRDF space: the paper's eight baselines (section 4: cube root after Fores et al. 2012, DOI
 * 10.2352/CIC.2012.20.1.art00025; logarithm after Low et al. 2012, DOI 10.1145/2077341.2077350) and the mean absolute
 * log difference. Means run over directions and channels, in double.
 */
#include "metric/metric.h"

#include <math.h>

static const char *const names[NQM_METRIC_COUNT] = {"rmse",    "mae",       "rms_crwe", "ma_crwe", "rms_loge",
                                                    "ma_loge", "rms_logwe", "ma_logwe", "log_diff"};

const char *nqm_metric_name(nqm_metric metric) {
    return names[metric];
}

/* The scales on which reflectance is compared. The first N_PAPER make two baselines each, RMS and mean absolute. */
enum { N_PAPER = 4, N_SCALES };

static void rescale(double f, double cosines, double *v) {
    v[0] = f;
    v[1] = cbrt(cosines * f);
    v[2] = log1p(f);
    v[3] = log1p(cosines * f);
    v[4] = log(f + 0.003);
}

void nqm_metrics_compute(const nqm_directions *directions, const float *ref, const float *test, const uint8_t *used,
                         double *metrics) {
    double squares[N_SCALES] = {0}, absolutes[N_SCALES] = {0};
    size_t n = 0;
    for (size_t i = 0; i < 3 * directions->n; ++i) {
        if (used && !used[i / 3])
            continue;
        double a[N_SCALES], b[N_SCALES];
        rescale((double)ref[i], directions->cosines[i / 3], a);
        rescale((double)test[i], directions->cosines[i / 3], b);
        for (int k = 0; k < N_SCALES; ++k) {
            squares[k] += (b[k] - a[k]) * (b[k] - a[k]);
            absolutes[k] += fabs(b[k] - a[k]);
        }
        ++n;
    }
    for (int k = 0; k < N_PAPER; ++k) { /* 0/0 is the NaN that is promised */
        metrics[NQM_METRIC_RMSE + 2 * k] = sqrt(squares[k] / (double)n);
        metrics[NQM_METRIC_MAE + 2 * k] = absolutes[k] / (double)n;
    }
    metrics[NQM_METRIC_LOG_DIFF] = absolutes[N_PAPER] / (double)n;
}
