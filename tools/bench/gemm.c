/* SPDX-License-Identifier: MIT
 *
 * The matrix products of the networks: layers forward, the gradient of their input and of their weights, from packed
 * panels as in training and scoring, compared with oneDNN's.
 */
#include "bench/bench.h"
#include "kernel/panel.h"

#include <string.h>

/* Layer 1 of both networks, and the layers of equal size. The last layer has one output: no matrix product. */
static const struct {
    const char *model;
    size_t layer, in, out;
} layers[] = {{"paper", 1, 3000, 1024},
              {"default", 1, 4500 + NQM_SCALAR_COUNT, 1024},
              {"both", 2, 1024, 716},
              {"both", 3, 716, 501}};

typedef enum pass_kind { FORWARD, INPUT_GRADIENT, WEIGHT_GRADIENT, N_PASSES } pass_kind;
static const char *const pass_names[] = {"forward", "input gradient", "weight gradient"};

/* A product in a precision, C (m, n) = A (m, k) B (k, n), with its buffers. */
typedef struct job {
    nqm_precision precision;
    pass_kind pass;
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
    const bool gradient = j->pass == WEIGHT_GRADIENT;
    nqm_status status =
        nqm_panels_create(gradient ? NQM_PRECISION_F32 : j->precision, gradient ? j->m : j->k, j->n, &j->panels, err);
    if (status == NQM_OK)
        status = nqm_bench_onednn_create(j->precision, gradient, j->m, j->n, j->k, &j->onednn, err);
    if (status != NQM_OK)
        return status;
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

static nqm_status race_job(nqm_bench *bench, job *j, size_t layer, size_t batch, nqm_error *err) {
    nqm_bench_entry entries[2] = {nqm_bench_entry_make("gemm", pass_names[j->pass])};
    nqm_bench_text(&entries[0], "model", layers[layer].model);
    nqm_bench_count(&entries[0], "layer", layers[layer].layer);
    nqm_bench_count(&entries[0], "batch", batch);
    nqm_bench_count(&entries[0], "m", j->m);
    nqm_bench_count(&entries[0], "n", j->n);
    nqm_bench_count(&entries[0], "k", j->k);
    nqm_bench_entry_work(bench, &entries[0], j->precision, 2.0 * (double)j->m * (double)j->n * (double)j->k);
    if (batch == 1)
        nqm_bench_entry_reading(bench, &entries[0],
                                j->panels.n_panels * j->panels.stride * NQM_PANEL * sizeof(uint32_t));
    const nqm_bench_contender contenders[] = {{j->pass == WEIGHT_GRADIENT ? run_gradient : run_product, j},
                                              {nqm_bench_onednn_run, j->onednn}};
    if (j->onednn) {
        entries[1] = entries[0];
        entries[1].row = json_copy(entries[0].row);
        nqm_bench_text(&entries[1], "by", "onednn");
    }
    return nqm_bench_race(bench, j->onednn ? 2 : 1, contenders, entries, err);
}

static nqm_status bench_product(nqm_bench *bench, size_t layer, pass_kind pass, nqm_precision precision, size_t batch,
                                nqm_error *err) {
    const size_t in = layers[layer].in, out = layers[layer].out;
    job j = {.precision = precision, .pass = pass};
    j.m = pass == WEIGHT_GRADIENT ? in : batch;
    j.n = pass == INPUT_GRADIENT ? in : out;
    j.k = pass == FORWARD ? in : pass == INPUT_GRADIENT ? out : batch;
    nqm_status status = make_job(&j, err);
    if (status == NQM_OK)
        status = race_job(bench, &j, layer, batch, err);
    free_job(&j);
    return status;
}

/* Layer 1 needs no gradient of its input; batches other than 512 are for scoring, in float. */
static bool is_needed(const nqm_bench *bench, size_t layer, pass_kind pass, nqm_precision precision, size_t batch) {
    if (pass == INPUT_GRADIENT && layers[layer].layer == 1)
        return false;
    if (!nqm_bench_has_precision(bench, precision) || (bench->options.quick && layers[layer].layer != 3))
        return false;
    return batch == 512 || (pass == FORWARD && precision == NQM_PRECISION_F32);
}

nqm_status nqm_bench_gemm(nqm_bench *bench, nqm_error *err) {
    static const size_t batches[] = {512, 180, 1};
    nqm_status status = NQM_OK;
    for (size_t b = 0; b < 3; ++b)
        for (size_t layer = 0; layer < sizeof layers / sizeof *layers; ++layer)
            for (pass_kind pass = FORWARD; pass < N_PASSES; ++pass)
                for (nqm_precision p = NQM_PRECISION_F32; p <= NQM_PRECISION_BF16 && status == NQM_OK; ++p)
                    if (is_needed(bench, layer, pass, p, batches[b]))
                        status = bench_product(bench, layer, pass, p, batches[b], err);
    return status;
}
