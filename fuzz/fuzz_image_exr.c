/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: OpenEXR light maps.
 */
#include "fuzz.h"
#include "vectors/images_vectors.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n_bytes) {
    fuzz_image(data, n_bytes);
    return 0;
}

blob fuzz_seed(void) {
    return blob_of(sizeof file_exr_tiled, (const char *)file_exr_tiled);
}
