/* SPDX-License-Identifier: MIT
 *
 * Rows through a packed network. All threads work on one layer at a time: its blocks of rows and panels are dealt out by
 * the shape only, then its rows. "Dealt out" means loops that share the iterations among the threads of the region that
 * they are called from, and wait for each other at their end.
 */
#include "net/inference.h"
#include "net/inference_net.h"

#include <string.h>

enum {
    MIN_PARALLEL = 1 << 18, /* multiplications; below, waking a thread costs more than it saves */
    MIN_ROWS = 16,          /* the same for rows that are compared and rounded */
    BLOCK_ROWS = 11 * NQM_STRIP
};

struct nqm_inference_work {
    const nqm_inference_net *net;
    size_t max_batch, n_multiplications;       /* the latter of a row */
    size_t stride, rounded_stride, ref_stride; /* numbers from row to row */
    float *y[2];                               /* (max_batch, stride) of the layers in turn */
    uint32_t *rounded;                         /* (max_batch, rounded_stride) a layer's inputs as units */
    float *scale;                              /* (NQM_MAX_SEGMENTS, max_batch) of bytes */
    /* References of this call: row i belongs to reference ref_of[i]; reference 0 is the last one of the call before. */
    size_t n_refs;              /* without that one */
    size_t *ref_of;             /* (max_batch) */
    uint8_t *begins;            /* (max_batch) whether a row's reference is another than that of the row before */
    uint32_t *ref;              /* (max_batch, ref_stride) inputs of references 1.. as units */
    float *ref_scale;           /* (max_batch) */
    float *part;                /* (1 + max_batch, stride) what references add to the first layer */
    float *kept;                /* (inputs of a reference) those of reference 0 */
    const nqm_kernels *kept_by; /* that computed its part; NULL: there is none */
};

/* ---- memory ------------------------------------------------------------------------------------------------------ */

static size_t larger(size_t a, size_t b) {
    return a > b ? a : b;
}

static size_t smaller(size_t a, size_t b) {
    return a < b ? a : b;
}

static void measure(nqm_inference_work *work) {
    const nqm_inference_net *net = work->net;
    size_t widest = 0, rounded = 0;
    for (size_t l = 0; l < net->n_layers; ++l) {
        const nqm_inference_layer *layer = &net->layer[l];
        widest = larger(widest, layer->n_out);
        rounded = larger(rounded, layer->rounded);
        for (size_t s = 0; s < layer->n_segments; ++s) {
            work->n_multiplications += layer->segment[s].panel.k * layer->n_out;
        }
    }
    work->stride = nqm_row_stride(widest);
    work->rounded_stride = rounded ? nqm_row_stride(rounded) : 0;
    work->ref_stride = nqm_row_stride(net->layer[0].segment[0].panel.units);
}

nqm_status nqm_inference_work_create(const nqm_inference_net *net, size_t max_batch, nqm_inference_work **work_ret,
                                     nqm_error *err) {
    *work_ret = NULL;
    if (max_batch < 1 || max_batch > (size_t)1 << 24)
        return nqm_fail(err, NQM_ERR_ARG, -1, "network: batch of %zu is out of range (1..16777216)", max_batch);
    nqm_inference_work *w = nqm_alloc(1, sizeof *w);
    if (!w)
        return nqm_fail_nomem(err, sizeof *w);
    w->net = net;
    w->max_batch = max_batch;
    measure(w);
    w->y[0] = nqm_alloc(max_batch, w->stride * sizeof(float));
    w->y[1] = nqm_alloc(max_batch, w->stride * sizeof(float));
    w->rounded = nqm_alloc(max_batch, w->rounded_stride * sizeof *w->rounded);
    w->scale = nqm_alloc(max_batch, NQM_MAX_SEGMENTS * sizeof *w->scale);
    w->ref_of = nqm_alloc(max_batch, sizeof *w->ref_of);
    w->begins = nqm_alloc(max_batch, sizeof *w->begins);
    w->ref = nqm_alloc(max_batch, w->ref_stride * sizeof *w->ref);
    w->ref_scale = nqm_alloc(max_batch, sizeof *w->ref_scale);
    w->part = nqm_alloc(max_batch + 1, w->stride * sizeof *w->part);
    w->kept = nqm_alloc(net->layer[0].segment[0].panel.k, sizeof *w->kept);
    if (w->y[0] && w->y[1] && w->rounded && w->scale && w->ref_of && w->begins && w->ref && w->ref_scale && w->part &&
        w->kept) {
        *work_ret = w;
        return NQM_OK;
    }
    const size_t per_row = (3 * w->stride + w->rounded_stride + w->ref_stride) * sizeof(float);
    nqm_inference_work_free(w);
    return nqm_fail_nomem(err, max_batch * per_row);
}

