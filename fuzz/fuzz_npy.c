/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: tables as arrays of NumPy.
 */
#include "fuzz.h"
#include "support/vectors.h"

static int run_one(const uint8_t *data, size_t n_bytes) {
    fuzz_brdf(data, n_bytes, n_bytes, "");
    return 0;
}

static blob make_seed(void) {
    return vector_npy("turned");
}

FUZZ_TARGET(run_one, make_seed)
