/* SPDX-License-Identifier: MIT
 *
 * WebP pictures with libwebp: RGB, or RGB and alpha, 8 bits. Animations are refused.
 */
#include "io/raster.h"

#include <math.h>
#include <webp/decode.h>

static nqm_status fail_webp(const nqm_map *map, VP8StatusCode code, nqm_error *err) {
    static const char *const reasons[] = {
        [VP8_STATUS_INVALID_PARAM] = "nqm was built with another version of libwebp",
        [VP8_STATUS_BITSTREAM_ERROR] = "the data are damaged",
        [VP8_STATUS_UNSUPPORTED_FEATURE] = "this kind is not read; save it as PNG",
        [VP8_STATUS_SUSPENDED] = "the file ends too early",
        [VP8_STATUS_NOT_ENOUGH_DATA] = "the file ends too early",
    };
    if (code == VP8_STATUS_OUT_OF_MEMORY)
        return nqm_fail_nomem(err, map->n_bytes);
    return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: WebP: %s (byte 0)", map->path, reasons[code]);
}

nqm_status nqm_raster_decode_webp(const nqm_map *map, bool header_only, nqm_raster *raster, nqm_error *err) {
    WebPDecoderConfig config;
    VP8StatusCode code = WebPInitDecoderConfig(&config) ? WebPGetFeatures(map->data, map->n_bytes, &config.input)
                                                        : VP8_STATUS_INVALID_PARAM;
    if (code != VP8_STATUS_OK)
        return fail_webp(map, code, err);
    if (config.input.has_animation)
        return nqm_fail(err, NQM_ERR_FORMAT, 0,
                        "%s: an animated WebP picture, which is not read: save one of its "
                        "pictures (byte 0)",
                        map->path);
    *raster = (nqm_raster){.width = (size_t)config.input.width,
                           .height = (size_t)config.input.height,
                           .channels = config.input.has_alpha ? 4 : 3,
                           .type = NQM_RASTER_U8};
    /* A picture of one colour takes no bits per pixel: the size of the file is no limit. */
    nqm_status status = nqm_raster_begin(map, INFINITY, header_only, raster, err);
    if (status != NQM_OK || header_only)
        return status;
    const size_t row_size = raster->width * raster->channels;
    config.output.colorspace = raster->channels == 4 ? MODE_RGBA : MODE_RGB;
    config.output.u.RGBA =
        (WebPRGBABuffer){.rgba = raster->data, .stride = (int)row_size, .size = row_size * raster->height};
    config.output.is_external_memory = 1;
    code = WebPDecode(map->data, map->n_bytes, &config);
    return code == VP8_STATUS_OK ? NQM_OK : fail_webp(map, code, err);
}
