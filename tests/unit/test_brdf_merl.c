/* SPDX-License-Identifier: MIT
 *
 * MERL tables: the cell and the scale of a lookup, refused files, and tables written from another BRDF.
 */
#include "base/base.h"
#include "base/memory_test.h"
#include "support/brdf_files.h"
#include "support/check.h"

#include <nqm/brdf.h>

static const double pi = 3.14159265358979323846;
static const double scale[3] = {1 / 1500.0, 1.15 / 1500, 1.66 / 1500};

static nqm_brdf *open_table(void) {
    const char *path = scratch_path("table.binary");
    if (access(path, R_OK) != 0)
        blob_put(make_merl(), path);
    nqm_brdf *brdf;
    assert_int_equal(nqm_brdf_open(path, &brdf, NULL), NQM_OK);
    return brdf;
}

/* A random point of a cell, between its edges in the angles; cells are uniform in sqrt(theta_h). */
static void point_in_cell(const size_t *cell, nqm_rng *rng, double *hd) {
    double root = ((double)cell[0] + 0.01 + 0.98 * nqm_rng_uniform(rng)) / 90;
    hd[0] = root * root * pi / 2;
    hd[1] = ((double)cell[1] + 0.01 + 0.98 * nqm_rng_uniform(rng)) * pi / 180;
    hd[2] = ((double)cell[2] + 0.01 + 0.98 * nqm_rng_uniform(rng)) * pi / 180;
}

/* Whether both directions are above the horizon by a margin, from light and viewer in the half-vector frame. */
static bool above_horizon(const double *hd) {
    return cos(hd[0]) * cos(hd[1]) - fabs(sin(hd[0]) * sin(hd[1]) * cos(hd[2])) > 1e-9;
}

TEST(reads_the_nearest_cell) {
    const uint64_t seed = 11;
    print_message("seed %d\n", (int)seed);
    nqm_brdf *brdf = open_table();
    nqm_rng rng = nqm_rng_make(seed, 0);
    size_t n_read = 0, n_empty = 0;
    for (int i = 0; i < 4000; ++i) {
        size_t cell[3] = {nqm_rng_below(&rng, 90), nqm_rng_below(&rng, 90), nqm_rng_below(&rng, 180)};
        double hd[3], wi[3], wo[3], by_angles[3], by_vectors[3];
        uint8_t flag, flag_by_vectors;
        point_in_cell(cell, &rng, hd);
        nqm_brdf_eval_half_diff(brdf, 1, hd, by_angles, &flag);
        nqm_half_diff_to_directions(hd, wi, wo);
        nqm_brdf_eval(brdf, 1, wi, wo, by_vectors, &flag_by_vectors);
        bool empty = merl_cell(0, cell[0], cell[1], cell[2]) < 0, above = above_horizon(hd);
        assert_int_equal(flag, !above ? NQM_VALUE_HORIZON : empty ? NQM_VALUE_INVALID : NQM_VALUE_OK);
        assert_int_equal(flag_by_vectors, flag);
        n_read += flag == NQM_VALUE_OK;
        n_empty += flag == NQM_VALUE_INVALID;
        for (size_t c = 0; c < 3; ++c) {
            double stored = flag == NQM_VALUE_OK ? merl_cell(c, cell[0], cell[1], cell[2]) : 0;
            assert_relative(by_angles[c], stored * scale[c], 1e-15);
            assert_true(by_vectors[c] == by_angles[c]);
        }
    }
    assert_true(n_read > 1000 && n_empty > 10);
    nqm_brdf_free(brdf);
}

