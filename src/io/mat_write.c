/* SPDX-License-Identifier: MIT
 *
 * Real matrices into MAT v5 files, by matio: uncompressed, without a date, so that equal matrices make equal files. What
 * was written is read back before the file gets its name, because matio does not report a full disk.
 */
#include "io/io.h"
#include "io/mat_library.h"

#include <ctype.h>
#include <math.h>
#include <string.h>

enum {
    MAX_ELEMENTS = 1 << 24, /* of one variable: what nqm_mat_read() reads */
    MAX_NAME_BYTES = 63     /* of MATLAB */
};

static bool is_name(const char *name) {
    size_t n = strlen(name);
    bool ok = n > 0 && n <= MAX_NAME_BYTES && isalpha((unsigned char)name[0]);
    for (size_t i = 0; ok && i < n; ++i)
        ok = isalnum((unsigned char)name[i]) || name[i] == '_';
    return ok;
}

static nqm_status check_variable(const nqm_mat_variable *v, nqm_error *err) {
    size_t n;
    if (!is_name(v->name))
        return nqm_fail(err, NQM_ERR_ARG, -1, "'%.80s' is no name of a MAT variable", v->name);
    if (v->rows == 0 || v->cols == 0 || !nqm_mul_size(v->rows, v->cols, &n) || n > MAX_ELEMENTS)
        return nqm_fail(err, NQM_ERR_LIMIT, -1, "'%s' is %zu x %zu; 1 to %d elements can be written", v->name, v->rows,
                        v->cols, MAX_ELEMENTS);
    for (size_t i = 0; i < n; ++i)
        if (!isfinite(v->data[i]))
            return nqm_fail(err, NQM_ERR_ARG, -1, "'%s' at row %zu, column %zu is not finite", v->name, i / v->cols + 1,
                            i % v->cols + 1);
    return NQM_OK;
}

static nqm_status write_variable(const nqm_matio *matio, mat_t *file, const nqm_mat_variable *v, const char *path,
                                 nqm_error *err) {
    size_t dims[2] = {v->rows, v->cols};
    double *columns = nqm_alloc(v->rows * v->cols, sizeof *columns);
    if (!columns)
        return nqm_fail_nomem(err, v->rows * v->cols * sizeof *columns);
    for (size_t i = 0; i < v->rows; ++i)
        for (size_t k = 0; k < v->cols; ++k)
            columns[k * v->rows + i] = v->data[i * v->cols + k];
    matvar_t *variable =
        matio->Mat_VarCreate(v->name, MAT_C_DOUBLE, MAT_T_DOUBLE, 2, dims, columns, MAT_F_DONT_COPY_DATA);
    bool written = variable && matio->Mat_VarWrite(file, variable, MAT_COMPRESSION_NONE) == 0;
    matio->Mat_VarFree(variable);
    nqm_free(columns);
    return written ? NQM_OK : nqm_fail(err, NQM_ERR_IO, -1, "%s: cannot write '%s'", path, v->name);
}

/* All variables are there, and whole. */
static nqm_status check_written(const char *written, size_t n, const nqm_mat_variable *variables, const char *path,
                                nqm_error *err) {
    nqm_mat *mat;
    size_t rows = 0, cols = 0;
    bool ok = nqm_mat_open(written, &mat, NULL) == NQM_OK;
    for (size_t i = 0; ok && i < n; ++i)
        ok = nqm_mat_shape(mat, variables[i].name, &rows, &cols, NULL) == NQM_OK && rows == variables[i].rows &&
             cols == variables[i].cols;
    nqm_mat_close(mat);
    return ok ? NQM_OK : nqm_fail(err, NQM_ERR_IO, -1, "%s: cannot write: what was written cannot be read back", path);
}

static nqm_status write_file(const char *written, size_t n, const nqm_mat_variable *variables, const char *path,
                             nqm_error *err) {
    const nqm_matio *matio;
    nqm_status status = nqm_matio_get(&matio, err);
    if (status != NQM_OK)
        return status;
    mat_t *file = matio->Mat_CreateVer(written, "MATLAB 5.0 MAT-file, created by nqm", MAT_FT_MAT5);
    if (!file)
        return nqm_fail(err, NQM_ERR_IO, -1, "%s: cannot write", path);
    for (size_t i = 0; status == NQM_OK && i < n; ++i)
        status = write_variable(matio, file, &variables[i], path, err);
    if (matio->Mat_Close(file) != 0 && status == NQM_OK)
        status = nqm_fail(err, NQM_ERR_IO, -1, "%s: cannot write", path);
    return status == NQM_OK ? check_written(written, n, variables, path, err) : status;
}

nqm_status nqm_mat_write(const char *path, size_t n, const nqm_mat_variable *variables, nqm_error *err) {
    nqm_status status = NQM_OK;
    for (size_t i = 0; status == NQM_OK && i < n; ++i)
        status = check_variable(&variables[i], err);
    nqm_outfile out = {0};
    if (status == NQM_OK)
        status = nqm_outfile_open(path, &out, err);
    if (status != NQM_OK)
        return status;
    if (out.temporary) /* matio opens it once more, by its name */
        status = write_file(out.temporary, n, variables, path, err);
    else
        status = nqm_fail(err, NQM_ERR_IO, -1, "%s: a MAT file can only be written to a regular file", path);
    if (status == NQM_OK)
        return nqm_outfile_commit(&out, err);
    nqm_outfile_abort(&out);
    return status;
}
