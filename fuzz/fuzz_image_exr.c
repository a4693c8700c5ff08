/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: OpenEXR light maps.
 */
#include "fuzz.h"
#include "support/vectors.h"

static int run_one(const uint8_t *data, size_t n_bytes) {
    fuzz_image(data, n_bytes);
    return 0;
}

static blob make_seed(void) {
    return vector_picture("tiled.exr");
}

FUZZ_TARGET(run_one, make_seed)
