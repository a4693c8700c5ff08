/* SPDX-License-Identifier: MIT
 *
 * math.h - vectors, Rusinkiewicz coordinates, spectra to RGB, range checks, statistics (ranks, correlations, quantiles),
 * eigenvectors. It contains nothing specific to BRDFs or files.
 */
#ifndef NQM_SRC_MATH_H
#define NQM_SRC_MATH_H

#include "base/base.h"

#define NQM_PI 3.14159265358979323846

/* ---- vectors (arrays of 3) --------------------------------------------------------------------------------------- */

static inline double nqm_dot3(const double *a, const double *b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
void nqm_cross3(const double *a, const double *b, double *c);
/** Scale to unit length; a zero vector becomes (0, 0, 1). */
void nqm_normalize3(double *v);
/** Unit vector from polar angles, radians. */
void nqm_spherical(double theta, double phi, double *v);
/** Turn v about the third axis by the angle with this sine and cosine; `turned` may be v. */
void nqm_turn3(const double *turn, const double *v, double *turned);
/** Turn pair i of any number of them about the third axis, by i golden angles: these are even over the circle. */
void nqm_turn_pair(size_t i, double *wi, double *wo);
/** Luminance of linear BT.709 rgb (3). */
double nqm_luminance(const double *rgb);

/* ---- Rusinkiewicz coordinates (DOI 10.1007/978-3-7091-6453-2_2); hd (3) = theta_h, theta_d, phi_d ---------------- */

/** phi_d in [0, pi), by reciprocity. */
void nqm_half_diff_from_pair(const double *wi, const double *wo, double *hd);
/** phi_d in [0, 2 pi): distinguishes light and viewer. */
void nqm_half_diff_full_from_pair(const double *wi, const double *wo, double *hd);
void nqm_half_diff_to_pair(const double *hd, double *wi, double *wo);

/* ---- spectra to RGB (spectrum.c names the sources) --------------------------------------------------------------- */

typedef enum nqm_illuminant { NQM_ILLUMINANT_E, NQM_ILLUMINANT_D65 } nqm_illuminant;
/** "E" (equal energy) or "D65"; false: another name. */
bool nqm_illuminant_find(const char *name, nqm_illuminant *illuminant_ret);
const char *nqm_illuminant_name(nqm_illuminant illuminant);
/** true when n >= 2 wavelengths in nm rise and cover at least 500 to 600 nm. */
bool nqm_spectrum_is_visible(size_t n, const float *nm);
/** Weights that make linear BT.709 RGB of reflectances at these wavelengths: channel c is the sum over k of rgb[3 k + c] times
 *  value k. The spectrum is linear between wavelengths and constant beyond them; each channel's weights sum to 1. rgb: (n, 3). */
void nqm_spectrum_weights(nqm_illuminant illuminant, size_t n, const float *nm, double *rgb);

/** Index of the last of n > 0 rising values that is not above x; 0 when all are. */
size_t nqm_last_not_above(const double *value, size_t n, double x);

/* ---- range checks ------------------------------------------------------------------------------------------------ */

/** Index of the first value that is not finite or is below `least`; n when there is none. */
size_t nqm_first_outside(size_t n, const float *value, float least);

/** The radical inverse of i in `base` (van der Corput): its digits mirrored at the radix point, in [0, 1). */
double nqm_radical_inverse(size_t i, size_t base);

/* ---- statistics -------------------------------------------------------------------------------------------------- */

/** Compare two doubles, neither of them NaN, for qsort(). */
int nqm_compare_doubles(const void *a, const void *b);

/** A value and where it comes from. */
typedef struct nqm_indexed {
    double value;
    size_t index;
} nqm_indexed;

/** Compare two nqm_indexed by value, equal values by index, for qsort(). */
int nqm_compare_indexed(const void *a, const void *b);
/** The values x (n) in this order. */
void nqm_sort_indexed(size_t n, const double *x, nqm_indexed *order);
/** Ranks from 1, ties get their mean rank; x, rank: (n). `order` is scratch (n). */
void nqm_ranks(size_t n, const double *x, double *rank, nqm_indexed *order);
double nqm_mean(size_t n, const double *x);
/** Pearson's r; NaN when x or y has no variance or contains NaN, or n < 2. */
double nqm_pearson(size_t n, const double *x, const double *y);
/** Spearman's rho (Pearson's r of the mean ranks); NaN as above, or when out of memory. */
double nqm_spearman(size_t n, const double *x, const double *y);
/** Kendall's tau-b; NaN as for nqm_spearman(). O(n log n). */
double nqm_kendall(size_t n, const double *x, const double *y);
/** The quantile at q (0..1) with linear interpolation; NaN when n is 0. Sorts x (n) in place. */
double nqm_quantile(size_t n, double *x, double q);
/** The 95 % quantile of Student's t, for at least 5 degrees of freedom within 0.01 (Abramowitz and Stegun, 26.7.5). */
double nqm_student95(double freedom);

/* ---- symmetric matrices ------------------------------------------------------------------------------------------ */

/** Eigenvalues (n), largest first, and unit eigenvectors in rows (n, n) of the symmetric a (n, n); overwrites a. */
void nqm_eigen_symmetric(size_t n, double *a, double *values, double *vectors);

#endif
