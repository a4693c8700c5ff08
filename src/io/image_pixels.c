/* SPDX-License-Identifier: MIT
 *
 * Memory for the pixels of a picture, after its size has been compared with that of the file.
 */
#include "io/io.h"

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
