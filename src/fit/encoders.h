/* SPDX-License-Identifier: MIT
 *
 * encoders.h - the encodings that are not analytic: a network trained for one BRDF, sparse codes in a learned dictionary,
 * networks predicted by a learned hypernetwork. fit_models.c lists them.
 */
#ifndef NQM_SRC_FIT_ENCODERS_H
#define NQM_SRC_FIT_ENCODERS_H

#include "fit/encoder_file.h"
#include <nqm/fit.h>

/** Number of values that an encoding may store or read: the last word of its name. */
typedef enum nqm_budget { NQM_BUDGET_LOW = 0, NQM_BUDGET_MID, NQM_BUDGET_HIGH } nqm_budget;

/** Train a network for `ref` (nbrdf_fit.c). */
NQM_MUST_CHECK nqm_status nqm_fit_nbrdf(const nqm_brdf *ref, const nqm_fit_options *options, nqm_fit_report *report,
                                        nqm_brdf **brdf_ret, nqm_error *err);
/** Compute a sparse code of `ref` in the embedded dictionary (sparse.c). */
NQM_MUST_CHECK nqm_status nqm_fit_sparse(const nqm_brdf *ref, nqm_budget budget, const nqm_fit_options *options,
                                         nqm_fit_report *report, nqm_brdf **brdf_ret, nqm_error *err);
/** Predict a network for `ref` by the embedded hypernetwork (hyper.c). */
NQM_MUST_CHECK nqm_status nqm_fit_hyper(const nqm_brdf *ref, nqm_budget budget, const nqm_fit_options *options,
                                        nqm_fit_report *report, nqm_brdf **brdf_ret, nqm_error *err);

/** The two halves of nqm_learn() (sparse_learn.c, hyper_learn.c). */
NQM_MUST_CHECK nqm_status nqm_learn_sparse(size_t n, const nqm_brdf *const *refs, const char *const *names,
                                           const nqm_learn_options *options, const char *path, nqm_error *err);
NQM_MUST_CHECK nqm_status nqm_learn_hyper(size_t n, const nqm_brdf *const *refs, const char *const *names,
                                          const nqm_learn_options *options, const char *path, nqm_error *err);

#endif
