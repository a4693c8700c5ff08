/* SPDX-License-Identifier: MIT
 *
 * loops.h - roots, logarithms and differences of many samples at once, compiled for each width of vectors. All widths give the same
 * bits. Values are in [0, 1e37] unless another range is given; a NaN gives a NaN.
 */
#ifndef NQM_SRC_SAMPLE_LOOPS_H
#define NQM_SRC_SAMPLE_LOOPS_H

#include "base/base.h"

/** t = log(cbrt(rho) + 1) for n values rho >= 0, within 4e-7 relative; 0 below 1e-30, the value at 1e37 above 1e37. root
 *  receives cbrt(rho), within the same; it may be t. */
void nqm_sample_logs(size_t n, const float *rho, float *root, float *t);
/** From n values t = log(cbrt(f_r) + 1) to those of s f_r, with k1 = cbrt(s) - 1, |k1| <= 0.018: within 3e-7 (1 + t). */
void nqm_sample_scale(size_t n, float k1, const float *t, float *scaled);
/** ratio = log((y + offset) / (x + offset)) for n values, offset (n) from 1e-6 to 1e30: within 3e-7 relative from -0.28 to 0.28,
 *  otherwise absolute or relative, whichever is more; 0 where x = y. */
void nqm_sample_log_ratios(size_t n, const float *offset, const float *x, const float *y, float *ratio);
/** difference = scale (cbrt(y) - cbrt(x)) for n values up to 1e30 and their cube roots from nqm_sample_logs(): within
 *  2e-6 relative, even for close values, and 1e-10 scale. */
void nqm_sample_root_differences(size_t n, const float *scale, const float *x, const float *y, const float *root_x,
                                 const float *root_y, float *difference);
/** y = x, but at most `limit`, for n floats. */
void nqm_sample_limit(size_t n, float limit, const float *x, float *y);
/** difference = s (b - a) and magnitude = s |b - a| for n floats; difference may be b. */
void nqm_sample_differences(size_t n, float s, const float *a, const float *b, float *difference, float *magnitude);
enum { NQM_SAMPLE_LANES = 32 };
/** The sums of |x| and of x^2 over n floats, a multiple of NQM_SAMPLE_LANES. */
void nqm_sample_sums(size_t n, const float *x, float *magnitudes, float *squares);
/** Period of the whitening's mean and scale, floats: a multiple of the three channels and of every vector width. */
enum { NQM_WHITEN_PERIOD = 48 };
/** x = (t - mean) scale for n floats; x may be t. mean and scale are (NQM_WHITEN_PERIOD) and repeat. */
void nqm_sample_whiten(size_t n, const float *mean, const float *scale, const float *t, float *x);

/** Points side by side in a block of nqm_sample_nearest(). */
enum { NQM_POINTS = 16 };
/** The least squared distance of y (n) from the points of n_blocks blocks (n, NQM_POINTS), in float; INFINITY: there are none. */
float nqm_sample_nearest(size_t n, size_t n_blocks, const float *points, const float *y);

#endif
