/* SPDX-License-Identifier: MIT
 *
 * Encodings by networks and dictionaries, which WebAssembly leaves out (5 MB): fits are of analytic and shading models.
 */
#include "encode/encode.h"

static nqm_status refuse(nqm_brdf **brdf_ret, nqm_error *err) {
    *brdf_ret = NULL;
    return nqm_fail(err, NQM_ERR_MODEL, -1,
                    "this build has no networks and dictionaries to fit; the command nqm has them");
}

nqm_status nqm_encode_nbrdf(const nqm_brdf *ref, const nqm_encode_options *options, nqm_encode_report *report,
                            nqm_brdf **brdf_ret, nqm_error *err) {
    (void)ref, (void)options, (void)report;
    return refuse(brdf_ret, err);
}

nqm_status nqm_encode_sparse(const nqm_brdf *ref, const nqm_encode_options *options, nqm_encode_report *report,
                             nqm_brdf **brdf_ret, nqm_error *err) {
    (void)ref, (void)options, (void)report;
    return refuse(brdf_ret, err);
}

nqm_status nqm_encode_hyper(const nqm_brdf *ref, const nqm_encode_options *options, nqm_encode_report *report,
                            nqm_brdf **brdf_ret, nqm_error *err) {
    (void)ref, (void)options, (void)report;
    return refuse(brdf_ret, err);
}
