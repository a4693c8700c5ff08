/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: UTIA measurements. The input is the beginning of the file; one input in eight, by its last byte, is extended with
 * zeros to its size.
 */
#include "fuzz.h"

static int run_one(const uint8_t *data, size_t n_bytes) {
    fuzz_brdf(data, n_bytes, n_bytes && data[n_bytes - 1] % 8 == 1 ? UTIA_BYTES : n_bytes, "");
    return 0;
}

static blob make_seed(void) {
    blob b = make_utia();
    b.n_bytes = 1001;
    return b;
}

FUZZ_TARGET(run_one, make_seed)
