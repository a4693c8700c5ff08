/* SPDX-License-Identifier: MIT
 *
 * Writes any BRDF as a table, and specs as material files, that other programs read.
 */
#include "brdf/brdf.h"
#include "material/material.h"

nqm_status nqm_brdf_write(const nqm_brdf *brdf, nqm_table_format format, const char *path, nqm_progress_fn progress,
                          void *progress_user, nqm_error *err) {
    NQM_REQUIRE(err, brdf, path);
    switch (format) {
    case NQM_TABLE_MERL:
        return nqm_merl_write(brdf, 180, path, progress, progress_user, err);
    case NQM_TABLE_MERL_360:
        return nqm_merl_write(brdf, 360, path, progress, progress_user, err);
    case NQM_TABLE_NPY:
        return nqm_npy_write_brdf(brdf, path, err);
    }
    return nqm_fail(err, NQM_ERR_ARG, -1, "%s: nqm_brdf_write: unknown format %d", path, (int)format);
}

nqm_status nqm_material_write(const char *spec, const char *name, const char *path, nqm_error *err) {
    NQM_REQUIRE(err, spec, name, path);
    nqm_shading shading;
    nqm_brdf *brdf = NULL;
    nqm_status status = nqm_shading_parse(spec, &shading, err);
    if (status == NQM_OK)
        status = nqm_material_check(shading.model, path, err);
    if (status == NQM_OK)
        status = nqm_spec_open(spec, spec, &brdf, err); /* checks keys and values */
    nqm_brdf_free(brdf);
    return status == NQM_OK ? nqm_shading_write(&shading, name, path, err) : status;
}
