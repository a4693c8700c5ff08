/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: JPEG pictures of maps.
 */
#include "fuzz.h"
#include "support/pictures.h"

static int run_one(const uint8_t *data, size_t n_bytes) {
    fuzz_raster(data, n_bytes);
    return 0;
}

static blob make_seed(void) {
    static const unsigned char pixels[5 * 3 * 3] = "a small picture with 45 bytes of pixels, here";
    return make_jpeg(5, 3, 3, JPEG_PROGRESSIVE, pixels);
}

FUZZ_TARGET(run_one, make_seed)
