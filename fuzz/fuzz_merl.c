/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: MERL tables. The input is the beginning of the file; inputs of odd length are extended with zeros to the
 * size of a MERL file.
 */
#include "fuzz.h"

static int run_one(const uint8_t *data, size_t n_bytes) {
    fuzz_brdf(data, n_bytes, n_bytes % 2 ? MERL_BYTES : n_bytes, "");
    return 0;
}

static blob make_seed(void) {
    blob b = make_merl();
    b.n_bytes = 1001;
    return b;
}

FUZZ_TARGET(run_one, make_seed)
