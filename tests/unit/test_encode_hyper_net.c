/* SPDX-License-Identifier: MIT
 *
 * The hypernetwork as a function: it equals the definition in double, the order of the samples does not matter; and its file is read
 * back, or refused.
 */
#include "brdf/brdf.h"
#include "encode/encode.h"
#include "support/check.h"
#include "support/encoder_files.h"
#include "support/scratch.h"

enum { N_SAMPLES = 5, N_OUT = 4, N_INPUT = N_SAMPLES * NQM_HYPER_FEATURES, WIDEST = 13 };
static const nqm_hyper_shape small = {{7, 6, 5, 6, 5, N_OUT}};
static const nqm_hyper_shape narrow = {{2, 2, 2, 2, 2, NQM_NBRDF_WEIGHTS}};

/* A small network and features of samples. */
typedef struct example {
    nqm_hyper hyper;
    float x[N_INPUT];
} example;

static example make_example(void) {
    example e = {.hyper = make_hyper(&small, 1)};
    nqm_rng rng = nqm_rng_make(3, 0);
    for (size_t i = 0; i < N_INPUT; ++i)
        e.x[i] = (float)nqm_rng_normal(&rng);
    for (size_t l = 0; l < NQM_HYPER_N_LAYERS; ++l)
        for (size_t i = 0; i < e.hyper.layer[l].n_out; ++i)
            e.hyper.layer[l].b[i] = (float)nqm_rng_normal(&rng);
    return e;
}

/* One row through a layer, by the definition. */
static void layer_of_double(const nqm_hyper_layer *layer, bool is_last, const double *x, double *y) {
    for (size_t j = 0; j < layer->n_out; ++j) {
        double z = (double)layer->b[j];
        for (size_t i = 0; i < layer->n_in; ++i)
            z += x[i] * (double)layer->w[i * layer->n_out + j];
        y[j] = is_last ? z : 0.5 * z * erfc(-z / sqrt(2));
    }
}

static void forward_of_double(const example *e, double step, double *out) {
    const nqm_hyper_layer *layer = e->hyper.layer;
    const size_t n = layer[NQM_HYPER_POOLED - 1].n_out;
    double row[NQM_HYPER_N_LAYERS + 1][WIDEST], pooled[WIDEST] = {0};
    for (size_t i = 0; i < N_SAMPLES; ++i) {
        for (size_t k = 0; k < NQM_HYPER_FEATURES; ++k)
            row[0][k] = (double)e->x[i * NQM_HYPER_FEATURES + k];
        for (size_t l = 0; l < NQM_HYPER_POOLED; ++l)
            layer_of_double(&layer[l], false, row[l], row[l + 1]);
        for (size_t j = 0; j < n; ++j) {
            const double y = row[NQM_HYPER_POOLED][j];
            pooled[j] += y / N_SAMPLES;
            pooled[n + j] = i == 0 ? y : fmax(pooled[n + j], y);
        }
    }
    for (size_t j = 0; step > 0 && j < 2 * n; ++j)
        pooled[j] = step * round(pooled[j] / step);
    pooled[2 * n] = log(N_SAMPLES / 200.0);
    memcpy(row[NQM_HYPER_POOLED], pooled, sizeof pooled);
    for (size_t l = NQM_HYPER_POOLED; l < NQM_HYPER_N_LAYERS; ++l)
        layer_of_double(&layer[l], l + 1 == NQM_HYPER_N_LAYERS, row[l], row[l + 1]);
    memcpy(out, row[NQM_HYPER_N_LAYERS], N_OUT * sizeof *out);
}

TEST(the_network_is_that_of_the_definition) {
    example e = make_example();
    float out[N_OUT];
    double expected[N_OUT];
    for (double step = 0; step < 0.5; step += 0.25) {
        assert_int_equal(nqm_hyper_forward(&e.hyper, N_SAMPLES, e.x, (float)step, out, NULL), NQM_OK);
        forward_of_double(&e, step, expected);
        for (size_t i = 0; i < N_OUT; ++i)
            assert_near((double)out[i], expected[i], 1e-5);
    }
    nqm_free(e.hyper.block);
}

TEST(order_of_samples_does_not_matter) {
    example e = make_example();
    float before[N_OUT], after[N_OUT], row[NQM_HYPER_FEATURES], *last = e.x + N_INPUT - NQM_HYPER_FEATURES;
    assert_int_equal(nqm_hyper_forward(&e.hyper, N_SAMPLES, e.x, 0, before, NULL), NQM_OK);
    memcpy(row, e.x, sizeof row);
    memcpy(e.x, last, sizeof row);
    memcpy(last, row, sizeof row);
    assert_int_equal(nqm_hyper_forward(&e.hyper, N_SAMPLES, e.x, 0, after, NULL), NQM_OK);
    for (size_t i = 0; i < N_OUT; ++i)
        assert_near((double)after[i], (double)before[i], 1e-6);
    e.x[0] += 1; /* a changed sample changes the output */
    assert_int_equal(nqm_hyper_forward(&e.hyper, N_SAMPLES, e.x, 0, after, NULL), NQM_OK);
    assert_true(fabsf(after[0] - before[0]) > 1e-4f);
    nqm_free(e.hyper.block);
}

/* ---- its file ---------------------------------------------------------------------------------------------------- */

static nqm_status read_network(nqm_hyper *hyper, nqm_error *err) {
    nqm_map map;
    assert_int_equal(nqm_map_open(scratch_path("encoder"), &map, NULL), NQM_OK);
    nqm_status status = nqm_hyper_read(map.data, map.n_bytes, scratch_path("encoder"), hyper, err);
    nqm_map_close(&map);
    return status;
}

TEST(a_file_is_read_back) {
    nqm_hyper written = make_hyper(&narrow, 5), found;
    write_hyper(scratch_path("encoder"), &written);
    assert_int_equal(read_network(&found, NULL), NQM_OK);
    assert_int_equal(found.n, written.n);
    assert_memory_equal(found.block, written.block, found.n * sizeof *found.block);
    nqm_free(written.block);
    nqm_free(found.block);
}

TEST(other_networks_are_refused) {
    nqm_hyper written = make_hyper(&small, 5), found;
    nqm_error err = {0};
    write_hyper(scratch_path("encoder"), &written); /* its output is not an NBRDF */
    assert_int_equal(read_network(&found, &err), NQM_ERR_MODEL);
    assert_non_null(strstr(err.message, "layers.5.weight"));
    assert_null(found.block);
    nqm_free(written.block);

    const float value = 0;
    const nqm_tensor tensor = {
        .name = "atoms", .dtype = NQM_F32, .n_dims = 1, .dims = {1}, .n_bytes = sizeof value, .data = &value};
    write_encoder(scratch_path("encoder"), "hyper", 1, &tensor);
    assert_int_equal(read_network(&found, &err), NQM_ERR_MODEL);
    assert_non_null(strstr(err.message, "layers.0.weight"));
    write_encoder(scratch_path("encoder"), "sparse", 1, &tensor);
    assert_int_equal(read_network(&found, &err), NQM_ERR_MODEL);
    assert_non_null(strstr(err.message, "hyper"));
}
