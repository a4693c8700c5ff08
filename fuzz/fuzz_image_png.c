/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: PNG light maps.
 */
#include "fuzz.h"
#include "vectors/images_vectors.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n_bytes) {
    fuzz_image(data, n_bytes);
    return 0;
}

blob fuzz_seed(void) {
    return blob_of(sizeof file_png, (const char *)file_png);
}
