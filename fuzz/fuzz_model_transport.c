/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: the model reader, from a transport matrix without a network.
 */
#include "fuzz.h"

static int run_one(const uint8_t *data, size_t n_bytes) {
    fuzz_model(data, n_bytes);
    return 0;
}

static blob make_seed(void) {
    return fuzz_model_save(fuzz_model_make());
}

FUZZ_TARGET(run_one, make_seed)
