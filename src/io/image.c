/* SPDX-License-Identifier: MIT
 *
 * Loads high-dynamic-range images: detects the format from the first bytes, checks the size and the values.
 */
#include "io/io.h"

#include <math.h>
#include <string.h>

static nqm_status check_values(const char *path, const nqm_image *image, nqm_error *err) {
    for (size_t i = 0; i < 3 * image->width * image->height; ++i) {
        size_t pixel = i / 3;
        if (!isfinite(image->rgb[i]))
            return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: the pixel in row %zu, column %zu is not finite", path,
                            pixel / image->width, pixel % image->width);
        if (image->rgb[i] < 0)
            image->rgb[i] = 0;
    }
    return NQM_OK;
}

static bool begins(const nqm_map *map, const char *magic, size_t n) {
    return map->n_bytes >= n && memcmp(map->data, magic, n) == 0;
}

static nqm_status decode(const nqm_map *map, nqm_image *image, nqm_error *err) {
    if (begins(map, "\x89PNG", 4))
        return nqm_image_decode_png(map, image, err);
    if (begins(map, "\x76\x2f\x31\x01", 4))
        return nqm_image_decode_exr(map, image, err);
    if (begins(map, "#?", 2))
        return nqm_image_decode_hdr(map, image, err);
    const char *kind = nqm_file_kind(map->data, map->n_bytes);
    return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: neither OpenEXR, Radiance HDR nor PNG%s%s (byte 0)", map->path,
                    kind ? " but " : "", kind ? kind : "");
}

nqm_status nqm_image_parse(const nqm_map *map, nqm_image *image_ret, nqm_error *err) {
    *image_ret = (nqm_image){0};
    nqm_status status = decode(map, image_ret, err);
    if (status == NQM_OK)
        status = check_values(map->path, image_ret, err);
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