void nqm_inference_work_free(nqm_inference_work *work) {
    if (!work)
        return;
    void *blocks[] = {work->y[0],   work->y[1], work->rounded,   work->scale, work->ref_of,
                      work->begins, work->ref,  work->ref_scale, work->part,  work->kept};
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; ++i)
        nqm_free(blocks[i]);
    nqm_free(work);
}

/* ---- rows of factors --------------------------------------------------------------------------------------------- */

/* Factors of a product: rows of units, and for bytes what they stand for. */
typedef struct factors {
    const uint32_t *units;
    size_t ld;
    const float *scale;
} factors;

static void round_units(const nqm_panels *panel, const float *x, uint32_t *units, float *scale) {
    if (panel->precision == NQM_PRECISION_F32)
        memcpy(units, x, panel->k * sizeof *x);
    else if (panel->precision == NQM_PRECISION_BF16)
        nqm_round_row(panel->k, x, units);
    else
        *scale = nqm_quantise_row(panel->k, x, units);
}

/* Row i of a layer's inputs as the segments from the first-th on want it, where they do not want floats. */
static void round_row(nqm_inference_work *work, const nqm_inference_layer *layer, size_t first, size_t i,
                      const float *x) {
    for (size_t s = first; s < layer->n_segments; ++s) {
        const nqm_segment *segment = &layer->segment[s];
        if (segment->panel.precision != NQM_PRECISION_F32)
            round_units(&segment->panel, x + segment->from, work->rounded + i * work->rounded_stride + segment->at,
                        &work->scale[s * work->max_batch + i]);
    }
}

static factors factors_of(const nqm_inference_work *work, const nqm_segment *segment, size_t s, const float *x,
                          size_t ldx) {
    if (segment->panel.precision == NQM_PRECISION_F32)
        return (factors){.units = (const uint32_t *)(const void *)(x + segment->from), .ld = ldx};
    return (factors){work->rounded + segment->at, work->rounded_stride, work->scale + s * work->max_batch};
}

/* ---- products ---------------------------------------------------------------------------------------------------- */

/* Which part of C: rows [row, row + m), the columns of a panel. */
typedef struct block {
    size_t row, m, panel;
} block;

static block block_at(size_t i, size_t n_rows) {
    const size_t n_row_blocks = (n_rows + BLOCK_ROWS - 1) / BLOCK_ROWS, row = i % n_row_blocks * BLOCK_ROWS;
    return (block){row, smaller(n_rows - row, BLOCK_ROWS), i / n_row_blocks};
}

static size_t count_blocks(size_t n_rows, const nqm_panels *panels) {
    return (n_rows + BLOCK_ROWS - 1) / BLOCK_ROWS * panels->n_panels;
}

/* A block of C, c (m, NQM_PANEL), becomes A B or C + A B. */
static void multiply_block(const nqm_kernels *kernels, const nqm_panels *b, factors a, block at, bool add, float *c,
                           size_t ldc) {
    _Alignas(64) int32_t sums[BLOCK_ROWS * NQM_PANEL];
    const bool bytes = b->precision == NQM_PRECISION_INT8;
    const nqm_product p = {.m = at.m,
                           .units = b->units,
                           .add = add && !bytes,
                           .a = a.units + at.row * a.ld,
                           .lda = a.ld,
                           .b = nqm_panel_at(b, at.panel),
                           .c = bytes ? (void *)sums : c,
                           .ldc = bytes ? NQM_PANEL : ldc};
    kernels->product[b->precision](&p);
    for (size_t i = 0; bytes && i < at.m; ++i)
        nqm_dequantise_panel(b, at.panel, a.scale[at.row + i], add, sums + i * NQM_PANEL, c + i * ldc);
}

/* What the references 1.. of this call add to the first layer; dealt out. */
static void multiply_references(nqm_inference_work *work, const nqm_kernels *kernels) {
    const nqm_panels *panel = &work->net->layer[0].segment[0].panel;
    const factors a = {work->ref, work->ref_stride, work->ref_scale};
#pragma omp for schedule(static)
    for (size_t i = 0; i < count_blocks(work->n_refs, panel); ++i) {
        const block at = block_at(i, work->n_refs);
        multiply_block(kernels, panel, a, at, false, work->part + (1 + at.row) * work->stride + at.panel * NQM_PANEL,
                       work->stride);
    }
}

