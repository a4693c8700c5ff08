/* SPDX-License-Identifier: MIT
 *
 * Reading MAT v5 matrices: files of scipy.io.savemat (tests/vectors/authors.py) and of matio; both byte orders and
 * every numeric type, from bytes written here; files that are truncated or changed at any byte are refused or give
 * finite values.
 */
#include "io/io.h"
#include "support/check.h"
#include "support/damage.h"

#include <sys/resource.h>
#include <zlib.h>
#ifdef NQM_TEST_MATIO
#include <matio.h>
#endif

static const char path[] = "test_io_mat.mat";

/* Plain, compressed, of singles with compression, and with row vectors. */
static const char *const files[] = {"authors/ref/brass_1.mat", "authors/ref/brass_2.mat",
                                    "authors/model/felt_m_68_rgb_1.mat", "authors/model/felt_m_68_rgb_2.mat"};

TEST(reads_what_scipy_wrote) {
    nqm_csv *csv;
    assert_int_equal(nqm_csv_load(test_vector("authors_locations.csv"), &csv, NULL), NQM_OK);
    for (size_t i = 0; i < sizeof files / sizeof *files; ++i) {
        char name[512];
        snprintf(name, sizeof name, "%s", test_vector(files[i]));
        nqm_mat *mat;
        size_t rows, cols;
        double locations[21], r[7];
        assert_int_equal(nqm_mat_open(name, &mat, NULL), NQM_OK);
        assert_int_equal(nqm_mat_shape(mat, "random_locations", &rows, &cols, NULL), NQM_OK);
        assert_int_equal(rows, 7);
        assert_int_equal(cols, 3);
        assert_int_equal(nqm_mat_read(mat, "random_locations", 7, 3, locations, NULL), NQM_OK);
        for (size_t k = 0; k < 21; ++k) {
            double expected;
            assert_int_equal(nqm_csv_number(csv, k / 3, (int)(k % 3), &expected, NULL), NQM_OK);
            assert_near(locations[k], expected, 0);
        }
        assert_int_equal(nqm_mat_read(mat, "r", 7, 1, r, NULL), NQM_OK);
        assert_int_equal(nqm_mat_read(mat, "r", 1, 7, r, NULL), NQM_OK);
        nqm_error err = {0};
        assert_int_equal(nqm_mat_read(mat, "r", 6, 1, r, &err), NQM_ERR_FORMAT);
        assert_non_null(strstr(err.message, "6 x 1 is needed"));
        assert_int_equal(nqm_mat_read(mat, "random_locations", 3, 7, locations, NULL), NQM_ERR_FORMAT);
        assert_int_equal(nqm_mat_read(mat, "x", 7, 1, r, &err), NQM_ERR_FORMAT);
        assert_non_null(strstr(err.message, "'x'"));
        assert_non_null(strstr(err.message, name));
        nqm_mat_close(mat);
    }
    nqm_csv_free(csv);
}

static void write_bytes(const unsigned char *data, size_t n) {
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    assert_int_equal(fwrite(data, 1, n, f), n);
    assert_int_equal(fclose(f), 0);
}

/* Write the file and read all variables; on success the values must be finite. */
static nqm_status read_all(const nqm_map *map, nqm_error *err) {
    nqm_mat *mat;
    double v[21];
    write_bytes(map->data, map->n_bytes);
    nqm_status status = nqm_mat_open(path, &mat, err);
    if (status != NQM_OK)
        return status;
    status = nqm_mat_read(mat, "random_locations", 7, 3, v, err);
    for (size_t i = 0; status == NQM_OK && i < 21; ++i)
        assert_true(isfinite(v[i]));
    if (status == NQM_OK)
        status = nqm_mat_read(mat, "r", 7, 1, v, err);
    nqm_mat_close(mat);
    return status;
}

TEST(no_mat_files) {
    nqm_mat *mat;
    nqm_error err = {0};
    assert_int_equal(nqm_mat_open("no such file", &mat, NULL), NQM_ERR_IO);
    assert_int_equal(nqm_mat_open("/", &mat, NULL), NQM_ERR_IO);
    assert_null(mat);
    write_bytes((const unsigned char *)"", 0);
    assert_int_equal(nqm_mat_open(path, &mat, NULL), NQM_ERR_FORMAT);
    unsigned char header[600] = "MATLAB 7.3 MAT-file, Platform: GLNXA64";
    write_bytes(header, sizeof header);
    assert_int_equal(nqm_mat_open(path, &mat, &err), NQM_ERR_FORMAT);
    assert_non_null(strstr(err.message, "v7.3"));
    assert_int_equal(nqm_mat_open(test_vector("net.safetensors"), &mat, NULL), NQM_ERR_FORMAT);
    assert_null(mat);
}

