/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: OpenEXR light maps. A failure must leave no pixels and a message.
 */
#include "fuzz.h"
#include "io/io.h"
#include "vectors/images_vectors.h"

#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n_bytes) {
    const nqm_map map = {.data = data, .n_bytes = n_bytes, .path = "fuzz.exr"};
    nqm_image image;
    nqm_error err = {0};
    nqm_status status = nqm_image_parse(&map, &image, &err);
    if ((status == NQM_OK) != (image.rgb != NULL) || (status != NQM_OK && !err.message[0]) || status == NQM_ERR_NOMEM)
        abort();
    nqm_free(image.rgb);
    return 0;
}

blob fuzz_seed(void) {
    blob b = {.data = malloc(sizeof file_exr_tiled), .n_bytes = sizeof file_exr_tiled};
    if (!b.data)
        abort();
    memcpy(b.data, file_exr_tiled, sizeof file_exr_tiled);
    return b;
}
