/* SPDX-License-Identifier: MIT
 *
 * The sparse encoding: mapping and bases have exact inverses, a table in the span of the atoms is coded exactly, more
 * atoms reduce the loss, coarser levels increase it, cells without a value are filled, and a BRDF without values is refused.
 */
#include "brdf/brdf.h"
#include "encode/encode.h"
#include "fit/fit.h"
#include "math/math.h"
#include "support/allocations.h"
#include "support/check.h"
#include "support/encoder_files.h"
#include "support/scratch.h"

#include <nqm/fit.h>

enum { CELLS = NQM_SPARSE_CELLS, CORE = NQM_SPARSE_CORE };

static nqm_sparse_dictionary *builtin(void) {
    size_t n_bytes;
    nqm_error err = {0};
    nqm_sparse_dictionary *dictionary;
    const unsigned char *bytes = nqm_encoder_bytes("sparse", &n_bytes);
    assert_non_null(bytes);
    if (nqm_sparse_dictionary_parse(bytes, n_bytes, "sparse", &dictionary, &err) != NQM_OK)
        fail_msg("%s", err.message);
    return dictionary;
}

TEST(the_mapping_is_undone) {
    static float table[3 * CELLS], before[3 * CELLS], typical[CELLS];
    nqm_sparse_grid grid;
    size_t n_valid;
    nqm_brdf *brdf = must_open("sgd:nickel");
    assert_int_equal(nqm_sparse_grid_make(&grid, NULL), NQM_OK);
    assert_true(grid.n > CELLS / 2 && grid.n < CELLS);
    assert_int_equal(nqm_sparse_sample(&grid, brdf, table, &n_valid, NULL), NQM_OK);
    assert_int_equal(n_valid, grid.n);
    memcpy(before, table, sizeof table);
    for (size_t i = 0; i < CELLS; ++i)
        typical[i] = 0.01f * (float)(i % 7);
    nqm_sparse_map(&grid, typical, table);
    /* The first channel is the mean of the logarithms times sqrt(3). */
    size_t cell = grid.cell[1234];
    double sum = 0;
    for (size_t c = 0; c < 3; ++c)
        sum += log(((double)before[c * CELLS + cell] + 1e-3) / ((double)typical[cell] + 1e-3));
    assert_near((double)table[cell], sum / sqrt(3), 1e-5);
    nqm_sparse_unmap(&grid, typical, table);
    for (size_t i = 0; i < 3 * CELLS; ++i)
        assert_near((double)table[i], (double)before[i], 1e-6 + 1e-5 * (double)before[i]);
    nqm_free(grid.hd);
    nqm_brdf_free(brdf);
}

TEST(bases_keep_lengths) {
    static double core[CORE], again[CORE];
    static float channel[CELLS];
    nqm_sparse_dictionary *dictionary = builtin();
    nqm_rng rng = nqm_rng_make(1, 0);
    double inside = 0, outside = 0;
    for (size_t i = 0; i < CORE; ++i) {
        core[i] = nqm_rng_normal(&rng);
        inside += core[i] * core[i];
    }
    nqm_sparse_synthesise(&dictionary->bases, core, channel);
    nqm_sparse_analyse(&dictionary->bases, channel, again);
    for (size_t i = 0; i < CELLS; ++i)
        outside += (double)channel[i] * (double)channel[i];
    assert_relative(outside, inside, 1e-5);
    for (size_t i = 0; i < CORE; ++i)
        assert_near(again[i], core[i], 1e-5);
    nqm_free(dictionary);
}

