/* SPDX-License-Identifier: MIT
 *
 * The forward matrix products of the networks, from packed panels as in training and scoring.
 */
#include "bench/bench.h"
#include "kernel/panel.h"

#include <string.h>

enum { BATCH = 512 };

/* Layer 1 of `paper`, and a layer that all networks have. */
static const struct {
    const char *model;
    size_t layer, in, out;
} layers[] = {{"paper", 1, 3000, 1024}, {"both", 2, 1024, 716}};

/* A product in a precision, C (BATCH, out) = A (BATCH, in) B (in, out), with its buffers. */
typedef struct job {
    float *c;
    nqm_panels panels; /* B */
    uint32_t *rows;    /* A as packed 32-bit words */
} job;

static void run_product(void *user) {
    job *j = user;
    const size_t stride = nqm_row_stride(j->panels.words), c_stride = nqm_row_stride(j->panels.n);
    nqm_multiply(&j->panels, BATCH, j->rows, stride, false, j->c, c_stride);
}

static void fill_random(size_t n, float *x, uint64_t seed) {
    nqm_rng rng = nqm_rng_make(seed, 0);
    for (size_t i = 0; i < n; ++i)
        x[i] = (float)(nqm_rng_uniform(&rng) - 0.5);
}

static void fill_rows(job *j, size_t in, const float *a) {
    for (size_t i = 0; i < BATCH; ++i) {
        uint32_t *row = j->rows + i * nqm_row_stride(j->panels.words);
        if (j->panels.precision == NQM_PRECISION_F32)
            memcpy(row, a + i * in, in * sizeof *a);
        else
            nqm_kernels_get()->round_row(in, a + i * in, row);
    }
}

/* Fill both factors with random values. */
static nqm_status fill(job *j, size_t in, size_t out, nqm_error *err) {
    nqm_panels floats;
    float *a, *b; /* b: the transpose of B */
    nqm_status status = nqm_panels_create(NQM_PRECISION_F32, in, out, &floats, err);
    if (status != NQM_OK)
        return status;
    status = nqm_alloc_arrays(NQM_ARRAYS({&a, BATCH * in, sizeof *a}, {&b, out * in, sizeof *b}), err);
    if (status == NQM_OK) {
        nqm_panels *to = j->panels.precision == NQM_PRECISION_F32 ? &j->panels : &floats;
        fill_random(BATCH * in, a, 1);
        fill_random(out * in, b, 2);
        fill_rows(j, in, a);
        nqm_panels_pack(to, (nqm_weights){b, NULL, in});
        if (to == &floats)
            nqm_panels_round(&floats, &j->panels);
        nqm_free(a);
    }
    nqm_panels_free(&floats);
    return status;
}

static nqm_status bench_product(nqm_bench *bench, size_t layer, nqm_precision precision, nqm_error *err) {
    const size_t in = layers[layer].in, out = layers[layer].out;
    job j = {.c = NULL};
    nqm_status status = nqm_panels_create(precision, in, out, &j.panels, err);
    if (status != NQM_OK)
        return status;
    status = nqm_alloc_arrays(NQM_ARRAYS({&j.c, BATCH * nqm_row_stride(out), sizeof *j.c},
                                         {&j.rows, BATCH * nqm_row_stride(j.panels.words), sizeof *j.rows}),
                              err);
    if (status == NQM_OK)
        status = fill(&j, in, out, err);
    if (status == NQM_OK) {
        nqm_bench_entry entry = nqm_bench_entry_make("gemm", "forward", run_product, &j);
        nqm_bench_text(&entry, "model", layers[layer].model);
        nqm_bench_count(&entry, "layer", layers[layer].layer);
        nqm_bench_count(&entry, "batch", BATCH);
        nqm_bench_count(&entry, "m", BATCH);
        nqm_bench_count(&entry, "n", out);
        nqm_bench_count(&entry, "k", in);
        nqm_bench_entry_work(bench, &entry, precision, 2.0 * BATCH * (double)in * (double)out);
        status = nqm_bench_race(bench, 1, &entry, err);
    }
    nqm_free(j.c);
    nqm_panels_free(&j.panels);
    return status;
}

nqm_status nqm_bench_gemm(nqm_bench *bench, nqm_error *err) {
    nqm_status status = NQM_OK;
    for (size_t layer = bench->options.quick ? 1 : 0; layer < sizeof layers / sizeof *layers; ++layer)
        for (nqm_precision p = NQM_PRECISION_F32; p <= NQM_PRECISION_BF16 && status == NQM_OK; ++p)
            if (nqm_bench_has_precision(bench, p))
                status = bench_product(bench, layer, p, err);
    return status;
}
