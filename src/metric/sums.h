/* SPDX-License-Identifier: MIT
 *
 * sums.h - sums over the directions of a pair, from which its metrics and scalar features are computed. Derivatives take
 * the same way back: by the sums, then by the samples of each direction.
 */
#ifndef NQM_SRC_METRIC_SUMS_H
#define NQM_SRC_METRIC_SUMS_H

#include "math/values.h"
#include "metric/metric.h"

#define NQM_SIZE_OFFSET       1e-3 /**< a feature that is a size x >= 0 is log(x + NQM_SIZE_OFFSET), finite at 0 */
#define NQM_LOG_METRIC_OFFSET 1e-4 /**< the same for metrics */

/** Below these, the slopes of the root of a log difference and of the root of a mean fall to 0 linearly. Otherwise samples that
 *  differ by rounding only would have most of the gradient, and any step along it would jump over their zeros. */
#define NQM_SMALL_ROOT 3e-3
#define NQM_SMALL_MEAN 5e-3

/** Scales of reflectance f; c = cos(theta_i) cos(theta_o). */
enum { NQM_SCALE_F, NQM_SCALE_CBRT_CF, NQM_SCALE_LOG1P_F, NQM_SCALE_LOG1P_CF, NQM_SCALE_LOG_F, NQM_SCALES };

/** Sums over directions and channels: n, the number of values, and those of the magnitudes and squares of differences on each
 *  scale. */
typedef struct nqm_metric_sums {
    double n, magnitudes[NQM_SCALES], squares[NQM_SCALES];
} nqm_metric_sums;

/** Compute metrics (NQM_METRIC_COUNT) from the sums. */
void nqm_metric_sums_finish(const nqm_metric_sums *sums, double *metrics);
/** The derivatives of sum weights_m metric_m by the sums (n > 0), 0 where they are infinite. weights: (NQM_METRIC_COUNT). */
nqm_metric_sums nqm_metric_slopes(const nqm_metric_sums *sums, const double *weights);

/** Zones of theta_h and theta_d. A cell is one zone of each; cells of a zone of theta_h are consecutive. */
enum {
    NQM_ZONES_H = NQM_SCALAR_ZONES,
    NQM_ZONES_D = 3,
    NQM_CELLS = NQM_ZONES_H * NQM_ZONES_D,
    NQM_HIGHLIGHT_CELLS = 2 * NQM_ZONES_D /**< the first cells: theta_h below 5 degrees */
};

/** Sum of the reflectance of both members over a set of directions; n: number of directions, or sum of weights. */
typedef struct nqm_light_sum {
    double n, ref[3], test[3];
} nqm_light_sum;

/** Sums over directions; the letters are those of nqm_log_difference. */
typedef struct nqm_scalar_sums {
    double n, l, l2, l4, root_l, max_l, squares, u, v, uv2;
    double zone_l2[NQM_ZONES_H], grazing_n, grazing_l, grazing_l2;
    double ref_log, ref_log2, ref_colour2, peak_ref, peak_test;
    nqm_light_sum cell[NQM_CELLS];
    nqm_light_sum weighted; /**< by cos(theta_i) cos(theta_o) */
} nqm_scalar_sums;

/** Sums of one test and its reference. */
typedef struct nqm_pair_sums {
    nqm_metric_sums metrics;
    nqm_scalar_sums scalars;
} nqm_pair_sums;

/** Number of the cell that contains a direction (degrees of theta_h, theta_d). */
size_t nqm_cell_of(const double *degrees);
/** Whether a direction counts as grazing; cosines: cos(theta_i) cos(theta_o). */
bool nqm_is_grazing(double cosines);

/** Difference of summed reflectance. l: log ratio of luminance; u, v: opponent channels of the log ratios of RGB. */
typedef struct nqm_light_ratio {
    double l, u, v;
} nqm_light_ratio;
/** 0 for no direction. */
nqm_light_ratio nqm_light_contrast(const nqm_light_sum *sum);
/** The sum of n parts. */
nqm_light_sum nqm_lights_join(const nqm_light_sum *parts, size_t n);

/** Distances of which the similarity is a weighted sum, in units of Delta-E: Delta-E, lengths of the shift in I and in
 *  T and P, contrast times 30, structure, and the built-in distance. estimate, looks: of nqm_transport_estimates(). */
void nqm_apart_distances(const nqm_label *estimate, double looks, const nqm_metric_sums *sums, double apart[NQM_APART]);

/** Compute metrics (NQM_METRIC_COUNT) and scalar features (NQM_SCALAR_COUNT) from them; either may be NULL. estimate: by transport;
 *  NULL: none. */
void nqm_compare_finish(const nqm_pair_sums *sums, const nqm_label *estimate, double *metrics, double *scalars);

/** Compute the sums (n) of pairs; samples above 1e15 count as 1e15. Without scalars, only sums->metrics and the peaks are set.
 *
 * @param n      at most NQM_COMPARE_MAX
 * @param pairs  (n) of one reference
 * @param roots  (1 + n, n_directions, 3) cube roots of the reference and the tests, from nqm_sample_logs(); NULL: they are computed
 */
void nqm_compare_sums(const nqm_sum_plan *plan, size_t n, const nqm_sample_pair *pairs, const float *roots,
                      bool with_scalars, nqm_pair_sums *sums);

/** What nqm_compare_gradient() needs of a pair. */
typedef struct nqm_compared_pair {
    const nqm_sum_plan *plan;
    nqm_sample_pair pair;
    const float *ref_root, *test_root; /**< (n_directions, 3) cube roots */
    const nqm_pair_sums *sums;         /**< from nqm_compare_sums() */
} nqm_compared_pair;
/** The sums of the pair with those of reflectance in double: derivatives of opponent channels depend on small
 *  differences of them. */
nqm_pair_sums nqm_exact_sums(const nqm_compared_pair *compared);
/** The way back from derivatives by the sums to those by the samples of the test: as nqm_compare_gradient(). */
void nqm_sums_gradient(const nqm_compared_pair *compared, nqm_pair_sums by, float *gradient);
/**
 * Add the derivatives of weighted scalar features (scalar_weights: NQM_SCALAR_COUNT; those from NQM_SCALAR_ESTIMATE on
 * are ignored) by the samples of the test to gradient (n_directions, 3). Computed in float, within 1e-5 of the largest.
 * Where a derivative does not exist:
 * - abs(x) and sqrt(x) at 0, norms at 0: 0, so that equal pairs have finite derivatives; towards it, slopes of roots fall linearly
 *   (NQM_SMALL_ROOT, NQM_SMALL_MEAN);
 * - a maximum: that of the first direction that attains it;
 * - the cube root of c f (c = cos(theta_i) cos(theta_o)): as if c f were at least NQM_CUBE_ROOT_FLOOR;
 * - test at 0: from the right.
 * They are 0 where a direction is not used.
 */
void nqm_compare_gradient(const nqm_compared_pair *compared, const double *scalar_weights, float *gradient);

#endif
