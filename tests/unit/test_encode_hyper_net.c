/* SPDX-License-Identifier: MIT
 *
 * The hypernetwork as a function: its gradient equals finite differences, the order of the samples does not matter, the
 * sets of a batch are independent; and its file is read back, or refused.
 */
#include "brdf/brdf.h"
#include "encode/hyper.h"
#include "support/check.h"
#include "support/temp_file.h"

#include <math.h>
#include <string.h>

enum { N_SETS = 3, N_SAMPLES = 5, N_OUT = 4 };
static const nqm_hyper_shape small = {{7, 6, 5, 6, 5, N_OUT}};
static const nqm_hyper_shape narrow = {{2, 2, 2, 2, 2, NQM_NBRDF_WEIGHTS}};

static void fill_random(nqm_rng *rng, size_t n, float *x) {
    for (size_t i = 0; i < n; ++i)
        x[i] = (float)nqm_rng_normal(rng);
}

/* A small network and a batch of inputs. */
typedef struct bench {
    nqm_hyper hyper, gradient;
    nqm_hyper_pass pass;
    float d_out[N_SETS * N_OUT];
} bench;

static void setup(bench *b) {
    nqm_rng rng = nqm_rng_make(3, 0);
    float mean[N_OUT];
    fill_random(&rng, N_OUT, mean);
    assert_int_equal(nqm_hyper_create(&small, &b->hyper, NULL), NQM_OK);
    assert_int_equal(nqm_hyper_create(&small, &b->gradient, NULL), NQM_OK);
    assert_int_equal(nqm_hyper_pass_create(&b->hyper, N_SETS, N_SAMPLES, &b->pass, NULL), NQM_OK);
    nqm_hyper_init(&b->hyper, mean, 1);
    fill_random(&rng, N_SETS * N_SAMPLES * NQM_HYPER_FEATURES, b->pass.input);
    fill_random(&rng, N_SETS * N_OUT, b->d_out);
}

static void teardown(bench *b) {
    nqm_free(b->hyper.block);
    nqm_free(b->gradient.block);
    nqm_hyper_pass_free(&b->pass);
}

/* The loss whose gradient with respect to the output is d_out. */
static double loss_of(bench *b) {
    const float *out = nqm_hyper_forward(&b->hyper, &b->pass);
    double loss = 0;
    for (size_t i = 0; i < b->pass.n_sets * N_OUT; ++i)
        loss += (double)b->d_out[i] * (double)out[i];
    return loss;
}

TEST(gradient_is_that_of_differences) {
    bench b;
    setup(&b);
    loss_of(&b);
    nqm_hyper_backward(&b.hyper, &b.pass, b.d_out, &b.gradient);
    const float step = 1e-2f;
    double largest = 0;
    for (size_t i = 0; i < b.hyper.n; ++i) {
        float x = b.hyper.block[i];
        b.hyper.block[i] = x + step;
        double above = loss_of(&b);
        b.hyper.block[i] = x - step;
        double slope = (above - loss_of(&b)) / (2 * (double)step);
        b.hyper.block[i] = x;
        if (!(fabs(slope - (double)b.gradient.block[i]) <= 2e-3 + 5e-3 * fabs(slope)))
            fail_msg("number %zu of %zu: slope %g, gradient %g", i, b.hyper.n, slope, (double)b.gradient.block[i]);
        largest = fmax(largest, fabs(slope));
    }
    assert_true(largest > 0.5); /* gradients are much larger than the tolerance */
    teardown(&b);
}