/* A BRDF whose mapped table is the sum of three atoms where light and viewer are above the horizon. */
static nqm_brdf *in_span(const nqm_sparse_dictionary *dictionary, double factor) {
    static double core[3 * CORE];
    static float table[3 * CELLS], rgb[3 * CELLS];
    static const struct {
        size_t channel, atom;
        double coefficient;
    } parts[] = {{0, 3, 20}, {0, 17, -12}, {1, 5, 9}};
    nqm_sparse_grid grid;
    memset(core, 0, sizeof core);
    for (size_t k = 0; k < 3; ++k)
        for (size_t i = 0; i < CORE; ++i)
            core[parts[k].channel * CORE + i] +=
                factor * parts[k].coefficient * (double)dictionary->atoms[parts[k].atom * CORE + i];
    for (size_t c = 0; c < 3; ++c)
        nqm_sparse_synthesise(&dictionary->bases, core + c * CORE, table + c * CELLS);
    assert_int_equal(nqm_sparse_grid_make(&grid, NULL), NQM_OK);
    nqm_sparse_unmap(&grid, dictionary->typical, table);
    for (size_t i = 0; i < 3 * CELLS; ++i)
        rgb[i] = NAN;
    for (size_t i = 0; i < grid.n; ++i)
        for (size_t c = 0; c < 3; ++c)
            rgb[3 * grid.cell[i] + c] = (float)((double)table[c * CELLS + grid.cell[i]] / grid.cosine[i]);
    nqm_brdf *brdf;
    assert_int_equal(
        nqm_table_create((nqm_table_size){NQM_SPARSE_H, NQM_SPARSE_D, NQM_SPARSE_P, 1}, rgb, "span", &brdf, NULL),
        NQM_OK);
    nqm_free(grid.hd);
    return brdf;
}

static double loss_of(const nqm_sparse_dictionary *dictionary, const nqm_brdf *ref, size_t n_atoms) {
    nqm_encode_report report = {0};
    nqm_brdf *brdf;
    nqm_error err = {0};
    if (nqm_sparse_encode(dictionary, ref, &(nqm_encode_options){.n = n_atoms}, &report, &brdf, &err) != NQM_OK)
        fail_msg("%s", err.message);
    assert_true(report.n_numbers <= 2 * n_atoms && report.n_directions > 1000);
    nqm_brdf_free(brdf);
    return report.loss;
}

TEST(what_lies_in_the_span_is_coded_exactly) {
    nqm_sparse_dictionary *dictionary = builtin();
    nqm_brdf *brdf = in_span(dictionary, 1), *nothing = in_span(dictionary, 0);
    double few = loss_of(dictionary, brdf, 2), exact = loss_of(dictionary, brdf, 24);
    assert_true(exact < 3e-4 && few > 20 * exact);
    assert_true(loss_of(dictionary, nothing, 1) < 1e-6); /* the typical material needs no atoms */
    nqm_brdf_free(brdf);
    nqm_brdf_free(nothing);
    nqm_free(dictionary);
}

TEST(more_atoms_come_nearer) {
    static const char *const presets[] = {"sgd:nickel", "sgd:green-plastic", "ward:pink-felt",
                                          "ggx:kd=.1;ks=.2;alpha=.2"};
    for (size_t i = 0; i < sizeof presets / sizeof *presets; ++i) {
        static const char *const models[] = {"sparse-low", "sparse-mid", "sparse-high"};
        nqm_brdf *ref = must_open(presets[i]);
        nqm_fit_report report[3];
        for (size_t m = 0; m < 3; ++m) {
            nqm_error err = {0};
            nqm_brdf *brdf;
            if (nqm_fit(ref, models[m], NULL, &report[m], &brdf, &err) != NQM_OK)
                fail_msg("%s", err.message);
            assert_string_equal(nqm_brdf_get_info(brdf).format, "table");
            assert_string_equal(report[m].spec, "");
            nqm_brdf_free(brdf);
        }
        if (!(report[0].loss > report[1].loss && report[1].loss > report[2].loss && report[2].loss < 0.03))
            fail_msg("%s: %g, %g, %g", presets[i], report[0].loss, report[1].loss, report[2].loss);
        assert_int_equal(report[0].n_numbers, 8);
        assert_int_equal(report[2].n_numbers, 64);
        nqm_brdf_free(ref);
    }
}

