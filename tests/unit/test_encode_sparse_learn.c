/* SPDX-License-Identifier: MIT
 *
 * Learning a dictionary from four materials: it codes them well, the bytes are the same for one and two threads,
 * another seed gives another file, an interrupted run leaves no file; invalid dictionaries are refused.
 */
#include "brdf/brdf.h"
#include "encode/sparse.h"
#include "support/check.h"

#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { N = 4, CORE = NQM_SPARSE_CORE };
static const char *const names[N] = {"sgd:nickel", "sgd:green-plastic", "lambert:kd=0.4,0.2,0.1", "ward:pink-felt"};
static nqm_brdf *refs[N];
static char folder[] = "/tmp/nqm-sparse-XXXXXX";
static char path[64];

static nqm_status learn(uint64_t seed, int threads, nqm_progress_fn progress, nqm_error *err) {
    nqm_learn_options options = nqm_learn_options_default();
    options.seed = seed;
    options.n_steps = 3;
    options.progress = progress;
    int before = omp_get_max_threads();
    omp_set_num_threads(threads);
    nqm_status status = nqm_learn(NQM_ENCODER_SPARSE, N, (const nqm_brdf *const *)refs, names, &options, path, err);
    omp_set_num_threads(before);
    return status;
}

static nqm_map learned(uint64_t seed, int threads) {
    nqm_error err = {0};
    nqm_map map;
    if (learn(seed, threads, NULL, &err) != NQM_OK)
        fail_msg("%s", err.message);
    assert_int_equal(nqm_map_open(path, &map, NULL), NQM_OK);
    assert_int_equal(unlink(path), 0); /* the file stays mapped */
    return map;
}

static bool same(const nqm_map *a, const nqm_map *b) {
    return a->n_bytes == b->n_bytes && memcmp(a->data, b->data, a->n_bytes) == 0;
}

TEST(what_was_learned_is_coded_well) {
    nqm_map map = learned(1, 1);
    nqm_sparse_dictionary *dictionary;
    assert_int_equal(nqm_sparse_dictionary_parse(map.data, map.n_bytes, "four", &dictionary, NULL), NQM_OK);
    assert_true(dictionary->n_atoms > N && dictionary->n_atoms <= 3 * N);
    for (size_t i = 0; i < N; ++i) {
        nqm_encode_report report;
        nqm_brdf *brdf;
        assert_int_equal(nqm_sparse_encode(dictionary, refs[i], &(nqm_encode_options){.n = 8}, &report, &brdf, NULL),
                         NQM_OK);
        assert_true(report.loss < 0.01);
        nqm_brdf_free(brdf);
    }
    nqm_free(dictionary);
    nqm_map_close(&map);
}

TEST(a_seed_is_a_file) {
    nqm_map one = learned(1, 1), two = learned(1, 2), other = learned(2, 1);
    assert_true(same(&one, &two));
    assert_false(same(&one, &other));
    nqm_map_close(&one);
    nqm_map_close(&two);
    nqm_map_close(&other);
}

static int stop(void *user, const char *stage, double done, double total) {
    (void)user;
    (void)total;
    return strcmp(stage, "dictionary") == 0 && done >= 3;
}

TEST(a_stopped_run_leaves_nothing) {
    assert_int_equal(learn(1, 1, stop, NULL), NQM_ERR_CANCELLED);
    assert_int_equal(access(path, F_OK), -1);
}

TEST(grey_alone_is_nothing_to_learn) {
    nqm_error err = {0};
    nqm_brdf *grey = must_open("lambert:kd=0.4");
    assert_int_equal(nqm_learn(NQM_ENCODER_SPARSE, 1, (const nqm_brdf *const *)&grey, names, NULL, path, &err),
                     NQM_ERR_INCOMPATIBLE);
    assert_non_null(strstr(err.message, "all equal"));
    assert_int_equal(nqm_learn(NQM_ENCODER_SPARSE, 0, NULL, NULL, NULL, path, &err), NQM_ERR_ARG);
    nqm_brdf_free(grey);
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
    nqm_learn_options options = nqm_learn_options_default();
    assert_int_equal(nqm_encoder_write(path, &(nqm_encoder_source){"sparse", N, names, &options}, n, tensors, NULL),
                     NQM_OK);
    nqm_map map;
    nqm_sparse_dictionary *dictionary;
    assert_int_equal(nqm_map_open(path, &map, NULL), NQM_OK);
    nqm_status status = nqm_sparse_dictionary_parse(map.data, map.n_bytes, "spoiled", &dictionary, err);
    assert_true((status == NQM_OK) == (dictionary != NULL));
    nqm_free(dictionary);
    nqm_map_close(&map);
    assert_int_equal(unlink(path), 0);
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

static int open_all(void **state) {
    (void)state;
    if (!mkdtemp(folder))
        return -1;
    snprintf(path, sizeof path, "%s/sparse.safetensors", folder);
    for (size_t i = 0; i < N; ++i)
        refs[i] = must_open(names[i]);
    return 0;
}

/* The folder must be empty, because tests and interrupted runs must remove their files. */
static int close_all(void **state) {
    (void)state;
    for (size_t i = 0; i < N; ++i)
        nqm_brdf_free(refs[i]);
    return rmdir(folder);
}

TEST_FILE(open_all, close_all)
