/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: NBRDF files in a zip archive, which libzip reads.
 */
#include "fuzz.h"

static int run_one(const uint8_t *data, size_t n_bytes) {
    fuzz_brdf(data, n_bytes, n_bytes, "");
    fuzz_brdf(data, n_bytes, n_bytes, ":steel");
    return 0;
}

static blob make_seed(void) {
    blob network = make_nbrdf(NBRDF_VALID);
    blob b = make_zip("folder/steel.h5", &network);
    blob_free(&network);
    return b;
}

FUZZ_TARGET(run_one, make_seed)