/* Rounding can improve a single material, so the levels are compared by the geometric means of their losses. Levels 1 and
 * 2 differ too little for a few materials. */
TEST(level_0_is_the_finest) {
    static const char *const presets[] = {"sgd:nickel",        "sgd:teflon",     "sgd:pink-fabric",
                                          "sgd:yellow-paint",  "ward:pink-felt", "sgd:maroon-plastic",
                                          "sgd:green-plastic", "sgd:red-plastic"};
    static const char *const models[] = {"sparse-0", "sparse-1", "sparse-2"};
    enum { N_PRESETS = sizeof presets / sizeof *presets };
    double loss[3] = {0};
    for (size_t i = 0; i < N_PRESETS; ++i) {
        nqm_brdf *ref = must_open(presets[i]);
        for (size_t m = 0; m < 3; ++m) {
            nqm_fit_report report;
            assert_int_equal(nqm_fit(ref, models[m], NULL, &report, NULL, NULL), NQM_OK);
            assert_int_equal(report.n_numbers, 6);
            loss[m] += log(report.loss) / N_PRESETS;
        }
        nqm_brdf_free(ref);
    }
    if (!(loss[0] < loss[1] - 0.05 && loss[0] < loss[2] - 0.05))
        fail_msg("mean losses %g, %g, %g", exp(loss[0]), exp(loss[1]), exp(loss[2]));
}

/* ---- cells without a value --------------------------------------------------------------------------------------- */

/* A grey BRDF without values for theta_d > `self` and for 0.1 < theta_h < 0.2, in radians. */
static void holes_eval(const void *self, size_t n, const double *hd, double *rgb) {
    double limit = *(const double *)self;
    for (size_t i = 0; i < n; ++i) {
        bool hole = hd[3 * i + 1] > limit || (hd[3 * i] > 0.1 && hd[3 * i] < 0.2);
        for (size_t c = 0; c < 3; ++c)
            rgb[3 * i + c] = hole ? (double)NAN : 0.1;
    }
}

static nqm_brdf *with_holes(const double *limit) {
    static const nqm_brdf_class class_ = {.format = "holes", .eval_half_diff = holes_eval, .free = free_nothing};
    nqm_brdf *brdf;
    assert_int_equal(
        nqm_brdf_wrap(&class_, (void *)(uintptr_t)limit, &(nqm_brdf_info){.name = "holes.bsdf"}, &brdf, NULL), NQM_OK);
    return brdf;
}

TEST(holes_are_filled) {
    static const double limit = 1.2, tiny = -1;
    nqm_sparse_dictionary *dictionary = builtin();
    nqm_brdf *brdf = with_holes(&limit), *empty = with_holes(&tiny), *coded;
    nqm_encode_report report;
    nqm_error err = {0};
    assert_int_equal(nqm_sparse_encode(dictionary, brdf, &(nqm_encode_options){.n = 32}, &report, &coded, NULL),
                     NQM_OK);
    assert_true(report.loss < 0.01);
    static const double hd[][3] = {
        {0.05, 0.3, 1}, {0.5, 0.7, 2}, {0.15, 0.3, 1}, {0.05, 1.3, 1}}; /* 2 and 3 have no value */
    double rgb[3 * 4];
    nqm_brdf_eval_half_diff(coded, 4, hd[0], rgb, NULL);
    for (size_t i = 0; i < 3 * 4; ++i)
        assert_relative(rgb[i], 0.1, i < 6 ? 0.1 : 0.5);
    nqm_brdf_free(coded);
    assert_int_equal(nqm_sparse_encode(dictionary, empty, &(nqm_encode_options){.n = 32}, &report, &coded, &err),
                     NQM_ERR_INCOMPATIBLE);
    assert_non_null(strstr(err.message, "holes.bsdf"));
    assert_null(coded);
    nqm_brdf_free(brdf);
    nqm_brdf_free(empty);
    nqm_free(dictionary);
}

