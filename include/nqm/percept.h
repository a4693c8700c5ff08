/* SPDX-License-Identifier: MIT
 *
 * nqm/percept.h - how different colours and pictures look, and how good that is: Delta-E ITP, the curve from Delta-E ITP to
 * JOD and its regression on human scores, labels with parts.
 */
#ifndef NQM_PERCEPT_H
#define NQM_PERCEPT_H

#include <nqm/base.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- colour ------------------------------------------------------------------------------------------------------ */

/* ---- JOD curve --------------------------------------------------------------------------------------------------- */

/** JOD = 10 (1 - 1 / (1 + exp(b1 (-(max(Delta-E, 0)^b3) - b2)))) (paper, eq. 1). */
typedef struct nqm_curve {
    double b1, b2, b3;
} nqm_curve;

/** JOD in [0, 10]; Delta-E 0 (or less) gives exactly 10. The curve of labels is that of nqm_label_get_info(). */
NQM_API double nqm_curve_jod(const nqm_curve *curve, double delta_e);

typedef struct nqm_regress_report {
    nqm_curve curve;
    double rmse;     /**< of JOD */
    double spearman; /**< rank correlation of Delta-E with JOD (negative: more difference, less quality) */
    size_t n;
} nqm_regress_report;

/** Fit the curve to n pairs (delta_e, jod) by Levenberg-Marquardt from several starts; n >= 4. */
NQM_API NQM_MUST_CHECK nqm_status nqm_regress(size_t n, const double *delta_e, const double *jod,
                                              nqm_regress_report *report_ret, nqm_error *err);

/* ---- labels ------------------------------------------------------------------------------------------------------ */

/** How the pictures of two BRDFs differ. In the standard set of scenes each value but the last is the mean over the scenes.
 *  All are 0 for equal pictures. */
typedef struct nqm_label {
    double delta_e;  /**< mean Delta-E ITP (ITU-R BT.2124) over the picture; 1 is just visible */
    double shift[3]; /**< mean of test minus reference in I, T and P, in units of Delta-E: brighter, bluer, redder */
    double
        contrast; /**< ln((1 + s_test) / (1 + s_ref)), where s is the standard deviation of I over the picture in units
                           of Delta-E: above 0 the test has more contrast */
    double structure; /**< root mean square Delta-E ITP that remains after `shift` is subtracted at every point */
    double error;     /**< standard error of delta_e, in its units, >= 0; 0: a prediction, an exact label, or unknown */
} nqm_label;

enum { NQM_LABEL_TEXT = 160 };

/** What a label says. */
typedef struct nqm_label_info {
    nqm_curve curve;  /**< of JODs of labels: the coefficients behind the authors' published labels */
    double jod_error; /**< standard error of the JOD at delta_e: half of the change of the JOD from delta_e - error to
                           delta_e + error */
    /** JOD of people who adapt to most of an overall change of light or colour: nqm_curve_jod() at the root mean square
     *  Delta-E ITP that remains after 85 % of the shift is subtracted, sqrt(structure^2 + (0.15 |shift|)^2). Indices of
     *  colour constancy in natural scenes are 0.8 to 0.9 (Foster 2011, DOI 10.1016/j.visres.2010.09.006). Not fitted to
     *  answers of people: nqm_score_result.similarity is. NaN if a part is NaN. */
    double adapted_jod;
    /** What differs: "darker, a little redder, much flatter", or "no visible difference". A part is mentioned from
     *  one Delta-E (contrast: 3 %), is "a little" below three (10 %), and "much" above ten (35 %). Where delta_e > 0 has
     *  a JOD of 9.5 or more, all but "much" is "a little". */
    char words[NQM_LABEL_TEXT];
} nqm_label_info;

NQM_API nqm_label_info nqm_label_get_info(const nqm_label *label);

#ifdef __cplusplus
}
#endif
#endif