/* The limits of the angles, and phi_d beyond pi. */
TEST(reads_at_the_edges) {
    nqm_brdf *brdf = open_table();
    enum { N = 5 };
    const double hd[N][3] = {{0, 0, 0}, {0, 0, pi}, {0.3, 0.2, 1 + pi}, {0.3, 0.2, 1 - 4 * pi}, {0, pi / 2, 0}};
    const size_t cell[N][3] = {{0, 0, 0}, {0, 0, 0}, {39, 11, 57}, {39, 11, 57}, {0, 89, 0}};
    double rgb[3 * N];
    uint8_t flag[N];
    nqm_brdf_eval_half_diff(brdf, N, hd[0], rgb, flag);
    for (size_t i = 0; i < N; ++i) {
        assert_int_equal(flag[i], NQM_VALUE_OK);
        for (size_t c = 0; c < 3; ++c)
            assert_relative(rgb[3 * i + c], scale[c] * merl_cell(c, cell[i][0], cell[i][1], cell[i][2]), 1e-15);
    }
    nqm_brdf_free(brdf);
}

TEST(tells_about_itself) {
    nqm_brdf *brdf = open_table();
    nqm_brdf_info info = nqm_brdf_get_info(brdf);
    assert_string_equal(info.format, "merl");
    assert_string_equal(info.layout, "90 x 90 x 180 cells");
    assert_string_equal(info.source_doi, "10.1145/882262.882343");
    assert_string_equal(info.name, scratch_path("table.binary"));
    assert_null(info.spec);
    assert_int_equal(info.n_values, 3 * 90 * 90 * 180);
    assert_int_equal(info.n_bytes, MERL_BYTES);
    assert_int_equal(info.reciprocal, 1);
    nqm_brdf_free(brdf);
}

static void expect_refused(const char *path, nqm_status status, int64_t byte_offset) {
    char words[32];
    snprintf(words, sizeof words, "byte %lld", (long long)byte_offset);
    assert_int_equal(must_refuse(path, status, words).byte_offset, byte_offset);
}

TEST(refuses_broken_tables) {
    const char *path = scratch_path("broken.binary");
    blob valid = make_merl(), head = valid;
    head.n_bytes = 1000;
    blob_save(&head, path);
    expect_refused(path, NQM_ERR_FORMAT, 1000);
    head.n_bytes = 12;
    blob_save(&head, path);
    expect_refused(path, NQM_ERR_FORMAT, 12);
    blob_save_sparse(&valid, MERL_BYTES + 8, path);
    expect_refused(path, NQM_ERR_FORMAT, MERL_BYTES);
    head.n_bytes = 5000;
    valid.data[4] = 91; /* 90 x 91 x 180, at the right size */
    blob_save_sparse(&head, MERL_BYTES, path);
    expect_refused(path, NQM_ERR_FORMAT, 0);
    nqm_store_u32(valid.data, 0x80000000U); /* the header declares 2^31 x 2^31 cells */
    nqm_store_u32(valid.data + 4, 0x80000000U);
    blob_save(&head, path);
    expect_refused(path, NQM_ERR_FORMAT, 0);
    blob_free(&valid);
}

TEST(refuses_a_table_without_numbers) {
    const char *path = scratch_path("nan.binary");
    blob b = make_merl();
    memset(b.data + 12, 0xff, b.n_bytes - 12); /* all bits set is a NaN */
    blob_put(b, path);
    expect_refused(path, NQM_ERR_FORMAT, 12);
}

/* A file with single cells that are not finite can be opened; those cells are flagged as invalid. */
TEST(flags_cells_that_are_not_finite) {
    const char *path = scratch_path("hole.binary");
    blob b = make_merl();
    nqm_store_f64(b.data + 12 + 8 * (90 * 90 * 180), (double)NAN); /* green of cell 0 */
    nqm_store_f64(b.data + 12 + 8, (double)INFINITY);              /* red of cell 1 */
    blob_put(b, path);
    nqm_brdf *brdf;
    assert_int_equal(nqm_brdf_open(path, &brdf, NULL), NQM_OK);
    const double hd[9] = {0, 0.001, 0.001, 0, 0.001, 0.02, 0, 0.001, 0.04};
    double rgb[9];
    uint8_t flag[3];
    nqm_brdf_eval_half_diff(brdf, 3, hd, rgb, flag);
    assert_int_equal(flag[0], NQM_VALUE_INVALID);
    assert_int_equal(flag[1], NQM_VALUE_INVALID);
    assert_int_equal(flag[2], NQM_VALUE_OK);
    assert_true(rgb[0] == 0 && rgb[1] == 0 && rgb[2] == 0 && rgb[6] > 0);
    nqm_brdf_free(brdf);
}

