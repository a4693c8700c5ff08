/* SPDX-License-Identifier: MIT
 *
 * Memory for the pixels of a picture, after its size has been compared with that of the file.
 */
#include "io/io.h"

nqm_status nqm_image_alloc(const nqm_map *map, uint64_t width, uint64_t height, double per_byte, nqm_image *image_ret,
                           nqm_error *err) {
    *image_ret = (nqm_image){0};
    if (width < 1 || height < 1)
        return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: the picture is empty", map->path);
    if ((double)width * (double)height > per_byte * (double)map->n_bytes)
        return nqm_fail(err, NQM_ERR_FORMAT, 0,
                        "%s: the header claims %llu x %llu pixels, more than %zu bytes can store", map->path,
                        (unsigned long long)width, (unsigned long long)height, map->n_bytes);
    if (width > NQM_IMAGE_MAX_WIDTH || height > NQM_IMAGE_MAX_HEIGHT)
        return nqm_fail(err, NQM_ERR_LIMIT, 0, "%s: %llu x %llu pixels; at most %d x %d are read", map->path,
                        (unsigned long long)width, (unsigned long long)height, (int)NQM_IMAGE_MAX_WIDTH,
                        (int)NQM_IMAGE_MAX_HEIGHT);
    size_t n_pixels = (size_t)(width * height);
    float *rgb = nqm_alloc(n_pixels, 3 * sizeof *rgb);
    if (!rgb)
        return nqm_fail_nomem(err, n_pixels * 3 * sizeof *rgb);
    *image_ret = (nqm_image){.width = (size_t)width, .height = (size_t)height, .rgb = rgb};
    return NQM_OK;
}
