/* SPDX-License-Identifier: MIT
 *
 * Tables as arrays of NumPy: files of numpy.save() and values of numpy (tests/vectors/npy.py), refused arrays, and written files.
 */
#include "base/base.h"
#include "base/memory_test.h"
#include "brdf/brdf.h"
#include "support/brdf_files.h"
#include "support/check.h"
#include "support/vectors.h"

#include <nqm/brdf.h>

enum { N_POINTS = 20 };

static const char *save(size_t n, const unsigned char *bytes) {
    const char *path = scratch_path("table.npy");
    unsigned char copy[2048];
    memcpy(copy, bytes, n);
    blob_save(&(blob){copy, n}, path);
    return path;
}

static const char *save_array(const char *name) {
    return blob_put(vector_npy(name), scratch_path("table.npy"));
}

TEST(agrees_with_numpy) {
    double npy_vector[N_POINTS][6]; /* theta_h, theta_d, phi_d in radians, f_r */
    get_vector("npy.safetensors", "values", sizeof npy_vector, npy_vector);
    for (int k = 0; k < 2; ++k) {
        blob file = vector_npy(k ? "f8" : "f4");
        const size_t n_bytes = file.n_bytes;
        const char *path = blob_put(file, scratch_path("table.npy"));
        nqm_brdf *brdf = must_open(path);
        for (size_t i = 0; i < N_POINTS; ++i) {
            double rgb[3];
            nqm_brdf_eval_half_diff(brdf, 1, npy_vector[i], rgb, NULL);
            for (size_t c = 0; c < 3; ++c)
                assert_near(rgb[c], npy_vector[i][3 + c], 1e-12);
        }
        nqm_brdf_info info = nqm_brdf_get_info(brdf);
        assert_string_equal(info.format, "table");
        assert_string_equal(info.name, path);
        assert_int_equal(info.n_values, 3 * 2 * 4 * 3);
        assert_int_equal(info.n_bytes, n_bytes);
        nqm_brdf_free(brdf);
    }
}

TEST(agrees_with_numpy_at_any_azimuth) {
    double npy_turned_vector[N_POINTS][9]; /* light, viewer, f_r */
    get_vector("npy.safetensors", "turned", sizeof npy_turned_vector, npy_turned_vector);
    nqm_brdf *brdf = must_open(save_array("turned"));
    for (size_t i = 0; i < N_POINTS; ++i) {
        const double *v = npy_turned_vector[i];
        double rgb[3];
        nqm_brdf_eval(brdf, 1, v, v + 3, rgb, NULL);
        for (size_t c = 0; c < 3; ++c)
            assert_near(rgb[c], v[6 + c], 1e-12);
    }
    assert_string_equal(nqm_brdf_get_info(brdf).layout, "3x2x4x3 nodes");
    assert_int_equal(nqm_brdf_get_info(brdf).isotropic, 0);
    const char *copy = scratch_path("copy.npy"); /* is written as it was read */
    assert_int_equal(nqm_brdf_write(brdf, NQM_FILE_NPY, NULL, copy, NULL, NULL, NULL), NQM_OK);
    nqm_brdf_free(brdf);
    blob file = blob_load(copy), read = vector_npy("turned");
    assert_int_equal(file.n_bytes, read.n_bytes);
    assert_memory_equal(file.data + 128, read.data + 128, read.n_bytes - 128);
    blob_free(&file);
    blob_free(&read);
}

static void expect_refused(const char *path, int64_t byte_offset, const char *words) {
    assert_int_equal(must_refuse(path, NQM_ERR_FORMAT, words).byte_offset, byte_offset);
}

TEST(refuses_other_arrays) {
    blob file = vector_npy("f4");
    const size_t n = file.n_bytes;
    unsigned char changed[1000] = {0};
    memcpy(changed, file.data, n);
    blob_free(&file);
    expect_refused(save_array("fortran"), 10, "Fortran order");
    expect_refused(save_array("big"), 10, "'>f4'");
    expect_refused(save_array("integer"), 10, "'<i4'");
    expect_refused(save_array("planes"), 10, "shape (3, 2, 2, 2)");
    expect_refused(save(n - 1, changed), (int64_t)n - 1, "it ends");
    expect_refused(save(100, changed), 100, "inside its header");
    expect_refused(save(9, changed), 0, "begins no .npy file");
    expect_refused(save(n + 1, changed), (int64_t)n, "more follows");
    changed[6] = 9;
    expect_refused(save(n, changed), 0, "version 1 to 3");
    changed[6] = 1;
    changed[10] = '[';
    expect_refused(save(n, changed), 10, "header with 'descr'");
    changed[10] = '{';
    nqm_store_f32(changed + n - 4, INFINITY);
    expect_refused(save(n, changed), (int64_t)n - 4, "not finite");
}

/* A table is written with the same values, and any other BRDF as its table. */
TEST(writes_what_it_reads) {
    const char *path = save_array("f4"), *copy = scratch_path("copy.npy");
    nqm_table_size size, again_size;
    nqm_brdf *brdf = must_open(path);
    assert_int_equal(nqm_brdf_write(brdf, NQM_FILE_NPY, NULL, copy, NULL, NULL, NULL), NQM_OK);
    nqm_brdf *again = must_open(copy);
    const float *a = nqm_table_values(brdf, &size), *b = nqm_table_values(again, &again_size);
    assert_memory_equal(&size, &again_size, sizeof size);
    assert_memory_equal(a, b, 3 * 2 * 4 * 3 * sizeof *a);
    blob file = blob_load(copy);
    assert_int_equal((file.n_bytes - 3 * 2 * 4 * 3 * sizeof *a) % 64, 0);
    blob_free(&file);
    nqm_brdf_free(again);
    nqm_brdf_free(brdf);

    brdf = must_open("ggx:kd=.2;alpha=.4");
    assert_int_equal(nqm_brdf_write(brdf, NQM_FILE_NPY, NULL, copy, NULL, NULL, NULL), NQM_OK);
    again = must_open(copy);
    assert_string_equal(nqm_brdf_get_info(again).layout, "90x46x24 nodes");
    const double hd[3] = {0.3, 0.4, 1};
    double rgb[3], expected[3];
    nqm_brdf_eval_half_diff(brdf, 1, hd, expected, NULL);
    nqm_brdf_eval_half_diff(again, 1, hd, rgb, NULL);
    assert_relative(rgb[0], expected[0], 1e-3);
    nqm_alloc_fail_after(0);
    assert_int_equal(nqm_brdf_write(brdf, NQM_FILE_NPY, NULL, copy, NULL, NULL, NULL), NQM_ERR_NOMEM);
    nqm_alloc_fail_after(-1);
    assert_int_equal(nqm_brdf_write(brdf, NQM_FILE_NPY, NULL, "/nowhere/x.npy", NULL, NULL, NULL), NQM_ERR_IO);
    nqm_brdf_free(again);
    nqm_brdf_free(brdf);
}
