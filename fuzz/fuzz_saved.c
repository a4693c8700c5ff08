/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: networks and tables as nqm saves them. Mutated inputs rarely have a matching checksum, so the target
 * corrects the checksum in a copy first.
 */
#include "fuzz.h"

static int run_one(const uint8_t *data, size_t n_bytes) {
    blob b = fuzz_with_checksum(data, n_bytes);
    fuzz_brdf(b.data, b.n_bytes, b.n_bytes, "");
    blob_free(&b);
    return 0;
}

static blob make_seed(void) {
    return make_saved(SAVED_TABLE);
}

FUZZ_TARGET(run_one, make_seed)