/* y = the sum over the segments of a layer; the first one's share is ready in the first layer. Dealt out. */
static void multiply_layer(nqm_inference_work *work, const nqm_kernels *kernels, size_t l, size_t n, const float *x,
                           size_t ldx, float *y) {
    const nqm_inference_layer *layer = &work->net->layer[l];
#pragma omp for schedule(static)
    for (size_t i = 0; i < count_blocks(n, &layer->segment[0].panel); ++i) {
        const block at = block_at(i, n);
        float *c = y + at.row * work->stride + at.panel * NQM_PANEL;
        for (size_t r = 0; l == 0 && r < at.m; ++r)
            memcpy(c + r * work->stride, work->part + work->ref_of[at.row + r] * work->stride + at.panel * NQM_PANEL,
                   NQM_PANEL * sizeof *c);
        for (size_t s = l == 0; s < layer->n_segments; ++s) {
            const nqm_segment *segment = &layer->segment[s];
            multiply_block(kernels, &segment->panel, factors_of(work, segment, s, x, ldx), at, s > 0, c, work->stride);
        }
    }
}

/* ---- the first layer's references -------------------------------------------------------------------------------- */

static bool same_inputs(size_t n, const float *a, const float *b) {
    /* NOLINTNEXTLINE(bugprone-suspicious-memory-comparison): the same bits are meant */
    return memcmp(a, b, n * sizeof *a) == 0;
}

/* Find the references of this call and round the inputs of the first layer; dealt out. */
static void begin_rows(nqm_inference_work *work, const nqm_kernels *kernels, size_t n, const float *x, size_t ldx) {
    const nqm_inference_layer *layer = &work->net->layer[0];
    const nqm_panels *panel = &layer->segment[0].panel;
#pragma omp for schedule(static)
    for (size_t i = 0; i < n; ++i) {
        const float *before = i > 0 ? x + (i - 1) * ldx : work->kept_by == kernels ? work->kept : NULL;
        work->begins[i] = !before || !same_inputs(panel->k, before, x + i * ldx);
    }
#pragma omp single
    {
        work->n_refs = 0;
        for (size_t i = 0; i < n; ++i)
            work->ref_of[i] = work->n_refs += work->begins[i];
    }
#pragma omp for schedule(static)
    for (size_t i = 0; i < n; ++i) {
        const size_t at = work->ref_of[i] - 1;
        if (work->begins[i])
            round_units(panel, x + i * ldx, work->ref + at * work->ref_stride, &work->ref_scale[at]);
        round_row(work, layer, 1, i, x + i * ldx);
    }
}

/* The last reference becomes reference 0 of the next call. */
static void keep_reference(nqm_inference_work *work, const nqm_kernels *kernels, const float *last) {
    memcpy(work->kept, last, work->net->layer[0].segment[0].panel.k * sizeof *last);
    memcpy(work->part, work->part + work->n_refs * work->stride, work->stride * sizeof *work->part);
    work->kept_by = kernels;
}

/* ---- layers ------------------------------------------------------------------------------------------------------ */

/* From the products of layer l to the inputs of the next one; dealt out. */
static void finish_rows(nqm_inference_work *work, const nqm_kernels *kernels, size_t l, size_t n, float *y) {
    const nqm_inference_layer *layer = &work->net->layer[l];
#pragma omp for schedule(static)
    for (size_t i = 0; i < n; ++i) {
        float *row = y + i * work->stride;
        kernels->hidden_row(&(nqm_hidden_row){
            .n = layer->n_out, .bias = layer->bias, .gamma = layer->gamma, .beta = layer->beta, .x = row, .y = row});
        round_row(work, layer + 1, 0, i, row);
    }
}

void nqm_inference_run(nqm_inference_work *work, size_t n, const float *x, size_t ldx, float *z) {
    const nqm_inference_net *net = work->net;
    const nqm_kernels *kernels = nqm_kernels_get();
    const size_t last = net->n_layers - 1;
    if (n == 0)
        return;
#pragma omp parallel if (n >= MIN_ROWS && n * work->n_multiplications >= MIN_PARALLEL)
    begin_rows(work, kernels, n, x, ldx);
#pragma omp parallel if (n * work->n_multiplications >= MIN_PARALLEL)
    {
        multiply_references(work, kernels);
        for (size_t l = 0; l <= last; ++l) {
            const float *in = l == 0 ? x : work->y[(l - 1) % 2];
            multiply_layer(work, kernels, l, n, in, l == 0 ? ldx : work->stride, work->y[l % 2]);
            if (l < last)
                finish_rows(work, kernels, l, n, work->y[l % 2]);
        }
    }
    for (size_t i = 0; i < n; ++i)
        z[i] = work->y[last % 2][i * work->stride] + net->layer[last].bias[0];
    keep_reference(work, kernels, x + (n - 1) * ldx);
}
