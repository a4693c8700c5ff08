/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: tables as arrays of NumPy.
 */
#include "fuzz.h"

#include "vectors/npy_vectors.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n_bytes) {
    fuzz_brdf(data, n_bytes, n_bytes, "");
    return 0;
}

blob fuzz_seed(void) {
    return blob_of(sizeof npy_turned, (const char *)npy_turned);
}
