/* SPDX-License-Identifier: MIT
 *
 * High-dynamic-range images: the format is detected from the first bytes; memory for pixels, after their number has been compared with
 * the size of the file.
 */
#include "io/io.h"
#include "io/raster.h"

#include <math.h>

nqm_status nqm_image_check_size(const nqm_map *map, uint64_t width, uint64_t height, double per_byte, size_t max_width,
                                size_t max_height, nqm_error *err) {
    if (width < 1 || height < 1)
        return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: the picture is empty", map->path);
    if ((double)width * (double)height > per_byte * (double)map->n_bytes)
        return nqm_fail(err, NQM_ERR_FORMAT, 0,
                        "%s: the header claims %llu x %llu pixels, more than %zu bytes can store", map->path,
                        (unsigned long long)width, (unsigned long long)height, map->n_bytes);
    if (width > max_width || height > max_height)
        return nqm_fail(err, NQM_ERR_LIMIT, 0, "%s: %llu x %llu pixels; at most %zu x %zu are read", map->path,
                        (unsigned long long)width, (unsigned long long)height, max_width, max_height);
    return NQM_OK;
}

nqm_status nqm_image_alloc(const nqm_map *map, uint64_t width, uint64_t height, double per_byte, nqm_image *image_ret,
                           nqm_error *err) {
    *image_ret = (nqm_image){0};
    nqm_status status =
        nqm_image_check_size(map, width, height, per_byte, NQM_IMAGE_MAX_WIDTH, NQM_IMAGE_MAX_HEIGHT, err);
    if (status != NQM_OK)
        return status;
    size_t n_pixels = (size_t)(width * height);
    float *rgb = nqm_alloc(n_pixels, 3 * sizeof *rgb);
    if (!rgb)
        return nqm_fail_nomem(err, n_pixels * 3 * sizeof *rgb);
    *image_ret = (nqm_image){.width = (size_t)width, .height = (size_t)height, .rgb = rgb};
    return NQM_OK;
}

static bool begins(const nqm_map *map, const char *magic, size_t n) {
    return map->n_bytes >= n && memcmp(map->data, magic, n) == 0;
}

/* Pixels of floats, of which grey ones fill all channels, or of RGBE: linear rgb = (r, g, b)/255 * 2^(a - 128). */
static void convert(const nqm_raster *raster, nqm_image *image) {
    const unsigned char *bytes = raster->data;
    const float *values = raster->data;
    for (size_t i = 0; i < image->width * image->height; ++i)
        for (size_t k = 0; k < 3; ++k)
            image->rgb[3 * i + k] = raster->type == NQM_RASTER_U8
                                        ? (float)(bytes[4 * i + k] * ldexp(1.0 / 255, bytes[4 * i + 3] - 128))
                                        : values[raster->channels * i + (raster->channels < 3 ? 0 : k)];
}

/* PNG or OpenEXR. */
static nqm_status decode_raster(const nqm_map *map, nqm_image *image, nqm_error *err) {
    size_t width, height;
    nqm_raster raster = {0};
    nqm_status status = nqm_raster_size(map->data, map->n_bytes, map->path, &width, &height, err);
    if (status == NQM_OK)
        status = nqm_image_alloc(map, width, height, INFINITY, image, err);
    if (status == NQM_OK)
        status = nqm_raster_decode(map->data, map->n_bytes, map->path, &raster, err);
    if (status == NQM_OK && raster.type != NQM_RASTER_F32 && (raster.type != NQM_RASTER_U8 || raster.channels != 4))
        status = nqm_fail(err, NQM_ERR_FORMAT, 24,
                          "%s: a light map in a PNG has RGBE pixels in 8-bit RGBA; this one has not", map->path);
    if (status == NQM_OK)
        convert(&raster, image);
    nqm_raster_clear(&raster);
    return status;
}

static nqm_status decode(const nqm_map *map, nqm_image *image, nqm_error *err) {
    if (begins(map, "\x89PNG", 4) || begins(map, "\x76\x2f\x31\x01", 4))
        return decode_raster(map, image, err);
    if (begins(map, "#?", 2))
        return nqm_image_decode_hdr(map, image, err);
    const char *kind = nqm_file_kind(map->data, map->n_bytes);
    return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: neither OpenEXR, Radiance HDR nor PNG%s%s (byte 0)", map->path,
                    kind ? " but " : "", kind ? kind : "");
}

nqm_status nqm_image_parse(const nqm_map *map, nqm_image *image_ret, nqm_error *err) {
    *image_ret = (nqm_image){0};
    nqm_status status = decode(map, image_ret, err);
    for (size_t i = 0; status == NQM_OK && i < 3 * image_ret->width * image_ret->height; ++i)
        if (image_ret->rgb[i] < 0)
            image_ret->rgb[i] = 0;
    if (status != NQM_OK) {
        nqm_free(image_ret->rgb);
        *image_ret = (nqm_image){0};
    }
    return status;
}

nqm_status nqm_image_load(const char *path, nqm_image *image_ret, nqm_error *err) {
    nqm_map map;
    *image_ret = (nqm_image){0};
    nqm_status status = nqm_map_open(path, &map, err);
    if (status == NQM_OK)
        status = nqm_image_parse(&map, image_ret, err);
    nqm_map_close(&map);
    return status;
}
