/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: PNG light maps.
 */
#include "fuzz.h"
#include "vectors/images_vectors.h"

static int run_one(const uint8_t *data, size_t n_bytes) {
    fuzz_image(data, n_bytes);
    return 0;
}

static blob make_seed(void) {
    return blob_of(sizeof file_png, (const char *)file_png);
}

FUZZ_TARGET(run_one, make_seed)