/* ---- 360 phi_d --------------------------------------------------------------------------------------------------- */

/* Exchanging light and viewer adds 180 degrees to phi_d; a table of 360 has its own cells there. */
TEST(distinguishes_light_and_viewer) {
    const uint64_t seed = 12;
    print_message("seed %d\n", (int)seed);
    const char *path = scratch_path("full.binary");
    blob_put(make_merl_360(), path);
    nqm_brdf *brdf;
    assert_int_equal(nqm_brdf_open(path, &brdf, NULL), NQM_OK);
    nqm_rng rng = nqm_rng_make(seed, 0);
    size_t n_read = 0;
    for (int i = 0; i < 4000; ++i) {
        size_t cell[3] = {nqm_rng_below(&rng, 90), nqm_rng_below(&rng, 90), nqm_rng_below(&rng, 360)};
        double hd[3], wi[3], wo[3], by_angles[3], by_vectors[3], exchanged[3];
        uint8_t flag;
        point_in_cell(cell, &rng, hd);
        nqm_brdf_eval_half_diff(brdf, 1, hd, by_angles, &flag);
        nqm_half_diff_to_directions(hd, wi, wo);
        nqm_brdf_eval(brdf, 1, wi, wo, by_vectors, NULL);
        nqm_brdf_eval(brdf, 1, wo, wi, exchanged, NULL);
        for (size_t c = 0; c < 3 && flag == NQM_VALUE_OK; ++c) {
            assert_relative(by_angles[c], scale[c] * merl_cell(c, cell[0], cell[1], cell[2]), 1e-15);
            assert_true(by_vectors[c] == by_angles[c]);
            assert_relative(exchanged[c], scale[c] * merl_cell(c, cell[0], cell[1], (cell[2] + 180) % 360), 1e-15);
        }
        n_read += flag == NQM_VALUE_OK;
    }
    assert_true(n_read > 1000);
    nqm_brdf_info info = nqm_brdf_get_info(brdf);
    assert_string_equal(info.format, "merl");
    assert_string_equal(info.layout, "90 x 90 x 360 cells");
    assert_int_equal(info.n_values, 3 * 90 * 90 * 360);
    assert_int_equal(info.reciprocal, 0);

    const char *copy = scratch_path("copy.binary");
    nqm_brdf *again;
    assert_int_equal(nqm_brdf_write(brdf, NQM_FILE_MERL_360, NULL, copy, NULL, NULL, NULL), NQM_OK);
    assert_int_equal(nqm_brdf_open(copy, &again, NULL), NQM_OK);
    for (int i = 0; i < 1000; ++i) {
        const size_t cell[3] = {nqm_rng_below(&rng, 90), nqm_rng_below(&rng, 90), nqm_rng_below(&rng, 360)};
        const double root = ((double)cell[0] + 0.5) / 90;
        const double hd[3] = {root * root * pi / 2, ((double)cell[1] + 0.5) * pi / 180,
                              ((double)cell[2] + 0.5) * pi / 180};
        double rgb[3], expected[3];
        nqm_brdf_eval_half_diff(brdf, 1, hd, expected, NULL);
        nqm_brdf_eval_half_diff(again, 1, hd, rgb, NULL);
        for (size_t c = 0; c < 3; ++c)
            assert_near(rgb[c], expected[c], 1e-15);
    }
    nqm_brdf_free(again);
    unsigned char head[16] = {90, 0, 0, 0, 90, 0, 0, 0, 104, 1, 0, 0}; /* 90, 90, 360 */
    blob_save_sparse(&(blob){head, sizeof head}, 12 + 3 * 90 * 90 * 360 * 8 - 8, copy);
    expect_refused(copy, NQM_ERR_FORMAT, 12 + 3 * 90 * 90 * 360 * 8 - 8);
    nqm_error err = {0};
    assert_int_equal(nqm_brdf_write(brdf, (nqm_file_format)99, NULL, copy, NULL, NULL, &err), NQM_ERR_ARG);
    nqm_brdf_free(brdf);
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

static nqm_brdf *open_network(void) {
    const char *path = scratch_path("network.h5");
    blob_put(make_nbrdf(NBRDF_VALID), path);
    nqm_brdf *brdf;
    assert_int_equal(nqm_brdf_open(path, &brdf, NULL), NQM_OK);
    return brdf;
}

typedef struct ticks {
    int n, stop_at;
    double last, total;
} ticks;

static int count_ticks(void *user, const char *stage, double done, double total) {
    ticks *t = user;
    assert_non_null(stage);
    assert_true(done >= t->last && done <= total);
    t->last = done;
    t->total = total;
    return ++t->n == t->stop_at;
}

TEST(writes_what_it_reads) {
    const char *path = scratch_path("written.binary");
    nqm_brdf *network = open_network(), *table;
    ticks t = {0};
    assert_int_equal(nqm_brdf_write(network, NQM_FILE_MERL, NULL, path, count_ticks, &t, NULL), NQM_OK);
    assert_true(t.n >= 1 && t.last == t.total && t.total > 0);
    assert_int_equal(nqm_brdf_open(path, &table, NULL), NQM_OK);
    blob b = blob_load(path);
    assert_int_equal(b.n_bytes, MERL_BYTES);
    size_t n_above = 0;
    for (size_t cell = 0; cell < 90 * 90 * 180; cell += 37) {
        double root = ((double)(cell / 16200) + 0.5) / 90, from_table[3], from_network[3];
        const double hd[3] = {root * root * pi / 2, ((double)(cell / 180 % 90) + 0.5) * pi / 180,
                              ((double)(cell % 180) + 0.5) * pi / 180};
        uint8_t flag;
        nqm_brdf_eval_half_diff(network, 1, hd, from_network, NULL);
        nqm_brdf_eval_half_diff(table, 1, hd, from_table, &flag);
        n_above += above_horizon(hd);
        for (size_t c = 0; c < 3; ++c) {
            double stored = nqm_load_f64(b.data + 12 + 8 * (c * 90 * 90 * 180 + cell));
            if (flag == NQM_VALUE_HORIZON)
                assert_true(stored == -1);
            else
                assert_near(from_table[c], from_network[c], 1e-15 + 1e-14 * from_network[c]);
        }
    }
    assert_true(n_above > 5000);
    blob_free(&b);
    nqm_brdf_free(table);
    nqm_brdf_free(network);
}

TEST(stops_and_leaves_nothing) {
    const char *path = scratch_path("cancelled.binary");
    nqm_brdf *network = open_network();
    ticks t = {.stop_at = 1};
    nqm_error err = {0};
    assert_int_equal(nqm_brdf_write(network, NQM_FILE_MERL, NULL, path, count_ticks, &t, &err), NQM_ERR_CANCELLED);
    assert_int_equal(err.status, NQM_ERR_CANCELLED);
    assert_int_equal(access(path, F_OK), -1);
    assert_int_equal(nqm_brdf_write(network, NQM_FILE_MERL, NULL, "/nowhere/x.binary", NULL, NULL, &err), NQM_ERR_IO);
    nqm_alloc_fail_after(0);
    assert_int_equal(nqm_brdf_write(network, NQM_FILE_MERL, NULL, path, NULL, NULL, &err), NQM_ERR_NOMEM);
    nqm_alloc_fail_after(-1);
    nqm_brdf_free(network);
}