/* A header that declares 2^31 - 1 rows is refused before any allocation. */
TEST(huge_claims) {
    nqm_map map;
    assert_int_equal(nqm_map_open(test_vector(files[0]), &map, NULL), NQM_OK);
    unsigned char bytes[1024];
    assert_true(map.n_bytes < sizeof bytes);
    const uint32_t huge = 0x7fffffff;
    size_t n_claims = 0;
    for (size_t at = 128; at + 8 <= map.n_bytes; at += 4) {
        if (nqm_load_u32(map.data + at) != 7 || nqm_load_u32(map.data + at + 4) != 1)
            continue;
        memcpy(bytes, map.data, map.n_bytes);
        nqm_store_u32(bytes + at, huge);
        nqm_store_u32(bytes + at + 4, huge);
        write_bytes(bytes, map.n_bytes);
        ++n_claims;
        nqm_mat *mat;
        double v[7];
        assert_int_equal(nqm_mat_open(path, &mat, NULL), NQM_OK);
        static const char *const channels[] = {"r", "g", "b"};
        size_t n_refused = 0;
        for (size_t k = 0; k < 3; ++k) {
            nqm_status status = nqm_mat_read(mat, channels[k], 7, 1, v, NULL);
            assert_true(status == NQM_OK || status == NQM_ERR_FORMAT);
            n_refused += status != NQM_OK;
        }
        assert_true(n_refused >= 1);
        nqm_mat_close(mat);
    }
    assert_int_equal(n_claims, 3);
    nqm_map_close(&map);
}

TEST(cut_and_changed) {
    enum { AFTER_R = 200 }; /* g and b follow r */
    for (size_t i = 0; i < 2; ++i) {
        const blob b = blob_load(test_vector(files[i]));
        survive_changes(path, b, 1 + i, read_all); /* a changed value can pass: MAT files have no checksum */
        survive_cuts(path, b, 1 + 2 * i, read_all);
        refuse_cuts(path, (blob){b.data, b.n_bytes - AFTER_R}, 1 + 2 * i, read_all);
        free(b.data);
    }
    struct rusage usage; /* sizes that a damaged file declares must not be allocated */
    assert_int_equal(getrusage(RUSAGE_SELF, &usage), 0);
    assert_true(usage.ru_maxrss < 500 * 1024);
    unlink(path);
}

/* ---- files that this test writes --------------------------------------------------------------------------------- */

/* A buffer for a MAT file in either byte order. */
typedef struct maker {
    unsigned char bytes[8192];
    size_t n;
    bool big_endian;
} maker;

static void put(maker *m, uint64_t value, size_t n_bytes) {
    for (size_t k = 0; k < n_bytes; ++k)
        m->bytes[m->n++] = (unsigned char)(value >> 8 * (m->big_endian ? n_bytes - 1 - k : k));
}

static maker begin_file(bool big_endian) {
    maker m = {.n = 124, .big_endian = big_endian};
    memcpy(m.bytes, "MATLAB 5.0 MAT-file", 19);
    put(&m, 0x0100, 2);
    put(&m, 'M' << 8 | 'I', 2);
    return m;
}

/* Append the matrix "r" (rows, cols), column-major; each value is stored as `type` in `width` bytes. flags: class and
 * flag bits. */
static void put_matrix(maker *m, uint32_t flags, uint32_t type, size_t width, size_t rows, size_t cols,
                       const uint64_t *values) {
    size_t n_data = rows * cols * width, begin = m->n;
    bool is_small = n_data <= 4;
    const uint64_t head[] = {14, 0, 6, 8, flags, 0, 5, 8, rows, cols, 1 | 1 << 16};
    for (size_t i = 0; i < sizeof head / sizeof *head; ++i)
        put(m, head[i], 4);
    memcpy(m->bytes + m->n, "r\0\0", 4);
    m->n += 4;
    if (is_small) {
        put(m, n_data << 16 | type, 4);
    } else {
        put(m, type, 4);
        put(m, n_data, 4);
    }
    for (size_t i = 0; i < rows * cols; ++i)
        put(m, values[i], width);
    while (m->n % 8)
        m->bytes[m->n++] = 0;
    size_t end = m->n;
    m->n = begin + 4;
    put(m, end - begin - 8, 4);
    m->n = end;
}

static void compress_from(maker *m, size_t begin) {
    unsigned char packed[8192];
    uLongf n = sizeof packed;
    assert_int_equal(compress(packed, &n, m->bytes + begin, m->n - begin), Z_OK);
    m->n = begin;
    put(m, 15, 4);
    put(m, n, 4);
    memcpy(m->bytes + m->n, packed, n);
    m->n += n;
}

