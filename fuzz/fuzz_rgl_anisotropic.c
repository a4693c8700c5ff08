/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: RGL materials with several phi_i.
 */
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n_bytes) {
    fuzz_brdf(data, n_bytes, n_bytes, "");
    return 0;
}

blob fuzz_seed(void) {
    return make_anisotropic_rgl(4, false, NULL);
}
