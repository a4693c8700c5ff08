/* SPDX-License-Identifier: MIT
 *
 * percept.h - private declarations of the percept module: the PQ signal and the published JOD
 * curve. <nqm/percept.h> has the public ones.
 */
#ifndef NQM_SRC_PERCEPT_H
#define NQM_SRC_PERCEPT_H

#include <nqm/percept.h>
#include <stddef.h>

/** PQ signal in [0, 1] of an absolute luminance in cd/m2, clamped to [0, 10000] (the inverse EOTF of SMPTE ST 2084). */
double nqm_pq_from_luminance(double luminance_cdm2);

/** Derivative of nqm_pq_from_luminance(); 0 from 10000 on. It has no limit at 0: below 2^-30 cd/m2, the value there. */
double nqm_pq_slope(double luminance_cdm2);
/** Both within 1e-9 and 1e-6 of these (relative, from 2^-30 cd/m2), ten times as fast; *slope is the derivative of the result. */
double nqm_pq_interpolate(double luminance_cdm2, double *slope);
/** Linear BT.709 RGB in cd/m2 to ITP (ITU-R BT.2124: I, T = Ct/2, P of ICtCp, PQ of SMPTE ST 2084). Negative channels
 *  count as 0, channels above 10000 as 10000. rgb_cdm2, itp: (3). */
void nqm_itp_from_rgb(const double *rgb_cdm2, double *itp);

/** The gradient of a function of ITP by RGB from that by ITP: nqm_itp_from_rgb() backwards. All (3). Channels outside [0, 10000]
 *  get 0. */
void nqm_rgb_gradient(const double *rgb_cdm2, const double *by_itp, double *by_rgb);

/** The steps of nqm_itp_from_rgb() before and after the PQ signal: linear LMS in cd/m2 of BT.709 RGB, and ITP of three signals. */
void nqm_lms_from_rgb(const double *rgb_cdm2, double *lms);
void nqm_itp_from_pq_lms(const double *pq_lms, double *itp);

/** The inverse of nqm_curve_jod(); at most 1000, because the worst JODs of a model lie beyond the largest Delta-E that
 *  colours have. */
double nqm_curve_delta_e(const nqm_curve *curve, double jod);
/** The derivative of nqm_curve_jod(); 0 for a Delta-E of 0 or less. */
double nqm_curve_slope(const nqm_curve *curve, double delta_e);

/** The parts of a label as an array: shift of I, T and P, contrast, structure. */
enum { NQM_LABEL_PARTS = 5 };
void nqm_label_get_parts(const nqm_label *label, double parts[NQM_LABEL_PARTS]);
void nqm_label_set_parts(nqm_label *label, const double parts[NQM_LABEL_PARTS]);

/** Sums over the points of two pictures, for the label that compares them. Zero before the first point. */
typedef struct nqm_picture_sums {
    double delta_e, shift[3], squares;
    double ref, ref_squares, test, test_squares; /* of I */
} nqm_picture_sums;
/** Add a point. weight: its fraction of the picture; ref, test: ITP times NQM_ITP_UNIT. */
void nqm_picture_sums_add(nqm_picture_sums *sums, double weight, const double ref[3], const double test[3]);
/** The label of a whole picture. */
nqm_label nqm_picture_sums_label(const nqm_picture_sums *sums);
/** The gradient of sum_k weights_k label_k, over the members of nqm_picture_sums_label(), by the test's ITP times NQM_ITP_UNIT
 *  at one point: (3). sums: of the whole picture; weight: as above. Where a root has no derivative (equal points, equal
 *  pictures, pictures of one value), its part of the gradient is 0. */
void nqm_picture_gradient(const nqm_picture_sums *sums, const nqm_label *weights, double weight, const double ref[3],
                          const double test[3], double gradient[3]);
/** Add `share` of a label to a mean of labels; their errors are independent. */
void nqm_label_add(nqm_label *mean, double share, const nqm_label *label);
#define NQM_ITP_UNIT 720 /**< Delta-E ITP of a distance of 1 in ITP */

/** Few points of the pictures of scenes, which stand for all. The array is borrowed. */
typedef struct nqm_picture_points {
    size_t n;
    const double *at; /* (n, 3) fraction of the scene's picture; number of the scene, from 0, in ascending order; peak
                         luminance of the display, cd/m2 */
} nqm_picture_points;
/** The point after the last of the scene of point `first`; and the share of a scene in the label. */
size_t nqm_picture_scene_end(const nqm_picture_points *points, size_t first);
double nqm_picture_share(const nqm_picture_points *points);
/** ITP on the display, in units of Delta-E (NQM_ITP_UNIT), of linear BT.709 RGB in cd/m2. rgb, itp: (3, n), may be the same
 *  array. In double, for gradients and for pictures that are few. */
void nqm_picture_show(const nqm_picture_points *points, const double *rgb, double *itp);
/** The same of points [first, first + n), n <= NQM_PICTURE_BLOCK, in place: picture (3, n). In float, several times as fast: the
 *  estimates of transport matrices spend most of their time here. */
enum { NQM_PICTURE_BLOCK = 128 };
void nqm_picture_show_block(const nqm_picture_points *points, size_t first, size_t n, float *picture);
/** The label of two pictures (3, n) of nqm_picture_show(). */
nqm_label nqm_picture_label(const nqm_picture_points *points, const double *ref, const double *test);
/** What the gradient of that label needs, (3, n) each: both pictures, and the light of the test in cd/m2. Pairs that share a
 *  reference may share `ref`. */
typedef struct nqm_shown_pair {
    double *ref, *test, *light;
} nqm_shown_pair;
/** The gradient of sum_k weights_k label_k, over the members of that label, by the light of the test: by_light (3, n) receives
 *  it. Points brighter than the display have no part in it. */
void nqm_picture_light_gradient(const nqm_picture_points *points, const nqm_label *weights, const nqm_shown_pair *pair,
                                double *by_light);

/** The coefficients behind the authors' published labels, in full precision. */
extern const nqm_curve nqm_curve_published;

/** Delta-E ITP of two colours: 720 times their distance in ITP (ITU-R BT.2124). rgb_cdm2: (3) each, linear BT.709 RGB in cd/m2;
 *  negative channels count as 0, channels above 10000 as 10000. */
double nqm_delta_e_itp(const double *rgb_a_cdm2, const double *rgb_b_cdm2);

/** nqm_label_info.adapted_jod. */
double nqm_label_adapted_jod(const nqm_label *label);

#endif
