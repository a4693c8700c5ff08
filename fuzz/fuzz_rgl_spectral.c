/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: spectral RGL materials.
 */
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n_bytes) {
    fuzz_brdf(data, n_bytes, n_bytes, n_bytes % 2 ? ":D65" : "");
    return 0;
}

blob fuzz_seed(void) {
    return make_spectral_rgl(NULL);
}
