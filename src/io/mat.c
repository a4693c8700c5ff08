/* SPDX-License-Identifier: MIT
 *
 * Real matrices in MAT v5 files ("MAT-File Format", The MathWorks: MATLAB's -v6 and -v7, scipy.io.savemat). A header of
 * 128 bytes is followed by elements of a tag (type, size) and data; a matrix is an element that contains elements:
 * flags, dimensions, name, values; a compressed element contains a matrix as a zlib stream. The reader takes either
 * byte order and skips variables of other classes (cells, structures, sparse matrices). The writer writes no date.
 */
#include "io/io.h"

#include <math.h>
#include <string.h>
#include <zlib.h>

enum { TYPE_INT8 = 1, TYPE_INT32 = 5, TYPE_UINT32 = 6, TYPE_DOUBLE = 9, TYPE_MATRIX = 14, TYPE_COMPRESSED = 15 };
enum { CLASS_DOUBLE = 6, CLASS_UINT64 = 15, FLAG_COMPLEX = 0x800 }; /* the numeric classes are contiguous */
enum { HEADER_BYTES = 128, TAG_BYTES = 8, MAX_DIMENSIONS = 8, MAX_ELEMENTS = 1 << 24 };
enum { MAX_NAME_BYTES = 63 };  /* limit of MATLAB */
enum { HEAD_BYTES = 256 };     /* enough for the tags, flags, dimensions and name that parse_head() accepts */
enum { MAX_INFLATION = 1032 }; /* deflate expands one byte to at most this many */

struct nqm_mat {
    nqm_map map;
    bool big_endian;
};

typedef struct cursor {
    const unsigned char *p;
    size_t n; /* bytes left */
    bool big_endian;
} cursor;

typedef struct element {
    uint32_t type;
    size_t n; /* bytes */
    const unsigned char *data;
} element;

/* A variable. `packed` is its element in the file, a matrix or a compressed matrix. */
typedef struct matrix {
    size_t at; /* offset of the element in the file */
    element packed;
    char name[MAX_NAME_BYTES + 1]; /* empty when the class is not numeric */
    size_t n_dims, rows, cols;
    bool is_complex;
} matrix;

/* Read the element at the cursor and move past its padding; false when it is truncated. Up to four bytes of data may be
 * stored inside the tag. */
static bool take(cursor *c, element *e) {
    if (c->n < TAG_BYTES)
        return false;
    uint32_t first = (uint32_t)nqm_load_integer(c->p, 4, c->big_endian);
    bool is_small = first >> 16 != 0;
    e->type = first & 0xffff;
    e->n = is_small ? first >> 16 : (size_t)nqm_load_integer(c->p + 4, 4, c->big_endian);
    e->data = c->p + (is_small ? 4 : TAG_BYTES);
    if (e->n > (is_small ? 4 : c->n - TAG_BYTES))
        return false;
    size_t padding = e->type == TYPE_COMPRESSED ? 0 : (8 - e->n % 8) % 8;
    size_t step = is_small ? TAG_BYTES : nqm_smaller(c->n, TAG_BYTES + e->n + padding);
    c->p += step;
    c->n -= step;
    return true;
}

/* Inflate up to n_out bytes of a zlib stream. Returns the number of bytes written, 0 when the stream is damaged.
 * `complete`: the stream must end within n_out bytes, with a matching checksum. */
static size_t unpack(const element *e, unsigned char *out, size_t n_out, bool complete) {
    z_stream z = {.next_in = (unsigned char *)(uintptr_t)e->data,
                  .avail_in = (uInt)e->n,
                  .next_out = out,
                  .avail_out = (uInt)n_out};
    if (inflateInit(&z) != Z_OK)
        return 0;
    int result = inflate(&z, complete ? Z_FINISH : Z_SYNC_FLUSH);
    inflateEnd(&z);
    bool good = result == Z_STREAM_END || (!complete && (result == Z_OK || result == Z_BUF_ERROR));
    return good ? n_out - z.avail_out : 0;
}

