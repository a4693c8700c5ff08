/* SPDX-License-Identifier: MIT
 *
 * open.h - BRDF arguments that are fitted when they are opened: "fit:model=ggx;of=BRDF", also within "perturb:" and "between:"
 * (doc/brdf.md). A caller that has some of the BRDFs already, or wants to keep fits, opens the bases itself.
 */
#ifndef NQM_SRC_FIT_OPEN_H
#define NQM_SRC_FIT_OPEN_H

#include "argument/argument.h"
#include "fit/fit.h"

/** What the caller contributes; NULL or zeros: nothing. */
typedef struct nqm_fit_context {
    /** Opens the BRDF that follows "of=" or "with=(". NULL: nqm_fit_open(). */
    nqm_base_opener *open;
    void *user;
    size_t n_own;
    const double *own_deg; /* (n_own, 3) half-vector coordinates, degrees: the directions of the key `own` */
    nqm_progress_fn progress;
    void *progress_user;
} nqm_fit_context;

/** nqm_brdf_open() for arguments that may contain "fit:". NQM_ERR_ARG: a setting; otherwise as nqm_brdf_open() and nqm_fit(). */
NQM_MUST_CHECK nqm_status nqm_fit_open(const char *argument, const nqm_fit_context *context, nqm_brdf **brdf_ret,
                                       nqm_error *err);

#endif
