/* SPDX-License-Identifier: MIT
 *
 * Decodes pictures as they are stored: selects the decoder by the first bytes, checks sizes, and refuses floats that
 * are not finite.
 */
#include "io/raster.h"

#include "io/raster_decoders.h"

#include <math.h>

static const struct {
    const char *magic;
    size_t n;
    nqm_raster_decoder *decode;
} formats[] = {
    {"\x89PNG", 4, nqm_raster_decode_png},
    {"\xff\xd8\xff", 3, nqm_raster_decode_jpeg},
    {"\x76\x2f\x31\x01", 4, nqm_raster_decode_exr},
};

nqm_status nqm_raster_begin(const nqm_map *map, double per_byte, bool header_only, nqm_raster *raster, nqm_error *err) {
    static const size_t value_size[] = {[NQM_RASTER_U8] = 1, [NQM_RASTER_U16] = 2, [NQM_RASTER_F32] = 4};
    nqm_status status = nqm_image_check_size(map, raster->width, raster->height, per_byte, NQM_RASTER_MAX_SIDE,
                                             NQM_RASTER_MAX_SIDE, err);
    if (status != NQM_OK || header_only)
        return status;
    const size_t n_pixels = raster->width * raster->height, pixel_size = raster->channels * value_size[raster->type];
    raster->data = nqm_alloc(n_pixels, pixel_size);
    return raster->data ? NQM_OK : nqm_fail_nomem(err, n_pixels * pixel_size);
}

static nqm_status check_finite(const char *name, const nqm_raster *raster, nqm_error *err) {
    const float *values = raster->data;
    for (size_t i = 0; i < raster->width * raster->height * raster->channels; ++i)
        if (!isfinite(values[i]))
            return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: the pixel in row %zu, column %zu is not finite", name,
                            i / raster->channels / raster->width, i / raster->channels % raster->width);
    return NQM_OK;
}

static nqm_status refuse_kind(const nqm_map *map, nqm_error *err) {
    const char *kind = nqm_file_kind(map->data, map->n_bytes);
    if (kind && strstr(kind, "picture"))
        return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: %s, which is not read: convert it to PNG or OpenEXR (byte 0)",
                        map->path, kind);
    return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: neither PNG, JPEG nor OpenEXR%s%s (byte 0)", map->path,
                    kind ? " but " : "", kind ? kind : "");
}

static nqm_status decode(const nqm_map *map, bool header_only, nqm_raster *raster, nqm_error *err) {
    *raster = (nqm_raster){0};
    for (size_t i = 0; i < sizeof formats / sizeof *formats; ++i)
        if (map->n_bytes >= formats[i].n && memcmp(map->data, formats[i].magic, formats[i].n) == 0) {
            nqm_status status = formats[i].decode(map, header_only, raster, err);
            if (status == NQM_OK && !header_only && raster->type == NQM_RASTER_F32)
                status = check_finite(map->path, raster, err);
            if (status != NQM_OK)
                nqm_raster_clear(raster);
            return status;
        }
    return refuse_kind(map, err);
}

nqm_status nqm_raster_decode(const unsigned char *data, size_t n_bytes, const char *name, nqm_raster *raster_ret,
                             nqm_error *err) {
    return decode(&(nqm_map){.data = data, .n_bytes = n_bytes, .path = name}, false, raster_ret, err);
}

nqm_status nqm_raster_size(const unsigned char *data, size_t n_bytes, const char *name, size_t *width_ret,
                           size_t *height_ret, nqm_error *err) {
    nqm_raster raster;
    nqm_status status = decode(&(nqm_map){.data = data, .n_bytes = n_bytes, .path = name}, true, &raster, err);
    *width_ret = raster.width;
    *height_ret = raster.height;
    return status;
}

void nqm_raster_clear(nqm_raster *raster) {
    nqm_free(raster->data);
    *raster = (nqm_raster){0};
}