/* Parse flags, dimensions and name at the cursor. Returns NULL, or a text that names the fault. */
static const char *parse_head(cursor *c, matrix *m) {
    element e;
    m->name[0] = 0;
    if (!take(c, &e) || e.type != TYPE_UINT32 || e.n != 8)
        return "has damaged flags";
    uint32_t flags = (uint32_t)nqm_load_integer(e.data, 4, c->big_endian);
    if ((flags & 0xff) < CLASS_DOUBLE || (flags & 0xff) > CLASS_UINT64)
        return NULL;
    m->is_complex = (flags & FLAG_COMPLEX) != 0;
    if (!take(c, &e) || e.type != TYPE_INT32 || e.n % 4 != 0 || e.n < 8 || e.n > 4 * MAX_DIMENSIONS)
        return "has damaged dimensions";
    m->n_dims = e.n / 4;
    m->rows = (size_t)nqm_load_integer(e.data, 4, c->big_endian);
    m->cols = (size_t)nqm_load_integer(e.data + 4, 4, c->big_endian);
    if (!take(c, &e) || e.type != TYPE_INT8 || e.n > MAX_NAME_BYTES)
        return "has a damaged name";
    memcpy(m->name, e.data, e.n);
    m->name[e.n] = 0;
    return NULL;
}

/* Parse the variable at offset *at and set *at to the offset of the next one. Returns NULL, or a text that names the
 * fault. */
static const char *next_variable(const nqm_mat *mat, size_t *at, matrix *m) {
    cursor file = {mat->map.data + *at, mat->map.n_bytes - *at, mat->big_endian}, inner = file;
    unsigned char head[HEAD_BYTES];
    *m = (matrix){.at = *at};
    if (!take(&file, &m->packed))
        return "is cut off";
    *at = mat->map.n_bytes - file.n;
    if (m->packed.type == TYPE_MATRIX) {
        inner.p = m->packed.data, inner.n = m->packed.n;
        return parse_head(&inner, m);
    }
    if (m->packed.type != TYPE_COMPRESSED)
        return "is of an unknown type";
    inner.p = head, inner.n = unpack(&m->packed, head, sizeof head, false);
    if (inner.n < TAG_BYTES || nqm_load_integer(head, 4, mat->big_endian) != TYPE_MATRIX)
        return "is no intact compressed matrix";
    inner.p += TAG_BYTES, inner.n -= TAG_BYTES;
    return parse_head(&inner, m);
}

static nqm_status fail_at(const nqm_mat *mat, const matrix *m, const char *fault, nqm_error *err) {
    return nqm_fail(err, NQM_ERR_FORMAT, (int64_t)m->at, "%s: the variable at byte %zu %s", mat->map.path, m->at,
                    fault);
}

static nqm_status check_file(nqm_mat *mat, nqm_error *err) {
    static const char v5[] = "MATLAB 5.0 MAT-file", v73[] = "MATLAB 7.3 MAT-file";
    const nqm_map *map = &mat->map;
    if (map->n_bytes >= sizeof v73 && memcmp(map->data, v73, sizeof v73 - 1) == 0)
        return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: a MAT v7.3 file; save it with '-v7'", map->path);
    if (map->n_bytes < HEADER_BYTES || memcmp(map->data, v5, sizeof v5 - 1) != 0)
        return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: no MAT v5 file: its first %d bytes are not such a header",
                        map->path, HEADER_BYTES);
    const unsigned char *order = map->data + HEADER_BYTES - 2;
    mat->big_endian = order[0] == 'M' && order[1] == 'I';
    if (!mat->big_endian && !(order[0] == 'I' && order[1] == 'M'))
        return nqm_fail(err, NQM_ERR_FORMAT, HEADER_BYTES - 2, "%s: no mark of the byte order at byte %d", map->path,
                        HEADER_BYTES - 2);
    for (size_t at = HEADER_BYTES; at < map->n_bytes;) {
        matrix m;
        const char *fault = next_variable(mat, &at, &m);
        if (fault)
            return fail_at(mat, &m, fault, err);
    }
    return NQM_OK;
}

nqm_status nqm_mat_open(const char *path, nqm_mat **mat_ret, nqm_error *err) {
    *mat_ret = NULL;
    nqm_mat *mat = nqm_alloc(1, sizeof *mat);
    if (!mat)
        return nqm_fail_nomem(err, sizeof *mat);
    nqm_status status = nqm_map_open(path, &mat->map, err);
    if (status == NQM_OK)
        status = check_file(mat, err);
    if (status == NQM_OK)
        *mat_ret = mat;
    else
        nqm_mat_close(mat);
    return status;
}

void nqm_mat_close(nqm_mat *mat) {
    if (mat)
        nqm_map_close(&mat->map);
    nqm_free(mat);
}

