/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: NBRDF files, which covers the HDF5 reader too.
 */
#include "fuzz.h"

static int run_one(const uint8_t *data, size_t n_bytes) {
    fuzz_brdf(data, n_bytes, n_bytes, "");
    return 0;
}

static blob make_seed(void) {
    return make_nbrdf(NBRDF_VALID);
}

FUZZ_TARGET(run_one, make_seed)
