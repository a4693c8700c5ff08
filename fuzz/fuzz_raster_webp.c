/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: WebP pictures of maps.
 */
#include "fuzz.h"
#include "support/pictures.h"

static int run_one(const uint8_t *data, size_t n_bytes) {
    fuzz_raster(data, n_bytes);
    return 0;
}

static blob make_seed(void) {
    static const unsigned char pixels[5 * 3 * 4] = "a small picture with sixty bytes of pixels, here and there";
    return make_webp(5, 3, 4, true, pixels);
}

FUZZ_TARGET(run_one, make_seed)
