/* SPDX-License-Identifier: MIT
 *
 * The learning of the hypernetwork.
 */
#include "fit/encoders.h"

nqm_status nqm_learn_hyper(size_t n, const nqm_brdf *const *refs, const char *const *names,
                           const nqm_learn_options *options, const char *path, nqm_error *err) {
    (void)n, (void)refs, (void)names, (void)options, (void)path;
    return nqm_fail(err, NQM_ERR_ARG, -1, "hyper is not in this build");
}
