/* SPDX-License-Identifier: MIT
 *
 * MAT v5 matrices: files of scipy.io.savemat (tests/vectors/authors.py) read back, and everything that is no such file,
 * or is one cut off or changed at any byte, refused or read as finite numbers, never more than asked for.
 */
#include "io/io.h"
#include "support/check.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

static const char path[] = "test_io_mat.mat";

/* Plain, compressed, of singles with compression, and with row vectors. */
static const char *const files[] = {"authors/ref/brass_1.mat", "authors/ref/brass_2.mat",
                                    "authors/model/felt_m_68_rgb_1.mat", "authors/model/felt_m_68_rgb_2.mat"};

static void reads_what_scipy_wrote(void **state) {
    (void)state;
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

/* Open and read all; on success the numbers are finite. */
static nqm_status read_all(void) {
    nqm_mat *mat;
    double v[21];
    nqm_status status = nqm_mat_open(path, &mat, NULL);
    if (status != NQM_OK)
        return status;
    status = nqm_mat_read(mat, "random_locations", 7, 3, v, NULL);
    for (size_t i = 0; status == NQM_OK && i < 21; ++i)
        assert_true(isfinite(v[i]));
    if (status == NQM_OK)
        status = nqm_mat_read(mat, "r", 7, 1, v, NULL);
    nqm_mat_close(mat);
    return status;
}

static void no_mat_files(void **state) {
    (void)state;
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

/* A header that claims 2^31 - 1 rows: refused before anything is allocated. */
static void huge_claims(void **state) {
    (void)state;
    nqm_map map;
    assert_int_equal(nqm_map_open(test_vector(files[0]), &map, NULL), NQM_OK);
    unsigned char bytes[1024];
    assert_true(map.n_bytes < sizeof bytes);
    const uint32_t huge = 0x7fffffff;
    size_t n_claims = 0;
    for (size_t at = 128; at + 8 <= map.n_bytes; at += 4) {
        const uint32_t dims[2] = {7, 1};
        if (memcmp(map.data + at, dims, sizeof dims) != 0)
            continue;
        memcpy(bytes, map.data, map.n_bytes);
        memcpy(bytes + at, &huge, 4);
        memcpy(bytes + at + 4, &huge, 4);
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

static void cut_and_changed(void **state) {
    (void)state;
    for (size_t i = 0; i < 2; ++i) {
        nqm_map map;
        assert_int_equal(nqm_map_open(test_vector(files[i]), &map, NULL), NQM_OK);
        unsigned char *bytes = malloc(map.n_bytes);
        assert_non_null(bytes);
        for (size_t at = 0; at < map.n_bytes; at += 1 + i) {
            memcpy(bytes, map.data, map.n_bytes);
            bytes[at] ^= 0xff;
            write_bytes(bytes, map.n_bytes);
            nqm_status status = read_all(); /* a changed number may pass, MAT files have no checksum */
            assert_true(status == NQM_OK || status == NQM_ERR_FORMAT || status == NQM_ERR_LIMIT);
        }
        for (size_t n = 0; n < map.n_bytes; n += 1 + 2 * i) {
            write_bytes(map.data, n);
            nqm_status status = read_all();
            assert_true(status == NQM_ERR_FORMAT || (status == NQM_OK && n + 200 > map.n_bytes)); /* behind r is g, b */
        }
        free(bytes);
        nqm_map_close(&map);
    }
    struct rusage usage; /* matio by itself would have asked for 8 GB and touched 4 */
    assert_int_equal(getrusage(RUSAGE_SELF, &usage), 0);
    assert_true(usage.ru_maxrss < 500 * 1024);
    unlink(path);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reads_what_scipy_wrote),
        cmocka_unit_test(no_mat_files),
        cmocka_unit_test(huge_claims),
        cmocka_unit_test(cut_and_changed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