static nqm_status find_variable(const nqm_mat *mat, const char *variable, matrix *m, nqm_error *err) {
    const char *path = mat->map.path;
    size_t at = HEADER_BYTES, n;
    do {
        if (at >= mat->map.n_bytes)
            return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: has no numeric variable '%s'", path, variable);
        (void)next_variable(mat, &at, m); /* nqm_mat_open() has checked all of them */
    } while (strcmp(m->name, variable) != 0);
    if (m->is_complex || m->n_dims != 2)
        return nqm_fail(err, NQM_ERR_FORMAT, (int64_t)m->at, "%s: variable '%s' (byte %zu) is not a real matrix", path,
                        variable, m->at);
    if (!nqm_mul_size(m->rows, m->cols, &n) || n / MAX_INFLATION > m->packed.n)
        return nqm_fail(err, NQM_ERR_FORMAT, (int64_t)m->at,
                        "%s: variable '%s' (byte %zu) claims %zu x %zu elements, more than %zu bytes can store", path,
                        variable, m->at, m->rows, m->cols, m->packed.n);
    if (n > MAX_ELEMENTS)
        return nqm_fail(err, NQM_ERR_LIMIT, (int64_t)m->at,
                        "%s: variable '%s' (byte %zu) claims %zu x %zu elements, more than %d", path, variable, m->at,
                        m->rows, m->cols, MAX_ELEMENTS);
    return NQM_OK;
}

nqm_status nqm_mat_shape(const nqm_mat *mat, const char *variable, size_t *rows_ret, size_t *cols_ret, nqm_error *err) {
    matrix m;
    nqm_status status = find_variable(mat, variable, &m, err);
    if (status == NQM_OK) {
        *rows_ret = m.rows;
        *cols_ret = m.cols;
    }
    return status;
}

/* The number type of an element type; 0 bytes: not numeric. */
static nqm_number_type type_of(uint32_t type) {
    static const nqm_number_type types[] = {{0, 0},   {'i', 1}, {'u', 1}, {'i', 2}, {'u', 2}, {'i', 4}, {'u', 4},
                                            {'f', 4}, {0, 0},   {'f', 8}, {0, 0},   {0, 0},   {'i', 8}, {'u', 8}};
    return types[type < sizeof types / sizeof *types ? type : 0];
}

/* Fail because the values are not those of the dimensions. rest: the matrix from the tag of the values on; at: their byte in the
 * matrix, which is a byte of the file too unless the matrix is compressed. */
static nqm_status fail_values(const nqm_mat *mat, const matrix *m, const cursor *rest, size_t at, nqm_error *err) {
    const bool is_plain = m->packed.type == TYPE_MATRIX;
    const size_t byte = is_plain ? (size_t)(m->packed.data - mat->map.data) + at : at;
    const uint32_t first = rest->n < TAG_BYTES ? 0 : (uint32_t)nqm_load_integer(rest->p, 4, mat->big_endian);
    const nqm_number_type type = type_of(first & 0xffff);
    char fault[160];
    if (rest->n >= TAG_BYTES && type.n_bytes == 0)
        snprintf(fault, sizeof fault, "has values of type %u", first & 0xffffu);
    else
        snprintf(fault, sizeof fault, "claims %zu x %zu values of %u bytes, and %zu bytes follow", m->rows, m->cols,
                 type.n_bytes, rest->n < TAG_BYTES ? 0 : rest->n - TAG_BYTES);
    return nqm_fail(err, NQM_ERR_FORMAT, (int64_t)(is_plain ? byte : m->at),
                    "%s: the variable '%s' at byte %zu has damaged values, or is cut off: it %s (byte %zu of the %s)",
                    mat->map.path, m->name, m->at, fault, byte, is_plain ? "file" : "unpacked matrix");
}

/* Convert the column-major values of a matrix to row-major doubles. body: flags, dimensions, name, values. */
static nqm_status convert(const nqm_mat *mat, cursor body, double *out, nqm_error *err, matrix *m) {
    element values = {0};
    const unsigned char *begin = body.p;
    const char *fault = parse_head(&body, m);
    if (fault)
        return fail_at(mat, m, fault, err);
    const size_t n = m->rows * m->cols;
    const cursor rest = body;
    const bool is_whole = take(&body, &values);
    const nqm_number_type type = type_of(values.type);
    if (!is_whole || values.n != n * type.n_bytes || (values.n == 0 && n > 0))
        return fail_values(mat, m, &rest, (size_t)(rest.p - begin), err);
    for (size_t i = 0; i < m->rows; ++i)
        for (size_t k = 0; k < m->cols; ++k) {
            double v = nqm_load_number(values.data + (k * m->rows + i) * type.n_bytes, type, mat->big_endian);
            if (!isfinite(v))
                return nqm_fail(err, NQM_ERR_FORMAT, (int64_t)m->at,
                                "%s: '%s' (byte %zu) at row %zu, column %zu is not finite", mat->map.path, m->name,
                                m->at, i + 1, k + 1);
            out[i * m->cols + k] = v;
        }
    return NQM_OK;
}

