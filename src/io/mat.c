/* SPDX-License-Identifier: MIT
 *
 * Real matrices out of MAT v5 files, by matio. The file is looked at before matio sees it (mat_check.c), because matio
 * trusts the sizes in it; the HDF5-based v7.3 is refused.
 */
#include "io/mat_check.h"
#include "io/mat_library.h"

#include <math.h>
#include <string.h>

enum {
    MAX_ELEMENTS = 1 << 24, /* of one variable */
    MAX_PER_BYTE = 1032     /* an element has a byte at least, and deflate packs at most 1032 into one */
};

struct nqm_mat {
    const nqm_matio *matio;
    mat_t *file;
    const char *path;
    size_t n_bytes; /* of the file */
};

static nqm_status check_file(const char *path, size_t *n_bytes_ret, nqm_error *err) {
    nqm_map map;
    nqm_status status = nqm_map_open(path, &map, err);
    if (status != NQM_OK)
        return status;
    *n_bytes_ret = map.n_bytes;
    static const char v5[] = "MATLAB 5.0 MAT-file", v73[] = "MATLAB 7.3 MAT-file";
    if (map.n_bytes >= sizeof v73 && memcmp(map.data, v73, sizeof v73 - 1) == 0)
        status = nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: a MAT v7.3 file; save it with '-v7'", path);
    else if (map.n_bytes < NQM_MAT_HEADER_BYTES || memcmp(map.data, v5, sizeof v5 - 1) != 0)
        status = nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: no MAT v5 file: its first %d bytes are not such a header", path,
                          NQM_MAT_HEADER_BYTES);
    else
        status = nqm_mat_check(&map, err);
    nqm_map_close(&map);
    return status;
}

nqm_status nqm_mat_open(const char *path, nqm_mat **mat_ret, nqm_error *err) {
    *mat_ret = NULL;
    size_t n_bytes;
    const nqm_matio *matio = NULL;
    nqm_status status = check_file(path, &n_bytes, err);
    if (status == NQM_OK)
        status = nqm_matio_get(&matio, err);
    if (status != NQM_OK)
        return status;
    nqm_mat *mat = nqm_alloc(1, sizeof *mat);
    if (!mat)
        return nqm_fail_nomem(err, sizeof *mat);
    *mat = (nqm_mat){.matio = matio, .path = path, .n_bytes = n_bytes};
    mat->file = matio->Mat_Open(path, MAT_ACC_RDONLY);
    if (!mat->file || matio->Mat_GetVersion(mat->file) != MAT_FT_MAT5) {
        nqm_mat_close(mat);
        return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: not a readable MAT v5 file", path);
    }
    *mat_ret = mat;
    return NQM_OK;
}

void nqm_mat_close(nqm_mat *mat) {
    if (!mat)
        return;
    if (mat->file)
        mat->matio->Mat_Close(mat->file);
    nqm_free(mat);
}

static nqm_status find_variable(nqm_mat *mat, const char *variable, matvar_t **info_ret, nqm_error *err) {
    *info_ret = NULL;
    matvar_t *info = mat->matio->Mat_VarReadInfo(mat->file, variable);
    if (!info)
        return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: no variable '%s' can be read", mat->path, variable);
    bool real = (info->class_type == MAT_C_DOUBLE || info->class_type == MAT_C_SINGLE) && !info->isComplex;
    size_t n;
    nqm_status status = NQM_OK;
    if (!real || info->rank != 2)
        status = nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: variable '%s' is not a real matrix of doubles or singles",
                          mat->path, variable);
    else if (!nqm_mul_size(info->dims[0], info->dims[1], &n) || n / MAX_PER_BYTE > mat->n_bytes)
        status = nqm_fail(err, NQM_ERR_FORMAT, -1,
                          "%s: variable '%s' claims %zu x %zu elements, which %zu bytes cannot hold", mat->path,
                          variable, info->dims[0], info->dims[1], mat->n_bytes);
    else if (n > MAX_ELEMENTS)
        status = nqm_fail(err, NQM_ERR_LIMIT, -1, "%s: variable '%s' claims %zu x %zu elements, more than %d",
                          mat->path, variable, info->dims[0], info->dims[1], MAX_ELEMENTS);
    if (status == NQM_OK)
        *info_ret = info;
    else
        mat->matio->Mat_VarFree(info);
    return status;
}

nqm_status nqm_mat_shape(nqm_mat *mat, const char *variable, size_t *rows_ret, size_t *cols_ret, nqm_error *err) {
    matvar_t *info;
    nqm_status status = find_variable(mat, variable, &info, err);
    if (status != NQM_OK)
        return status;
    *rows_ret = info->dims[0];
    *cols_ret = info->dims[1];
    mat->matio->Mat_VarFree(info);
    return NQM_OK;
}

/* Column-major doubles or singles to row-major doubles. */
static nqm_status transpose(const nqm_mat *mat, const matvar_t *info, const void *data, size_t rows, size_t cols,
                            double *out, nqm_error *err) {
    for (size_t i = 0; i < rows; ++i)
        for (size_t k = 0; k < cols; ++k) {
            size_t at = k * rows + i;
            double v =
                info->class_type == MAT_C_DOUBLE ? ((const double *)data)[at] : (double)((const float *)data)[at];
            if (!isfinite(v))
                return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: '%s' at row %zu, column %zu is not finite, or is cut off",
                                mat->path, info->name, i + 1, k + 1);
            out[i * cols + k] = v;
        }
    return NQM_OK;
}

nqm_status nqm_mat_read(nqm_mat *mat, const char *variable, size_t rows, size_t cols, double *out, nqm_error *err) {
    matvar_t *info;
    nqm_status status = find_variable(mat, variable, &info, err);
    if (status != NQM_OK)
        return status;
    bool fits = info->dims[0] == rows && info->dims[1] == cols;
    bool vector_fits = (rows == 1 || cols == 1) && info->dims[0] == cols && info->dims[1] == rows;
    size_t n = rows * cols;
    double *data = NULL;
    if (!fits && !vector_fits) {
        status = nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: '%s' is %zu x %zu, %zu x %zu is needed", mat->path, variable,
                          info->dims[0], info->dims[1], rows, cols);
        goto done;
    }
    data = nqm_alloc(n, sizeof *data);
    if (!data) {
        status = nqm_fail_nomem(err, n * sizeof *data);
        goto done;
    }
    memset(data, 0xff, n * sizeof *data); /* all NaN: what matio leaves out of a cut-off file is noticed */
    if (n && mat->matio->Mat_VarReadDataLinear(mat->file, info, data, 0, 1, (int)n) != 0)
        status = nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: the data of '%s' are damaged or cut off", mat->path, variable);
    else
        status = transpose(mat, info, data, rows, cols, out, err);
done:
    nqm_free(data);
    mat->matio->Mat_VarFree(info);
    return status;
}
