/* SPDX-License-Identifier: MIT
 *
 * Arrays of NumPy (doc/files.md): tables in half-vector coordinates, or the weights of an NBRDF (nbrdf.c).
 */
#include "brdf/formats/format.h"

#include "io/io.h"

static nqm_status check_shape(const nqm_map *map, const nqm_tensor *t, nqm_table_size *size, nqm_error *err) {
    char shape[160] = "";
    size_t used = 0;
    if (nqm_table_size_of(t, size))
        return NQM_OK;
    for (size_t i = 0; i < t->n_dims; ++i)
        used += (size_t)snprintf(shape + used, sizeof shape - used, "%s%zu", i ? ", " : "", t->dims[i]);
    return nqm_fail(err, NQM_ERR_FORMAT, 10,
                    "%s: an array of shape (%s) (header at byte 10); a table has (n_theta_h, n_theta_d, n_phi_d, 3), "
                    "or n_phi_h before the 3, with at least 2 theta_h and 2 theta_d",
                    map->path, shape);
}

static nqm_status create(const nqm_map *map, const nqm_tensor *t, const char *name, nqm_brdf **brdf_ret,
                         nqm_error *err) {
    const size_t size = nqm_dtype_size(t->dtype), n = t->n_bytes / size;
    nqm_table_size nodes;
    nqm_status status = check_shape(map, t, &nodes, err);
    if (status != NQM_OK)
        return status;
    const unsigned char *stored = t->data;
    float *rgb = nqm_alloc(n, sizeof *rgb);
    if (!rgb)
        return nqm_fail_nomem(err, n * sizeof *rgb);
    for (size_t i = 0; i < n; ++i)
        rgb[i] = t->dtype == NQM_F32 ? nqm_load_f32(stored + i * size) : (float)nqm_load_f64(stored + i * size);
    const size_t bad = nqm_table_first_bad(n / 3, rgb);
    const long long at = t->byte_offset + (long long)(bad * size);
    status = bad < n ? nqm_fail(err, NQM_ERR_FORMAT, at,
                                "%s: the value at byte %lld is not finite (NaN in channel 0 marks a node without "
                                "a value)",
                                map->path, at)
                     : nqm_table_create(nodes, rgb, name, brdf_ret, err);
    nqm_free(rgb);
    return status;
}

static nqm_status open_file(nqm_map *map, const nqm_brdf_argument *argument, nqm_brdf **brdf_ret, nqm_error *err) {
    nqm_tensor tensor;
    nqm_map_expect(map, true);
    nqm_status status = nqm_npy_parse(map, &tensor, err);
    if (status == NQM_OK && tensor.n_dims <= 2 && nqm_nbrdf_is_part(map->path))
        return nqm_nbrdf_open_parts(map->path, argument->name, brdf_ret, err);
    if (status == NQM_OK && tensor.is_column_major)
        status = nqm_fail(err, NQM_ERR_FORMAT, 10,
                          "%s: its values are in Fortran order (header at byte 10); save "
                          "numpy.ascontiguousarray(array)",
                          map->path);
    if (status == NQM_OK)
        status = create(map, &tensor, argument->name, brdf_ret, err);
    return status;
}

const nqm_brdf_format nqm_npy_format = {.files = ".npy", .probe = nqm_npy_probe, .open = open_file};

nqm_status nqm_brdf_write_npy(const nqm_brdf *brdf, bool is_isotropic, const char *path, nqm_error *err) {
    nqm_brdf *made = NULL;
    nqm_table_size size = nqm_table_general;
    size.n_phi_h = is_isotropic ? 1 : 0;
    nqm_status status =
        strcmp(brdf->info.format, "table") == 0 ? NQM_OK : nqm_brdf_tabulate(brdf, size, NULL, &made, err);
    if (status == NQM_OK) {
        const nqm_tensor tensor = nqm_table_tensor(made ? made : brdf);
        status = nqm_npy_write(path, &tensor, err);
    }
    nqm_brdf_free(made);
    return status;
}
