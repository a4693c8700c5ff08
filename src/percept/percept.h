/* SPDX-License-Identifier: MIT
 *
 * percept.h - private declarations of the percept module: the PQ signal, image differences, and the published JOD
 * curve. <nqm/percept.h> has the public ones.
 */
#ifndef NQM_SRC_PERCEPT_H
#define NQM_SRC_PERCEPT_H

#include <nqm/percept.h>
#include <stddef.h>

/** PQ signal in [0, 1] of an absolute luminance in cd/m2, clamped to [0, 10000] (the inverse EOTF of SMPTE ST 2084). */
double nqm_pq_from_luminance(double luminance_cdm2);

/** Mean Delta-E ITP of two images (n_pixels, 3), cd/m2, on a display that clips every channel at peak_cdm2. */
double nqm_picture_delta_e(size_t n_pixels, const double *ref_cdm2, const double *test_cdm2, double peak_cdm2);

/** The value that nqm_curve_default() returns. */
extern const nqm_curve nqm_curve_published;

#endif
