/* SPDX-License-Identifier: MIT
 *
 * scaled.h - samples of a BRDF on the nonlinear scales that metrics and scalar features compare. Roots and logarithms
 * take most of the time of a comparison, so those of a reference are computed once for all its tests.
 */
#ifndef NQM_SRC_METRIC_SCALED_H
#define NQM_SRC_METRIC_SCALED_H

#include "math/values.h"
#include "metric/metric.h"

enum { NQM_STRETCH = 64 }; /**< directions per stretch, which are processed together */

/** Scales of reflectance f; c = cos(theta_i) cos(theta_o). */
enum { NQM_SCALE_F, NQM_SCALE_CBRT_CF, NQM_SCALE_LOG1P_F, NQM_SCALE_LOG1P_CF, NQM_SCALE_LOG_F, NQM_SCALES };

/** A stretch of directions of one BRDF; 0 after the last direction. */
typedef struct nqm_scaled {
    double scale[NQM_SCALES][3 * NQM_STRETCH];
    double luminance[NQM_STRETCH], log_luminance[NQM_STRETCH]; /**< luminance of f; log(luminance + NQM_DARK) */
} nqm_scaled;

static inline size_t nqm_stretch_size(size_t n_directions, size_t stretch) {
    size_t left = n_directions - stretch * NQM_STRETCH;
    return left < NQM_STRETCH ? left : NQM_STRETCH;
}

/** Compute the scales of one stretch of rgb (n_directions, 3), f_r in 1/sr. */
void nqm_scale_stretch(const nqm_directions *directions, size_t stretch, const float *rgb, nqm_scaled *scaled);

/** Sums over directions and channels: n, the number of values, and those of the magnitudes and squares of differences on each
 *  scale. */
typedef struct nqm_metric_sums {
    double n, magnitudes[NQM_SCALES], squares[NQM_SCALES];
} nqm_metric_sums;

/** Add a stretch. weight: (3 NQM_STRETCH) 1 where a value counts, else 0. */
void nqm_metric_sums_add(nqm_metric_sums *sums, const nqm_scaled *ref, const nqm_scaled *test, const double *weight);
/** Compute metrics (NQM_METRIC_COUNT) from the sums. */
void nqm_metric_sums_finish(const nqm_metric_sums *sums, double *metrics);

/** Derivatives, back from the metrics to samples: those of sum weights_m metric_m by the sums (n > 0) of all stretches, 0 where
 *  they are infinite. weights: (NQM_METRIC_COUNT). */
nqm_metric_sums nqm_metric_slopes(const nqm_metric_sums *sums, const double *weights);

#endif
