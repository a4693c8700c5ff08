/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: spectral RGL materials.
 */
#include "fuzz.h"

static int run_one(const uint8_t *data, size_t n_bytes) {
    fuzz_brdf(data, n_bytes, n_bytes, n_bytes % 2 ? ":D65" : "");
    return 0;
}

static blob make_seed(void) {
    return make_spectral_rgl(NULL);
}

FUZZ_TARGET(run_one, make_seed)