static nqm_status read_r(const maker *m, size_t rows, size_t cols, double *out, nqm_error *err) {
    nqm_mat *mat;
    write_bytes(m->bytes, m->n);
    nqm_status status = nqm_mat_open(path, &mat, err);
    if (status == NQM_OK)
        status = nqm_mat_read(mat, "r", rows, cols, out, err);
    nqm_mat_close(mat);
    return status;
}

enum {
    CLASS_STRUCT = 2,
    CLASS_DOUBLE = 6,
    CLASS_SINGLE = 7,
    CLASS_INT8 = 8,
    CLASS_UINT16 = 11,
    CLASS_INT64 = 14,
    COMPLEX = 0x800
};

/* -3 and 100 in each type; in unsigned types -3 wraps (253 in 8 bits). */
TEST(every_type_and_byte_order) {
    static const struct {
        uint32_t type;
        size_t width;
        uint64_t first, second;
        double expected;
    } types[] = {{1, 1, 0xfd, 100, -3},
                 {2, 1, 0xfd, 100, 253},
                 {3, 2, 0xfffd, 100, -3},
                 {4, 2, 0xfffd, 100, 65533},
                 {5, 4, 0xfffffffd, 100, -3},
                 {6, 4, 0xfffffffd, 100, 4294967293.0},
                 {7, 4, 0xc0400000, 0x42c80000, -3},
                 {9, 8, 0xc008000000000000, 0x4059000000000000, -3},
                 {12, 8, 0xfffffffffffffffd, 100, -3},
                 {13, 8, 0xfffffffffffffc00, 100, 18446744073709550592.0}};
    for (size_t i = 0; i < 4 * sizeof types / sizeof *types; ++i) {
        const size_t t = i / 4;
        maker m = begin_file(i % 2);
        const uint64_t others[6] = {1, 2, 3, 4, 5, 6}, values[2] = {types[t].first, types[t].second};
        double v[2] = {0};
        put_matrix(&m, CLASS_STRUCT, 6, 4, 1, 1, others); /* skipped */
        size_t begin = m.n;
        put_matrix(&m, t % 3 == 0 ? CLASS_INT8 : CLASS_DOUBLE, types[t].type, types[t].width, 2, 1, values);
        if (i / 2 % 2)
            compress_from(&m, begin);
        assert_int_equal(read_r(&m, 2, 1, v, NULL), NQM_OK);
        assert_true(v[0] == types[t].expected && v[1] == 100);
        for (size_t n = m.n - 1; n > begin; --n) {
            m.n = n;
            nqm_status status = read_r(&m, 2, 1, v, NULL);
            assert_int_equal(status, NQM_ERR_FORMAT);
        }
    }
    maker m = begin_file(true);
    const uint64_t values[6] = {1, 2, 3, 4, 5, 6};
    double v[6];
    put_matrix(&m, CLASS_UINT16, 4, 2, 3, 2, values); /* column-major in the file, row-major in memory */
    assert_int_equal(read_r(&m, 3, 2, v, NULL), NQM_OK);
    assert_true(v[0] == 1 && v[1] == 4 && v[2] == 2 && v[5] == 6);
}

/* Reading "r" as a column of n rows fails. */
static void refuse_rows(const maker *m, size_t n, const char *words) {
    double v[500];
    nqm_error err = {0};
    assert_int_equal(read_r(m, n, 1, v, &err), NQM_ERR_FORMAT);
    if (!strstr(err.message, words))
        fail_msg("'%s' is not in '%s'", words, err.message);
}

static void refuse_r(const maker *m, const char *words) {
    refuse_rows(m, 2, words);
}

TEST(faults_are_named) {
    const uint64_t values[4] = {1, 2, 3, 4};
    maker m = begin_file(false);
    refuse_r(&m, "no numeric variable 'r'");
    put_matrix(&m, CLASS_STRUCT, 9, 8, 2, 1, values);
    refuse_r(&m, "no numeric variable 'r'");
    m.n = 128;
    put_matrix(&m, CLASS_DOUBLE | COMPLEX, 9, 8, 2, 1, values);
    refuse_r(&m, "not a real matrix");
    m.n = 128;
    put_matrix(&m, CLASS_DOUBLE, 8, 8, 2, 1, values);
    refuse_r(&m, "byte 128 has damaged values");
    m.n = 128;
    put_matrix(&m, CLASS_DOUBLE, 9, 8, 2, 2, values);
    m.bytes[128 + 36] = 1; /* declares 2 x 1 */
    refuse_r(&m, "damaged values");
    m.n = 128;
    put_matrix(&m, CLASS_SINGLE, 7, 4, 2, 1, (const uint64_t[]){0x7fc00000, 0});
    refuse_r(&m, "row 1, column 1 is not finite");
    m.n = 128;
    put_matrix(&m, CLASS_DOUBLE, 9, 8, 2, 1, values);
    compress_from(&m, 128);
    m.bytes[m.n - 1] ^= 1;
    refuse_r(&m, "no intact compressed matrix");
    m.bytes[126] = 'X';
    refuse_r(&m, "byte order at byte 126");
}

