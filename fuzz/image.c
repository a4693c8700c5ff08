/* SPDX-License-Identifier: MIT
 *
 * Reads the input as a picture of light, or of a map. A failure must leave no pixels and a message.
 */
#include "fuzz.h"
#include "io/io.h"
#include "io/raster.h"

void fuzz_image(const uint8_t *data, size_t n_bytes) {
    const nqm_map map = {.data = data, .n_bytes = n_bytes, .path = "fuzz"};
    nqm_image image;
    nqm_error err = {0};
    nqm_status status = nqm_image_parse(&map, &image, &err);
    if ((status == NQM_OK) != (image.rgb != NULL) || (status != NQM_OK && !err.message[0]) || status == NQM_ERR_NOMEM)
        abort();
    nqm_free(image.rgb);
}

void fuzz_raster(const uint8_t *data, size_t n_bytes) {
    nqm_raster raster;
    size_t width, height;
    nqm_error err = {0};
    const nqm_status header = nqm_raster_size(data, n_bytes, "fuzz", &width, &height, &err);
    const nqm_status status = nqm_raster_decode(data, n_bytes, "fuzz", &raster, &err);
    must((status == NQM_OK) == (raster.data != NULL) && (status == NQM_OK || err.message[0]));
    must(status != NQM_ERR_NOMEM && (status != NQM_OK || header == NQM_OK));
    must(status != NQM_OK || (raster.width == width && raster.height == height));
    nqm_raster_clear(&raster);
}
