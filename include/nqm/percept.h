/* SPDX-License-Identifier: MIT
 *
 * nqm/percept.h - how different colours look, and how good that is: Delta-E ITP, the curve from Delta-E ITP to JOD and its
 * regression on human scores.
 */
#ifndef NQM_PERCEPT_H
#define NQM_PERCEPT_H

#include <nqm/base.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- colour ------------------------------------------------------------------------------------------------------ */

/** Linear BT.709 RGB in cd/m2 to ITP (ITU-R BT.2124: I, T = Ct/2, P of ICtCp, PQ of SMPTE ST 2084). Negative channels
 *  count as 0, channels above 10000 as 10000. rgb_cdm2, itp: (3). */
NQM_API void nqm_itp_from_rgb(const double *rgb_cdm2, double *itp);
/** Delta-E ITP of two colours: 720 times their distance in ITP (ITU-R BT.2124). rgb_cdm2: (3) each. */
NQM_API double nqm_delta_e_itp(const double *rgb_a_cdm2, const double *rgb_b_cdm2);

/* ---- JOD curve --------------------------------------------------------------------------------------------------- */

/** JOD = 10 (1 - 1 / (1 + exp(b1 (-(max(Delta-E, 0)^b3) - b2)))) (paper, eq. 1). */
typedef struct nqm_curve {
    double b1, b2, b3;
} nqm_curve;

/** The coefficients behind the authors' published labels, in full precision. */
NQM_API nqm_curve nqm_curve_default(void);
/** JOD in [0, 10]; Delta-E 0 (or less) gives exactly 10. */
NQM_API double nqm_curve_jod(const nqm_curve *curve, double delta_e);

typedef struct nqm_regress_report {
    nqm_curve curve;
    double rmse;     /**< of JOD */
    double spearman; /**< of Delta-E with JOD (negative: more difference, less quality) */
    size_t n;
} nqm_regress_report;

/** Fit the curve to n pairs (delta_e, jod) by Levenberg-Marquardt from several starts; n >= 4. */
NQM_API NQM_MUST_CHECK nqm_status nqm_regress(size_t n, const double *delta_e, const double *jod,
                                              nqm_regress_report *report_ret, nqm_error *err);

#ifdef __cplusplus
}
#endif
#endif
