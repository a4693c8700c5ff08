/* SPDX-License-Identifier: MIT
 *
 * The matrix products of the networks: layers forward, and the gradient of their weights, from packed panels as in
 * training and scoring, compared with oneDNN's.
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

/* A product in a precision, C (m, n) = A (m, k) B (k, n), with its buffers. */
typedef struct job {
    nqm_precision precision;
    bool is_gradient; /* of the weights */
    size_t m, n, k;
    float *x, *w, *c;     /* A or its transpose, which owns the block of all arrays; B or its transpose, row-major; C */
    nqm_panels panels;    /* B; the gradient */
    uint32_t *rows;       /* A as packed 32-bit words; for a weight gradient the columns of A */
    uint32_t *rows_right; /* weight gradient: the columns of B */
    nqm_bench_onednn *onednn;
} job;

/* ---- ours -------------------------------------------------------------------------------------------------------- */

static void run_product(void *user) {
    job *j = user;
    nqm_multiply(&j->panels, j->m, j->rows, nqm_row_stride(j->panels.words), false, j->c, nqm_row_stride(j->n));
}

static void keep_tiles(void *user, size_t strip, size_t n_strips, size_t panel, const float *tiles) {
    job *j = user;
    memcpy(nqm_panel_at(&j->panels, panel) + strip * NQM_STRIP * NQM_PANEL, tiles,
           n_strips * NQM_STRIP * NQM_PANEL * sizeof *tiles);
}

/* Words from one group of columns of a factor (k, n) of a weight gradient to the next. */
static size_t step_of(const job *j, size_t width) {
    return nqm_columns_step(j->precision, width, j->k);
}

static void run_gradient(void *user) {
    job *j = user;
    /* C (m, n) are weights (in, out); the sum runs over the batch. */
    nqm_gradient_run(&(nqm_gradient){.precision = j->precision,
                                     .m = j->k,
                                     .k = j->m,
                                     .n = j->n,
                                     .x = {j->rows, step_of(j, NQM_STRIP)},
                                     .z = {j->rows_right, step_of(j, NQM_PANEL)},
                                     .sink = keep_tiles,
                                     .user = j});
}

/* ---- creation and timing ---------------------------------------------------------------------------------------- */

static void fill_random(size_t n, float *x, uint64_t seed) {
    nqm_rng rng = nqm_rng_make(seed, 0);
    for (size_t i = 0; i < n; ++i)
        x[i] = (float)(nqm_rng_uniform(&rng) - 0.5);
}

static void fill_rows(job *j) {
    const size_t stride = nqm_row_stride(j->panels.words);
    for (size_t i = 0; i < j->m; ++i) {
        uint32_t *row = j->rows + i * stride;
        if (j->precision == NQM_PRECISION_F32)
            memcpy(row, j->x + i * j->k, j->k * sizeof *j->x);
        else
            nqm_kernels_get()->round_row(j->k, j->x + i * j->k, row);
    }
}

static void free_job(job *j) {
    nqm_free(j->x);
    nqm_panels_free(&j->panels);
    nqm_bench_onednn_free(j->onednn);
}

static void fill_columns(const job *j, size_t n, size_t width, const float *x, uint32_t *to) {
    const size_t step = step_of(j, width);
    for (size_t i = 0; i < j->k; i += 2)
        if (j->precision == NQM_PRECISION_BF16)
            nqm_kernels_get()->round_pair(n, x + i * n, x + (i + 1) * n, width, step, to + i / 2 * width);
        else {
            nqm_columns_copy(n, x + i * n, width, step, (float *)to + i * width);
            nqm_columns_copy(n, x + (i + 1) * n, width, step, (float *)to + (i + 1) * width);
        }
}

/* B in panels of floats, then in those of the job. */
static nqm_status pack_right(job *j, nqm_error *err) {
    nqm_panels floats;
    if (j->precision == NQM_PRECISION_F32) {
        nqm_panels_pack(&j->panels, (nqm_weights){j->w, NULL, j->k});
        return NQM_OK;
    }
    nqm_status status = nqm_panels_create(NQM_PRECISION_F32, j->k, j->n, &floats, err);
    if (status != NQM_OK)
        return status;
    nqm_panels_pack(&floats, (nqm_weights){j->w, NULL, j->k});
    nqm_panels_round(&floats, &j->panels);
    nqm_panels_free(&floats);
    return NQM_OK;
}