/* A matrix of 500 x 1 that has the bytes of `n` values of 8 bytes. claim: the bytes that the tag of the values claims. */
static maker short_matrix(bool big_endian, size_t n, uint32_t claim) {
    enum { ROWS_AT = 128 + 32, CLAIM_AT = 128 + 52 };
    maker m = begin_file(big_endian);
    put_matrix(&m, CLASS_INT64, 12, 8, n, 1, (const uint64_t[]){1, 2});
    const size_t end = m.n;
    m.n = ROWS_AT;
    put(&m, 500, 4);
    m.n = CLAIM_AT;
    put(&m, claim, 4);
    m.n = end;
    return m;
}

/* 2 of 500 numbers, with sizes that agree with the dimensions and with the bytes; plain, compressed, and with trailing bytes. */
TEST(values_that_end_early) {
    for (size_t i = 0; i < 8; ++i) {
        const bool big_endian = i % 2, is_packed = i / 2 % 2;
        const size_t n = i < 4 ? 2 : 0;
        for (int lies = 0; lies < 2; ++lies) {
            char words[100];
            maker m = short_matrix(big_endian, n, lies ? 4000 : (uint32_t)(8 * n));
            if (is_packed)
                compress_from(&m, 128);
            snprintf(words, sizeof words, "500 x 1 values of 8 bytes, and %zu bytes follow (byte %d of the %s)",
                     n ? 8 * n : (size_t)0, is_packed ? 40 : 176, is_packed ? "unpacked matrix" : "file");
            refuse_rows(&m, 500, words);
        }
        maker cut = short_matrix(big_endian, n, 4000);
        cut.bytes[128 + (big_endian ? 6 : 5)] = 0x10; /* the matrix claims the 4,096 bytes, too */
        if (is_packed)
            compress_from(&cut, 128);
        refuse_rows(&cut, 500, is_packed ? "claims another size than its zlib stream" : "byte 128 is cut off");
    }
    maker longer = begin_file(false);
    put_matrix(&longer, CLASS_INT64, 12, 8, 2, 1, (const uint64_t[]){1, 2});
    put(&longer, 0, 8);
    compress_from(&longer, 128);
    refuse_r(&longer, "claims another size than its zlib stream");
}

#ifdef NQM_TEST_MATIO
/* matio reads nqm's files, and nqm reads matio's compressed files. */
TEST(agrees_with_matio) {
    double values[6] = {1, -2.5, 1e-300, 4, 0.1, 1e300}, v[6];
    assert_int_equal(nqm_mat_write(path, 1, &(nqm_mat_variable){"random_locations", 2, 3, values}, NULL), NQM_OK);
    mat_t *file = Mat_Open(path, MAT_ACC_RDONLY);
    assert_non_null(file);
    matvar_t *variable = Mat_VarRead(file, "random_locations");
    assert_non_null(variable);
    assert_int_equal(variable->dims[0], 2);
    assert_int_equal(variable->dims[1], 3);
    for (size_t i = 0; i < 6; ++i)
        assert_true(((const double *)variable->data)[i % 3 * 2 + i / 3] == values[i]);
    Mat_VarFree(variable);
    Mat_Close(file);
    size_t dims[2] = {3, 2};
    file = Mat_CreateVer(path, NULL, MAT_FT_MAT5);
    assert_non_null(file);
    variable = Mat_VarCreate("r", MAT_C_DOUBLE, MAT_T_DOUBLE, 2, dims, values, MAT_F_DONT_COPY_DATA);
    assert_int_equal(Mat_VarWrite(file, variable, MAT_COMPRESSION_ZLIB), 0);
    Mat_VarFree(variable);
    Mat_Close(file);
    nqm_mat *mat;
    assert_int_equal(nqm_mat_open(path, &mat, NULL), NQM_OK);
    assert_int_equal(nqm_mat_read(mat, "r", 3, 2, v, NULL), NQM_OK);
    for (size_t i = 0; i < 6; ++i)
        assert_true(v[i] == values[i % 2 * 3 + i / 2]);
    nqm_mat_close(mat);
    unlink(path);
}
#endif