TEST(memory_runs_out) {
    nqm_brdf *ref = must_open("lambert:kd=0.3"), *brdf = NULL;
    nqm_status status = NQM_OK;
    long n = -1;
    EVERY_ALLOCATION(n, status, 0) {
        nqm_fit_report report;
        status = nqm_fit(ref, "sparse-low", NULL, &report, &brdf, NULL);
        assert_true((status == NQM_OK) == (brdf != NULL));
    }
    assert_int_equal(n, 7 + NQM_BIG_ENDIAN); /* values of other byte order are copied */
    nqm_brdf_free(brdf);
    nqm_brdf_free(ref);
}

/* ---- files that are no dictionaries ------------------------------------------------------------------------------ */

/* Parse a dictionary of two atoms of norm `scale`, without tensor `left_out` and with tensor `misshapen` reshaped. */
static nqm_status parse_spoiled(double scale, float typical, size_t left_out, size_t misshapen, nqm_error *err) {
    static float zeros[NQM_SPARSE_CELLS], ref[NQM_SPARSE_CELLS], atoms[2 * CORE];
    const size_t shapes[5][2] = {{NQM_SPARSE_H, NQM_SPARSE_D * NQM_SPARSE_P},
                                 {NQM_SPARSE_BASIS_H, NQM_SPARSE_H},
                                 {NQM_SPARSE_BASIS_D, NQM_SPARSE_D},
                                 {NQM_SPARSE_BASIS_P, NQM_SPARSE_P},
                                 {2, CORE}};
    static const char *const tensor_names[5] = {"typical", "basis.theta_h", "basis.theta_d", "basis.phi_d", "atoms"};
    const float *const data[5] = {ref, zeros, zeros, zeros, atoms};
    nqm_tensor tensors[5];
    size_t n = 0;
    ref[5] = typical;
    atoms[1] = atoms[CORE + 7] = (float)scale;
    for (size_t i = 0; i < 5; ++i) {
        size_t rows = shapes[i][0], cols = shapes[i][1] - (i == misshapen);
        if (i != left_out)
            tensors[n++] = (nqm_tensor){.name = tensor_names[i],
                                        .dtype = NQM_F32,
                                        .n_dims = 2,
                                        .dims = {rows, cols},
                                        .n_bytes = rows * cols * sizeof(float),
                                        .data = data[i]};
    }
    write_encoder(scratch_path("encoder"), "sparse", n, tensors);
    nqm_map map;
    nqm_sparse_dictionary *dictionary;
    assert_int_equal(nqm_map_open(scratch_path("encoder"), &map, NULL), NQM_OK);
    nqm_status status = nqm_sparse_dictionary_parse(map.data, map.n_bytes, "spoiled", &dictionary, err);
    assert_true((status == NQM_OK) == (dictionary != NULL));
    nqm_free(dictionary);
    nqm_map_close(&map);
    return status;
}

TEST(broken_dictionaries_are_refused) {
    enum { NONE = 9 };
    nqm_error err = {0};
    assert_int_equal(parse_spoiled(1, 0, NONE, NONE, &err), NQM_OK);
    for (size_t i = 0; i < 5; ++i) {
        assert_int_equal(parse_spoiled(1, 0, i, NONE, &err), NQM_ERR_MODEL);
        assert_non_null(strstr(err.message, "missing"));
        assert_int_equal(parse_spoiled(1, 0, NONE, i, &err), NQM_ERR_MODEL);
        assert_non_null(strstr(err.message, "shape"));
    }
    assert_int_equal(parse_spoiled(1.1, 0, NONE, NONE, &err), NQM_ERR_MODEL);
    assert_non_null(strstr(err.message, "length"));
    assert_int_equal(parse_spoiled(1, -0.1f, NONE, NONE, &err), NQM_ERR_MODEL);
    assert_non_null(strstr(err.message, "negative"));
}
