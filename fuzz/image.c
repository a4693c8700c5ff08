/* SPDX-License-Identifier: MIT
 *
 * Reads the input as a picture of light. A failure must leave no pixels and a message.
 */
#include "fuzz.h"
#include "io/io.h"

void fuzz_image(const uint8_t *data, size_t n_bytes) {
    const nqm_map map = {.data = data, .n_bytes = n_bytes, .path = "fuzz"};
    nqm_image image;
    nqm_error err = {0};
    nqm_status status = nqm_image_parse(&map, &image, &err);
    if ((status == NQM_OK) != (image.rgb != NULL) || (status != NQM_OK && !err.message[0]) || status == NQM_ERR_NOMEM)
        abort();
    nqm_free(image.rgb);
}
