/* SPDX-License-Identifier: MIT
 *
 * Decodes pictures as they are stored: selects the decoder by the first bytes, checks sizes, and refuses floats that
 * are not finite.
 */
#include "io/raster.h"
#include "io/io.h"

#include <inttypes.h>
#include <math.h>
#include <stdatomic.h>

static const struct {
    size_t at, n;
    const char *magic;
    nqm_raster_decoder *decode;
} formats[] = {
    {0, 4, "\x89PNG", nqm_raster_decode_png},
    {0, 3, "\xff\xd8\xff", nqm_raster_decode_jpeg},
    {8, 4, "WEBP", nqm_raster_decode_webp},
    {0, 4, "\x76\x2f\x31\x01", nqm_raster_decode_exr},
};

static _Atomic uint64_t n_bytes_decoded;

/* Count the pixels of a picture, if all may be held. */
static nqm_status count(const char *name, uint64_t n_bytes, nqm_raster *raster, nqm_error *err) {
    const uint64_t n_before = atomic_fetch_add(&n_bytes_decoded, n_bytes);
    if (n_before + n_bytes <= NQM_RASTER_MAX_BYTES) {
        raster->n_counted = (size_t)n_bytes;
        return NQM_OK;
    }
    atomic_fetch_sub(&n_bytes_decoded, n_bytes);
    return nqm_fail(err, NQM_ERR_LIMIT, -1,
                    "%s: %zu x %zu pixels are %" PRIu64 " MiB, besides %" PRIu64
                    " MiB of other pictures; all may have %" PRIu64 ": give smaller ones",
                    name, raster->width, raster->height, n_bytes >> 20, n_before >> 20, NQM_RASTER_MAX_BYTES >> 20);
}

nqm_status nqm_raster_begin(const nqm_map *map, double per_byte, bool header_only, nqm_raster *raster, nqm_error *err) {
    static const size_t value_size[] = {[NQM_RASTER_U8] = 1, [NQM_RASTER_U16] = 2, [NQM_RASTER_F32] = 4};
    nqm_status status = nqm_image_check_size(map, raster->width, raster->height, per_byte, NQM_RASTER_MAX_SIDE,
                                             NQM_RASTER_MAX_SIDE, err);
    if (status != NQM_OK || header_only)
        return status;
    const size_t n_pixels = raster->width * raster->height, pixel_size = raster->channels * value_size[raster->type];
    status = count(map->path, (uint64_t)n_pixels * pixel_size, raster, err);
    raster->data = status == NQM_OK ? nqm_alloc(n_pixels, pixel_size) : NULL;
    return status == NQM_OK && !raster->data ? nqm_fail_nomem(err, n_pixels * pixel_size) : status;
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
    return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: neither PNG, JPEG, WebP nor OpenEXR%s%s (byte 0)", map->path,
                    kind ? " but " : "", kind ? kind : "");
}

static nqm_status decode(const nqm_map *map, bool header_only, nqm_raster *raster, nqm_error *err) {
    *raster = (nqm_raster){0};
    for (size_t i = 0; i < sizeof formats / sizeof *formats; ++i)
        if (map->n_bytes >= formats[i].at + formats[i].n &&
            memcmp(map->data + formats[i].at, formats[i].magic, formats[i].n) == 0) {
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
    atomic_fetch_sub(&n_bytes_decoded, raster->n_counted);
    nqm_free(raster->data);
    *raster = (nqm_raster){0};
}