static nqm_status make_job(job *j, nqm_error *err) {
    const bool gradient = j->is_gradient;
    nqm_status status =
        nqm_panels_create(gradient ? NQM_PRECISION_F32 : j->precision, gradient ? j->m : j->k, j->n, &j->panels, err);
    if (status != NQM_OK)
        return status;
    j->onednn = nqm_bench_onednn_create(j->precision, gradient, j->m, j->n, j->k);
    const size_t n_rows =
        gradient ? nqm_ceil_div(j->m, NQM_STRIP) * step_of(j, NQM_STRIP) : j->m * nqm_row_stride(j->panels.words);
    const size_t n_right = gradient ? nqm_ceil_div(j->n, NQM_PANEL) * step_of(j, NQM_PANEL) : 0;
    status = nqm_alloc_arrays(NQM_ARRAYS({&j->x, j->m * j->k, sizeof *j->x}, {&j->w, j->n * j->k, sizeof *j->w},
                                         {&j->c, j->m * nqm_row_stride(j->n), sizeof *j->c},
                                         {&j->rows, n_rows, sizeof *j->rows},
                                         {&j->rows_right, n_right, sizeof *j->rows_right}),
                              err);
    if (status != NQM_OK)
        return status;
    fill_random(j->m * j->k, j->x, 1);
    fill_random(j->n * j->k, j->w, 2);
    if (gradient) {
        fill_columns(j, j->m, NQM_STRIP, j->x, j->rows);
        fill_columns(j, j->n, NQM_PANEL, j->w, j->rows_right);
    } else {
        status = pack_right(j, err);
        fill_rows(j);
    }
    return status;
}

static nqm_status race_job(nqm_bench *bench, job *j, size_t layer, nqm_error *err) {
    nqm_bench_entry entries[2] = {j->is_gradient ? nqm_bench_entry_make("gemm", "weight gradient", run_gradient, j)
                                                 : nqm_bench_entry_make("gemm", "forward", run_product, j)};
    nqm_bench_text(&entries[0], "model", layers[layer].model);
    nqm_bench_count(&entries[0], "layer", layers[layer].layer);
    nqm_bench_count(&entries[0], "batch", BATCH);
    nqm_bench_count(&entries[0], "m", j->m);
    nqm_bench_count(&entries[0], "n", j->n);
    nqm_bench_count(&entries[0], "k", j->k);
    nqm_bench_entry_work(bench, &entries[0], j->precision, 2.0 * (double)j->m * (double)j->n * (double)j->k);
    if (j->onednn) {
        entries[1] = entries[0];
        entries[1].run = nqm_bench_onednn_run;
        entries[1].user = j->onednn;
        entries[1].row = json_copy(entries[0].row);
        nqm_bench_text(&entries[1], "by", "onednn");
    }
    return nqm_bench_race(bench, j->onednn ? 2 : 1, entries, err);
}

static nqm_status bench_product(nqm_bench *bench, size_t layer, bool is_gradient, nqm_precision precision,
                                nqm_error *err) {
    const size_t in = layers[layer].in;
    job j = {.precision = precision, .is_gradient = is_gradient, .n = layers[layer].out};
    j.m = is_gradient ? in : BATCH;
    j.k = is_gradient ? BATCH : in;
    nqm_status status = make_job(&j, err);
    if (status == NQM_OK)
        status = race_job(bench, &j, layer, err);
    free_job(&j);
    return status;
}

nqm_status nqm_bench_gemm(nqm_bench *bench, nqm_error *err) {
    nqm_status status = NQM_OK;
    for (size_t layer = bench->options.quick ? 1 : 0; layer < sizeof layers / sizeof *layers; ++layer)
        for (int is_gradient = 0; is_gradient < 2; ++is_gradient)
            for (nqm_precision p = NQM_PRECISION_F32; p <= NQM_PRECISION_BF16 && status == NQM_OK; ++p)
                if (nqm_bench_has_precision(bench, p))
                    status = bench_product(bench, layer, is_gradient, p, err);
    return status;
}
