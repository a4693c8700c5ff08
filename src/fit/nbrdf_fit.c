/* SPDX-License-Identifier: MIT
 *
 * The training of one network for one BRDF.
 */
#include "fit/encoders.h"

nqm_status nqm_fit_nbrdf(const nqm_brdf *ref, const nqm_fit_options *options, nqm_fit_report *report,
                         nqm_brdf **brdf_ret, nqm_error *err) {
    (void)ref, (void)options, (void)report, (void)brdf_ret;
    return nqm_fail(err, NQM_ERR_ARG, -1, "nbrdf is not in this build");
}
