/* SPDX-License-Identifier: MIT
 *
 * Stand-ins until the branches of rasters and folders of maps are merged: delete this file then.
 */
#include "io/raster.h"
#include "material/maps.h"

__attribute__((weak)) nqm_status nqm_raster_decode(const unsigned char *data, size_t n_bytes, const char *name,
                                                   nqm_raster *raster_ret, nqm_error *err) {
    (void)data, (void)n_bytes;
    *raster_ret = (nqm_raster){0};
    return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: pictures are not read yet", name);
}
__attribute__((weak)) void nqm_raster_clear(nqm_raster *raster) {
    nqm_free(raster->data);
}
__attribute__((weak)) bool nqm_maps_probe(const char *argument) {
    return argument == NULL;
}
__attribute__((weak)) nqm_status nqm_maps_open(const char *argument, nqm_textured **textured_ret, nqm_error *err) {
    *textured_ret = NULL;
    return nqm_fail(err, NQM_ERR_ARG, -1, "%s: folders of maps are not read yet", argument);
}
