/* SPDX-License-Identifier: MIT
 *
 * Sparse codes in the embedded dictionary.
 */
#include "fit/encoders.h"

nqm_status nqm_fit_sparse(const nqm_brdf *ref, nqm_budget budget, const nqm_fit_options *options,
                          nqm_fit_report *report, nqm_brdf **brdf_ret, nqm_error *err) {
    (void)ref, (void)budget, (void)options, (void)report, (void)brdf_ret;
    return nqm_fail(err, NQM_ERR_ARG, -1, "sparse is not in this build");
}