TEST(order_of_samples_does_not_matter) {
    bench b;
    setup(&b);
    float before[N_OUT], row[NQM_HYPER_FEATURES];
    memcpy(before, nqm_hyper_forward(&b.hyper, &b.pass), sizeof before);
    float *first = b.pass.input, *last = first + (N_SAMPLES - 1) * NQM_HYPER_FEATURES;
    memcpy(row, first, sizeof row);
    memcpy(first, last, sizeof row);
    memcpy(last, row, sizeof row);
    const float *after = nqm_hyper_forward(&b.hyper, &b.pass);
    const size_t n = b.hyper.layer[NQM_HYPER_POOLED - 1].n_out;
    for (size_t j = 0; j < n; ++j) { /* the maximum over the samples is passed on */
        float most = -INFINITY;
        for (size_t i = 0; i < N_SAMPLES; ++i)
            most = fmaxf(most, b.pass.y[NQM_HYPER_POOLED - 1][i * n + j]);
        assert_near((double)b.pass.pooled[n + j], (double)most, 1e-3);
    }
    for (size_t i = 0; i < N_OUT; ++i)
        assert_near((double)after[i], (double)before[i], 1e-6);
    first[0] += 1; /* a changed sample changes the output */
    after = nqm_hyper_forward(&b.hyper, &b.pass);
    assert_true(fabsf(after[0] - before[0]) > 1e-4f);
    teardown(&b);
}

TEST(sets_are_independent) {
    bench b;
    setup(&b);
    float before[N_OUT];
    memcpy(before, nqm_hyper_forward(&b.hyper, &b.pass), sizeof before);
    b.pass.n_sets = 1;
    const float *alone = nqm_hyper_forward(&b.hyper, &b.pass);
    for (size_t i = 0; i < N_OUT; ++i)
        assert_near((double)alone[i], (double)before[i], 1e-6);
    teardown(&b);
}

/* ---- its file ---------------------------------------------------------------------------------------------------- */

static const char *const names[] = {"sgd:nickel"};

static void write_network(const nqm_hyper_shape *shape, nqm_hyper *hyper) {
    nqm_learn_options options = nqm_learn_options_default();
    float mean[NQM_NBRDF_WEIGHTS] = {0};
    assert_int_equal(nqm_hyper_create(shape, hyper, NULL), NQM_OK);
    nqm_hyper_init(hyper, mean, 5);
    assert_int_equal(nqm_hyper_write(hyper, 1, names, &options, temp_file, NULL), NQM_OK);
}

static nqm_status read_network(nqm_hyper *hyper, nqm_error *err) {
    nqm_map map;
    assert_int_equal(nqm_map_open(temp_file, &map, NULL), NQM_OK);
    nqm_status status = nqm_hyper_read(map.data, map.n_bytes, temp_file, hyper, err);
    nqm_map_close(&map);
    return status;
}

TEST(a_file_is_read_back) {
    nqm_hyper written, found;
    write_network(&narrow, &written);
    assert_int_equal(read_network(&found, NULL), NQM_OK);
    assert_int_equal(found.n, written.n);
    assert_memory_equal(found.block, written.block, found.n * sizeof *found.block);
    nqm_free(written.block);
    nqm_free(found.block);
}

TEST(other_networks_are_refused) {
    nqm_hyper written, found;
    nqm_error err = {0};
    write_network(&small, &written); /* its output is not an NBRDF */
    assert_int_equal(read_network(&found, &err), NQM_ERR_MODEL);
    assert_non_null(strstr(err.message, "layers.5.weight"));
    assert_null(found.block);
    nqm_free(written.block);

    const nqm_learn_options options = nqm_learn_options_default();
    const float value = 0;
    const nqm_tensor tensor = {
        .name = "atoms", .dtype = NQM_F32, .n_dims = 1, .dims = {1}, .n_bytes = sizeof value, .data = &value};
    assert_int_equal(nqm_encoder_write(temp_file, &(nqm_encoder_source){"hyper", 1, names, &options}, 1, &tensor, NULL),
                     NQM_OK);
    assert_int_equal(read_network(&found, &err), NQM_ERR_MODEL);
    assert_non_null(strstr(err.message, "layers.0.weight"));
    assert_int_equal(
        nqm_encoder_write(temp_file, &(nqm_encoder_source){"sparse", 1, names, &options}, 1, &tensor, NULL), NQM_OK);
    assert_int_equal(read_network(&found, &err), NQM_ERR_MODEL);
    assert_non_null(strstr(err.message, "hyper"));
}

TEST_FILE(make_temp_file, remove_temp_file)
