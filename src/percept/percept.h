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

/** The parts of a label as an array: shift of I, T and P, contrast, structure. */
enum { NQM_LABEL_PARTS = 5 };
void nqm_label_get_parts(const nqm_label *label, double parts[NQM_LABEL_PARTS]);
void nqm_label_set_parts(nqm_label *label, const double parts[NQM_LABEL_PARTS]);

/** The value that nqm_curve_default() returns. */
extern const nqm_curve nqm_curve_published;

#endif
