/* SPDX-License-Identifier: MIT
 *
 * percept.h - inside the percept room: the PQ signal, pictures, and the published JOD curve. The rest is declared in
 * <nqm/percept.h>.
 */
#ifndef NQM_SRC_PERCEPT_H
#define NQM_SRC_PERCEPT_H

#include <nqm/percept.h>
#include <stddef.h>

/** PQ signal in [0, 1] of an absolute luminance in cd/m2, clamped to [0, 10000] (the inverse EOTF of SMPTE ST 2084). */
double nqm_pq_from_luminance(double luminance_cdm2);

/** Mean Delta-E ITP of two pictures (n_pixels, 3) shown on a display that clips every channel at peak_cdm2. */
double nqm_picture_delta_e(size_t n_pixels, const double *ref_cdm2, const double *test_cdm2, double peak_cdm2);

/** nqm_curve_default(). */
extern const nqm_curve nqm_curve_published;

#endif
