/* SPDX-License-Identifier: MIT
 *
 * open.h - BRDF arguments that are fitted when they are opened: "fit:model=ggx;of=BRDF", also within "perturb:" and "between:"
 * (doc/brdf.md). A caller that has some of the BRDFs already, or wants to keep fits, opens the bases itself.
 */
#ifndef NQM_SRC_FIT_OPEN_H
#define NQM_SRC_FIT_OPEN_H

#include "fit/fit.h"

/** What the caller contributes; NULL or zeros: nothing. */
typedef struct nqm_fit_context {
    /** Open the BRDF that follows "of=" or "with=(". *is_lent_ret: the BRDF belongs to the caller and outlives the result. NULL:
     *  nqm_fit_open(). */
    nqm_status (*open)(void *user, const char *argument, nqm_brdf **brdf_ret, bool *is_lent_ret, nqm_error *err);
    void *user;
    size_t n_own;
    const double *own_deg; /* (n_own, 3) half-vector coordinates, degrees: the directions of the key `own` */
    nqm_progress_fn progress;
    void *progress_user;
} nqm_fit_context;

/** nqm_brdf_open() for arguments that may contain "fit:". NQM_ERR_ARG: a setting; otherwise as nqm_brdf_open() and nqm_fit(). */
NQM_MUST_CHECK nqm_status nqm_fit_open(const char *argument, const nqm_fit_context *context, nqm_brdf **brdf_ret,
                                       nqm_error *err);

/** Call `visit` for each file, spec or preset that an argument is made from, without opening it, until it fails. */
NQM_MUST_CHECK nqm_status nqm_fit_visit_bases(const char *argument,
                                              nqm_status (*visit)(void *user, const char *base, nqm_error *err),
                                              void *user, nqm_error *err);

#endif
