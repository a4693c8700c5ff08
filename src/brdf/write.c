/* SPDX-License-Identifier: MIT
 *
 * Writes any BRDF as a table, and specs as material files, that other programs read.
 */
#include "brdf/core/spec.h"
#include "material/material.h"

static nqm_status read_values(const char *spec, const char *path, nqm_values *values, nqm_error *err) {
    char model[40];
    snprintf(model, sizeof model, "%.*s", (int)strcspn(spec, ":"), spec);
    nqm_status status = nqm_material_check(model, path, err);
    return status == NQM_OK ? nqm_values_parse_spec(spec, values, err) : status;
}

nqm_status nqm_brdf_write_materials(size_t n, const char *const *specs, const char *const *names, const char *path,
                                    nqm_error *err) {
    nqm_written_material *materials = nqm_alloc(n, sizeof *materials);
    if (!materials)
        return nqm_fail_nomem(err, n * sizeof *materials);
    nqm_status status = NQM_OK;
    for (size_t i = 0; status == NQM_OK && i < n; ++i) {
        snprintf(materials[i].name, sizeof materials[i].name, "%s", names[i]);
        status = read_values(specs[i], path, &materials[i].values, err);
    }
    if (status == NQM_OK)
        status = nqm_materials_write(n, materials, path, NULL, err);
    nqm_free(materials);
    return status;
}

nqm_status nqm_material_write(const char *spec, const char *name, const char *path, nqm_error *err) {
    return nqm_brdf_write_materials(1, &spec, &name, path, err);
}

static nqm_status write_table(const nqm_brdf *brdf, nqm_file_format format, const char *path, nqm_progress_fn progress,
                              void *progress_user, nqm_error *err) {
    static const double invisible = 1e-3; /* more than the rounding errors of a caller's function */
    const bool is_isotropic = nqm_brdf_anisotropy(brdf) < invisible;
    if (format == NQM_FILE_NPY)
        return nqm_brdf_write_npy(brdf, is_isotropic, path, err);
    if (!is_isotropic)
        return nqm_fail(err, NQM_ERR_ARG, -1,
                        "%s: is anisotropic, and a MERL table has no azimuth of the half vector: write a .npy array",
                        brdf->info.name);
    return nqm_brdf_write_merl(brdf, format == NQM_FILE_MERL ? 180 : 360, path, progress, progress_user, err);
}

nqm_status nqm_brdf_write(const nqm_brdf *brdf, nqm_file_format format, const char *name, const char *path,
                          nqm_progress_fn progress, void *progress_user, nqm_error *err) {
    NQM_REQUIRE(err, brdf, path);
    switch (format) {
    case NQM_FILE_MERL:
    case NQM_FILE_MERL_360:
    case NQM_FILE_NPY:
        return write_table(brdf, format, path, progress, progress_user, err);
    case NQM_FILE_SAFETENSORS:
        return nqm_brdf_save(brdf, path, err);
    case NQM_FILE_MATERIAL:
        if (!brdf->info.spec)
            return nqm_fail(err, NQM_ERR_ARG, -1, "%s: has no spec: only shading models can be written as a material",
                            brdf->info.name);
        return nqm_material_write(brdf->info.spec, name ? name : "material", path, err);
    }
    return nqm_fail(err, NQM_ERR_ARG, -1, "%s: nqm_brdf_write: unknown format %d", path, (int)format);
}
