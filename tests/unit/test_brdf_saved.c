/* SPDX-License-Identifier: MIT
 *
 * Networks and tables in nqm's own file format: saved BRDFs are read back with the same values, and broken files are
 * refused with a clear message.
 */
#include "brdf/brdf.h"
#include "support/allocations.h"
#include "support/brdf_files.h"
#include "support/check.h"

#include <nqm/brdf.h>

/* Compare values and flags at many directions. */
static void assert_same(const nqm_brdf *a, const nqm_brdf *b) {
    enum { N = 500 };
    double hd[3 * N], x[3 * N], y[3 * N];
    uint8_t flag_x[N], flag_y[N];
    for (uint32_t i = 0; i < 3 * N; ++i)
        hd[i] = noise(i, 4) * (i % 3 == 2 ? 3 : 0.75);
    nqm_brdf_eval_half_diff(a, N, hd, x, flag_x);
    nqm_brdf_eval_half_diff(b, N, hd, y, flag_y);
    assert_memory_equal(x, y, sizeof x);
    assert_memory_equal(flag_x, flag_y, sizeof flag_x);
    assert_true(x[0] != x[3]);
}

static void goes_round(const nqm_brdf *brdf, const char *format) {
    const char *path = scratch_path("saved.safetensors");
    nqm_error err = {0};
    if (nqm_brdf_save(brdf, path, &err) != NQM_OK)
        fail_msg("%s", err.message);
    nqm_brdf *read = must_open(path);
    nqm_brdf_info info = nqm_brdf_get_info(read), of_source = nqm_brdf_get_info(brdf);
    assert_string_equal(info.format, format);
    assert_string_equal(info.name, path);
    assert_string_equal(info.layout, of_source.layout);
    assert_int_equal(info.n_values, of_source.n_values);
    assert_true(info.n_bytes > 4 * info.n_values && info.reciprocal);
    assert_same(brdf, read);
    nqm_brdf_free(read);
}

TEST(networks_go_round) {
    const char *path = scratch_path("network.h5");
    blob_put(make_nbrdf(NBRDF_VALID), path);
    nqm_brdf *brdf = must_open(path);
    goes_round(brdf, "nbrdf");
    nqm_brdf_free(brdf);
}

TEST(tables_go_round) {
    enum { H = 7, D = 5, P = 4 };
    float rgb[H * D * P * 3];
    for (uint32_t i = 0; i < H * D * P * 3; ++i)
        rgb[i] = (float)noise(i, 5);
    rgb[27] = NAN;
    nqm_brdf *brdf;
    assert_int_equal(nqm_table_create((nqm_table_size){H, D, P, 1}, rgb, "table", &brdf, NULL), NQM_OK);
    goes_round(brdf, "table");
    nqm_brdf_free(brdf);
}

/* The layout in the documentation, written without nqm_brdf_save(). */
TEST(files_mean_what_is_documented) {
    const char *path = scratch_path("made.safetensors");
    double hd[3], rgb[3];
    uint8_t flag;
    blob_put(make_saved(SAVED_TABLE), path);
    nqm_brdf *table = must_open(path);
    nqm_table_node(4, 3, 5, 1, 0, 2, hd); /* node (1 * 3 + 0) * 5 + 2 */
    nqm_brdf_eval_half_diff(table, 1, hd, rgb, &flag);
    for (uint32_t c = 0; c < 3; ++c)
        assert_near(rgb[c], noise(3 * 17 + c, 9), 1e-6);
    nqm_table_node(4, 3, 5, 2, 1, 0, hd);
    hd[0] *= 0.5625; /* halfway to (1, 1, 0), which has no value: only (2, 1, 0) contributes */
    nqm_brdf_eval_half_diff(table, 1, hd, rgb, &flag);
    for (uint32_t c = 0; c < 3; ++c)
        assert_near(rgb[c], noise(3 * 35 + c, 9), 1e-6);
    nqm_brdf_free(table);
    blob_put(make_saved(SAVED_NETWORK), path);
    nqm_brdf *network = must_open(path), *made;
    float weights[NQM_NBRDF_WEIGHTS];
    for (uint32_t i = 0; i < NQM_NBRDF_WEIGHTS; ++i)
        weights[i] = (float)noise(i, 9) - 0.5f;
    assert_int_equal(nqm_nbrdf_create(weights, "made", &made, NULL), NQM_OK);
    assert_same(network, made);
    nqm_brdf_free(made);
    nqm_brdf_free(network);
}

TEST(others_are_not_saved) {
    nqm_error err = {0};
    nqm_brdf *brdf = must_open("lambert:kd=0.5");
    assert_int_equal(nqm_brdf_save(brdf, scratch_path("none.safetensors"), &err), NQM_ERR_ARG);
    assert_non_null(strstr(err.message, "lambert"));
    nqm_brdf_free(brdf);
}

TEST(faults_are_told) {
    static const char *const words[SAVED_KINDS] = {
        [SAVED_MISSING] = "'layers.2.bias' is missing",
        [SAVED_EXTRA] = "more tensors",
        [SAVED_SHAPE] = "'layers.0.kernel' has the wrong type or shape",
        [SAVED_DOUBLE] = "'layers.0.bias' has the wrong type or shape",
        [SAVED_NAN] = "'layers.1.kernel' contains a value that is not finite",
        [SAVED_FORMAT] = "'nqm-model', no BRDF",
        [SAVED_SCHEMA] = "schema 1 only",
        [SAVED_CHECKSUM] = "checksum",
        [SAVED_TABLE_NAN] = "'rgb' contains a value that is not finite",
        [SAVED_TABLE_FLAT] = "fewer than two nodes",
    };
    const char *path = scratch_path("broken.safetensors");
    for (saved_kind kind = 0; kind < SAVED_KINDS; ++kind) {
        nqm_error err = {0};
        nqm_brdf *brdf;
        if (!words[kind])
            continue;
        blob_put(make_saved(kind), path);
        assert_int_equal(nqm_brdf_open(path, &brdf, &err), NQM_ERR_FORMAT);
        assert_null(brdf);
        assert_true(err.byte_offset >= 8);
        if (!strstr(err.message, words[kind]) || !strstr(err.message, path))
            fail_msg("message: %s", err.message);
    }
}

TEST(cut_files_are_refused) {
    const char *path = scratch_path("cut.safetensors");
    blob whole = make_saved(SAVED_TABLE);
    for (size_t n = 1; n < whole.n_bytes; n += 7) {
        blob part = {whole.data, n};
        nqm_brdf *brdf;
        blob_save(&part, path);
        assert_int_equal(nqm_brdf_open(path, &brdf, NULL), NQM_ERR_FORMAT);
    }
    blob_free(&whole);
}

TEST(survives_failing_allocations) {
    const char *path = scratch_path("memory.safetensors");
    (void)check_brdf_allocations(blob_put(make_saved(SAVED_NETWORK), path));
    (void)check_brdf_allocations(blob_put(make_saved(SAVED_TABLE), path));
}
