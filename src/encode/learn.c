/* SPDX-License-Identifier: MIT
 *
 * The public entries of learning.
 */
#include "encode/encode.h"

nqm_learn_options nqm_learn_options_default(void) {
    return (nqm_learn_options){.seed = 1};
}

nqm_status nqm_learn(nqm_encoder what, size_t n, const nqm_brdf *const *refs, const char *const *names,
                     const nqm_learn_options *options_or_null, const char *path, nqm_error *err) {
    NQM_REQUIRE(err, refs, names, path);
    nqm_learn_options options = options_or_null ? *options_or_null : nqm_learn_options_default();
    if (n == 0)
        return nqm_fail(err, NQM_ERR_ARG, -1, "no BRDF to learn from");
    return what == NQM_ENCODER_SPARSE ? nqm_learn_sparse(n, refs, names, &options, path, err)
                                      : nqm_learn_hyper(n, refs, names, &options, path, err);
}
