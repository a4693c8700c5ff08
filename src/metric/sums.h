/* SPDX-License-Identifier: MIT
 *
 * sums.h - sums over the directions of a pair, from which its metrics and scalar features are computed. Derivatives take
 * the same way back: by the sums, then by the samples of each direction.
 */
#ifndef NQM_SRC_METRIC_SUMS_H
#define NQM_SRC_METRIC_SUMS_H

#include "metric/scaled.h"

#define NQM_SIZE_OFFSET       1e-3 /**< a feature that is a size x >= 0 is log(x + NQM_SIZE_OFFSET), finite at 0 */
#define NQM_LOG_METRIC_OFFSET 1e-4 /**< the same for metrics */

/** Below these, the slopes of the root of a log difference and of the root of a mean fall to 0 linearly. Otherwise samples that
 *  differ by rounding only would have most of the gradient, and any step along it would jump over their zeros. */
#define NQM_SMALL_ROOT 3e-3
#define NQM_SMALL_MEAN 5e-3

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

/** How the members differ in one direction: d of log f_r, l of log luminance, u and v of the opponent channels of log f_r. */
typedef struct nqm_log_difference {
    double d[3], l, u, v;
} nqm_log_difference;
/** That of direction i of a stretch. */
static inline nqm_log_difference nqm_difference_at(const nqm_scaled *ref, const nqm_scaled *test, size_t i) {
    const double *a = ref->scale[NQM_SCALE_LOG_F] + 3 * i, *b = test->scale[NQM_SCALE_LOG_F] + 3 * i;
    const double d[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    return (nqm_log_difference){
        {d[0], d[1], d[2]}, test->log_luminance[i] - ref->log_luminance[i], d[0] - d[1], d[2] - 0.5 * (d[0] + d[1])};
}

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

/** One stretch of test k of a comparison. weight: (3 NQM_STRETCH) 1 where a value counts, else 0. */
typedef struct nqm_test_stretch {
    nqm_scaled test;
    double weight[3 * NQM_STRETCH];
} nqm_test_stretch;
void nqm_test_stretch_read(const nqm_comparison *comparison, size_t k, size_t stretch, nqm_test_stretch *to);

/** Compute the sums (n of the comparison). Without scalars, pair[k].scalars are 0. */
void nqm_compare_sums(const nqm_comparison *comparison, bool with_scalars, nqm_pair_sums *pair);
/** What depends only on the directions in the same sums by the kernels, in float. The directions must outlive it. */
typedef struct nqm_sum_plan nqm_sum_plan;
NQM_MUST_CHECK nqm_status nqm_sum_plan_create(const nqm_directions *directions, nqm_sum_plan **plan_ret,
                                              nqm_error *err);
void nqm_sum_plan_free(nqm_sum_plan *plan);
/** Compute the sums (n of the comparison) of nqm_compare_sums() several times as fast. They differ by rounding: JODs by less
 *  than 1e-4.
 *
 * @param roots  (1 + n, n_directions, 3) cube roots of the reference and the tests, from sample_log()
 */
void nqm_compare_sums_float(const nqm_sum_plan *plan, const nqm_comparison *comparison, const float *roots,
                            bool with_scalars, nqm_pair_sums *pair);
/** Compute metrics (n, NQM_METRIC_COUNT) and scalar features (n, NQM_SCALAR_COUNT) from them; either may be NULL. */
void nqm_compare_finish(const nqm_comparison *comparison, const nqm_pair_sums *pair, double *metrics, double *scalars);

/**
 * The derivatives of weighted sums of metrics and scalar features by the samples of the tests. The subgradients are those of
 * nqm_scalars_gradient().
 *
 * @param pair             (n) from nqm_compare_sums(), with scalars unless scalar_weights is NULL
 * @param metric_weights   (n, NQM_METRIC_COUNT) NULL: 0
 * @param scalar_weights   (n, NQM_SCALAR_COUNT) those from NQM_SCALAR_ESTIMATE are ignored; NULL: 0
 * @param gradient         (n, n_directions, 3) receives them
 */
void nqm_compare_gradient(const nqm_comparison *comparison, const nqm_pair_sums *pair, const double *metric_weights,
                          const double *scalar_weights, double *gradient);

#endif
