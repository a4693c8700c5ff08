/* SPDX-License-Identifier: MIT
 *
 * What a page does not read: archives, meshes; and PNG, JPEG and WebP, which the browser decodes.
 */
#include "io/io.h"
#include "io/raster.h"

nqm_status nqm_zip_read(const nqm_map *map, const char *member, size_t max_bytes, unsigned char **data_ret,
                        size_t *n_bytes_ret, nqm_error *err) {
    (void)max_bytes;
    *data_ret = NULL, *n_bytes_ret = 0;
    return nqm_fail(err, NQM_ERR_FORMAT, 0,
                    "%s: '%s' is not read from an archive here (byte 0); drop the archive on the page", map->path,
                    member);
}

nqm_status nqm_zip_examples(const nqm_map *map, const char *suffix, char *text, size_t n_text, nqm_error *err) {
    (void)map, (void)suffix, (void)n_text, (void)err;
    *text = 0;
    return NQM_OK;
}

void nqm_mesh_free(nqm_mesh *mesh) {
    (void)mesh;
}

nqm_status nqm_mesh_load(const char *path, nqm_mesh *mesh_ret, nqm_error *err) {
    *mesh_ret = (nqm_mesh){0};
    return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: meshes are not read here (byte 0)", path);
}

/* The page stores decoded pictures as "\x89PNGraw", width, height and channels in 4 bytes each, and the bytes of the pixels. */
nqm_status nqm_raster_decode_png(const nqm_map *map, bool header_only, nqm_raster *raster, nqm_error *err) {
    enum { HEAD = 19 };
    if (map->n_bytes < HEAD || memcmp(map->data + 4, "raw", 3) != 0)
        return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: the browser cannot decode this picture (byte 0)", map->path);
    *raster = (nqm_raster){.width = nqm_load_u32(map->data + 7),
                           .height = nqm_load_u32(map->data + 11),
                           .channels = nqm_load_u32(map->data + 15),
                           .type = NQM_RASTER_U8};
    if (raster->channels < 1 || raster->channels > 4 ||
        map->n_bytes - HEAD != (uint64_t)raster->width * raster->height * raster->channels)
        return nqm_fail(err, NQM_ERR_FORMAT, 7, "%s: the size of the decoded picture is wrong (byte 7)", map->path);
    nqm_status status = nqm_raster_begin(map, 1, header_only, raster, err);
    if (status == NQM_OK && !header_only)
        memcpy(raster->data, map->data + HEAD, map->n_bytes - HEAD);
    return status;
}

nqm_status nqm_raster_decode_jpeg(const nqm_map *map, bool header_only, nqm_raster *raster, nqm_error *err) {
    (void)header_only, (void)raster;
    return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: the browser cannot decode this picture (byte 0)", map->path);
}

nqm_status nqm_raster_decode_webp(const nqm_map *map, bool header_only, nqm_raster *raster, nqm_error *err) {
    (void)header_only, (void)raster;
    return nqm_fail(err, NQM_ERR_FORMAT, 0,
                    "%s: an animated WebP picture, or one that the browser cannot decode (byte 0)", map->path);
}

const char *nqm_build_info(void) {
    return "WebAssembly, 128-bit SIMD";
}
