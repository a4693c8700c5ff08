/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: the model reader, from a transport matrix without a network.
 */
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n_bytes) {
    fuzz_model(data, n_bytes);
    return 0;
}

blob fuzz_seed(void) {
    return fuzz_model_save(fuzz_model_make());
}
