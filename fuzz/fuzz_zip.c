/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: NBRDF files in a zip archive, which libzip reads.
 */
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n_bytes) {
    fuzz_brdf(data, n_bytes, n_bytes, "");
    fuzz_brdf(data, n_bytes, n_bytes, ":steel");
    return 0;
}

blob fuzz_seed(void) {
    blob network = make_nbrdf(NBRDF_VALID);
    blob b = make_zip("folder/steel.h5", &network);
    blob_free(&network);
    return b;
}
