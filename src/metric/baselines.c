/* SPDX-License-Identifier: MIT
 *
 * The scalar metrics in BRDF space, by the table of math/values.h: the paper's eight baselines (section 4; cube root: Fores et al.
 * 2012, DOI 10.2352/CIC.2012.20.1.art00025; logarithm: Low et al. 2012, DOI 10.1145/2077341.2077350) and the mean
 * absolute log difference.
 */
#include "metric/sums.h"

#include <math.h>

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
