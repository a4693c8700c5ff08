/* SPDX-License-Identifier: MIT
 *
 * Writing MAT v5 files: values are read back to the bit, equal values give equal bytes, and a failed write leaves no
 * file.
 */
#include "io/io.h"
#include "sample/sample.h"
#include "support/check.h"

#include <dirent.h>
#include <nqm/samples.h>

static const char path[] = "test_io_mat_write.mat", other[] = "test_io_mat_write_2.mat";

static const double matrix[6] = {1, -2.5, 1e-300, 4, 0.1, 1e300}, column[3] = {0, -0.0, 7};

static void write_two(const char *where) {
    const nqm_mat_variable variables[] = {{"random_locations", 2, 3, matrix}, {"r", 3, 1, column}};
    nqm_error err = {0};
    if (nqm_mat_write(where, 2, variables, &err) != NQM_OK)
        fail_msg("%s", err.message);
}

TEST(reads_back) {
    write_two(path);
    nqm_mat *mat;
    size_t rows, cols;
    double m[6], c[3];
    assert_int_equal(nqm_mat_open(path, &mat, NULL), NQM_OK);
    assert_int_equal(nqm_mat_shape(mat, "random_locations", &rows, &cols, NULL), NQM_OK);
    assert_int_equal(rows, 2);
    assert_int_equal(cols, 3);
    assert_int_equal(nqm_mat_read(mat, "random_locations", 2, 3, m, NULL), NQM_OK);
    assert_memory_equal(m, matrix, sizeof m);
    assert_int_equal(nqm_mat_read(mat, "r", 3, 1, c, NULL), NQM_OK);
    assert_memory_equal(c, column, sizeof c);
    nqm_mat_close(mat);
    unlink(path);
}

/* The file contains only the header and two arrays: no date and no host name, so equal input gives equal bytes. */
TEST(equal_bytes) {
    write_two(path);
    write_two(other);
    nqm_map a, b;
    assert_int_equal(nqm_map_open(path, &a, NULL), NQM_OK);
    assert_int_equal(nqm_map_open(other, &b, NULL), NQM_OK);
    assert_int_equal(a.n_bytes, b.n_bytes);
    assert_memory_equal(a.data, b.data, a.n_bytes);
    assert_int_equal(a.n_bytes, 128 + (8 + 16 + 16 + 24 + 8 + 48) + (8 + 16 + 16 + 16 + 8 + 24));
    assert_memory_equal(a.data, "MATLAB 5.0 MAT-file, created by nqm", 36);
    assert_memory_equal(a.data + 124, "\0\1IM", 4);
    nqm_map_close(&a);
    nqm_map_close(&b);
    unlink(path);
    unlink(other);
}

static void refuse(const char *where, const char *name, size_t rows, size_t cols, const double *data, nqm_status status,
                   const char *words) {
    const nqm_mat_variable variable = {name, rows, cols, data};
    nqm_error err = {0};
    assert_int_equal(nqm_mat_write(where, 1, &variable, &err), status);
    if (!strstr(err.message, words))
        fail_msg("'%s' is not in '%s'", words, err.message);
}

TEST(refuses) {
    const double not_finite[2] = {1, NAN};
    refuse(path, "r", 1, 2, not_finite, NQM_ERR_ARG, "'r' at row 1, column 2");
    refuse(path, "r", 0, 2, column, NQM_ERR_LIMIT, "0 x 2");
    refuse(path, "r", (size_t)1 << 40, (size_t)1 << 40, column, NQM_ERR_LIMIT, "elements");
    refuse("no/such/folder/x.mat", "r", 1, 2, column, NQM_ERR_IO, "no/such/folder");
    assert_int_not_equal(access(path, F_OK), 0);
    DIR *folder = opendir(".");
    assert_non_null(folder);
    for (struct dirent *entry = readdir(folder); entry; entry = readdir(folder))
        if (strncmp(entry->d_name, path, strlen(path)) == 0)
            fail_msg("%s was left behind", entry->d_name);
    closedir(folder);
}

/* The file has the variables of the authors' layout. */
TEST(samples_of_a_brdf) {
    const double degrees[6] = {0, 10, 20, 30.25, 40, 50};
    const float rgb[6] = {0.5f, 0.25f, 0.125f, 1, 2, 3};
    double r[2], b[2], locations[6];
    nqm_directions *directions;
    nqm_mat *mat;
    assert_int_equal(nqm_directions_from_degrees(2, degrees, &directions, NULL), NQM_OK);
    assert_int_equal(nqm_samples_save_mat(directions, rgb, path, NULL), NQM_OK);
    assert_int_equal(nqm_mat_open(path, &mat, NULL), NQM_OK);
    assert_int_equal(nqm_mat_read(mat, "r", 2, 1, r, NULL), NQM_OK);
    assert_int_equal(nqm_mat_read(mat, "b", 2, 1, b, NULL), NQM_OK);
    assert_int_equal(nqm_mat_read(mat, "random_locations", 2, 3, locations, NULL), NQM_OK);
    assert_true(r[0] == 0.5 && r[1] == 1 && b[0] == 0.125 && b[1] == 3);
    assert_memory_equal(locations, degrees, sizeof degrees);
    nqm_mat_close(mat);
    nqm_directions_free(directions);
    unlink(path);
}