nqm_status nqm_mat_read(const nqm_mat *mat, const char *variable, size_t rows, size_t cols, double *out,
                        nqm_error *err) {
    matrix m;
    nqm_status status = find_variable(mat, variable, &m, err);
    if (status != NQM_OK)
        return status;
    bool fits = m.rows == rows && m.cols == cols;
    if (!fits && !((rows == 1 || cols == 1) && m.rows == cols && m.cols == rows))
        return nqm_fail(err, NQM_ERR_FORMAT, (int64_t)m.at, "%s: '%s' (byte %zu) is %zu x %zu, %zu x %zu is needed",
                        mat->map.path, variable, m.at, m.rows, m.cols, rows, cols);
    if (m.packed.type == TYPE_MATRIX)
        return convert(mat, (cursor){m.packed.data, m.packed.n, mat->big_endian}, out, err, &m);
    size_t n_most = HEAD_BYTES + 8 * rows * cols;
    unsigned char *body = nqm_alloc(n_most, 1);
    if (!body)
        return nqm_fail_nomem(err, n_most);
    size_t n = unpack(&m.packed, body, n_most, true);
    if (n < TAG_BYTES)
        status = fail_at(mat, &m, "is a damaged zlib stream, or one of more values than its dimensions", err);
    else if (nqm_load_integer(body + 4, 4, mat->big_endian) != n - TAG_BYTES)
        status = fail_at(mat, &m, "claims another size than its zlib stream has", err);
    else
        status = convert(mat, (cursor){body + TAG_BYTES, n - TAG_BYTES, mat->big_endian}, out, err, &m);
    nqm_free(body);
    return status;
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

static nqm_status check_variable(const nqm_mat_variable *v, nqm_error *err) {
    size_t n;
    if (v->rows == 0 || v->cols == 0 || !nqm_mul_size(v->rows, v->cols, &n) || n > MAX_ELEMENTS)
        return nqm_fail(err, NQM_ERR_LIMIT, -1, "'%s' is %zu x %zu; 1 to %d elements can be written", v->name, v->rows,
                        v->cols, MAX_ELEMENTS);
    for (size_t i = 0; i < n; ++i)
        if (!isfinite(v->data[i]))
            return nqm_fail(err, NQM_ERR_ARG, -1, "'%s' at row %zu, column %zu is not finite", v->name, i / v->cols + 1,
                            i % v->cols + 1);
    return NQM_OK;
}

static void put_variable(FILE *stream, const nqm_mat_variable *v) {
    size_t n_name = strlen(v->name), n_data = v->rows * v->cols * sizeof(double);
    size_t n_padded = (n_name + 7) / 8 * 8;
    const uint32_t rows = (uint32_t)v->rows, cols = (uint32_t)v->cols;
    const uint32_t n_matrix = (uint32_t)(16 + 16 + 8 + n_padded + 8 + n_data);
    /* The matrix, its flags, its dimensions, and the tag of its name. */
    const uint32_t head[] = {TYPE_MATRIX, n_matrix, TYPE_UINT32, 8,    CLASS_DOUBLE, 0,
                             TYPE_INT32,  8,        rows,        cols, TYPE_INT8,    (uint32_t)n_name};
    const uint32_t values[] = {TYPE_DOUBLE, (uint32_t)n_data};
    static const char zeros[8];
    nqm_write_values(stream, sizeof head / sizeof *head, sizeof *head, head);
    fwrite(v->name, 1, n_name, stream);
    fwrite(zeros, 1, n_padded - n_name, stream);
    nqm_write_values(stream, 2, sizeof *values, values);
    for (size_t k = 0; k < v->cols; ++k)
        for (size_t i = 0; i < v->rows; ++i)
            nqm_write_values(stream, 1, sizeof *v->data, &v->data[i * v->cols + k]);
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
    char header[HEADER_BYTES + 1];
    snprintf(header, sizeof header, "MATLAB 5.0 MAT-file, created by nqm%c%88s%c%cIM", 0, "", 0, 1);
    fwrite(header, 1, HEADER_BYTES, out.stream);
    for (size_t i = 0; i < n; ++i)
        put_variable(out.stream, &variables[i]);
    return nqm_outfile_commit(&out, err); /* checks the stream's error flag */
}
