/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: JPEG pictures of maps.
 */
#include "fuzz.h"
#include "support/pictures.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n_bytes) {
    fuzz_raster(data, n_bytes);
    return 0;
}

blob fuzz_seed(void) {
    static const unsigned char pixels[5 * 3 * 3] = "a small picture with 45 bytes of pixels, here";
    return make_jpeg(5, 3, 3, JPEG_PROGRESSIVE, pixels);
}
