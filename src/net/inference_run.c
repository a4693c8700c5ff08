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

    BLOCK_ROWS = 16 * NQM_STRIP,
    ROW_PANELS = 4
};

struct nqm_inference_work {
    const nqm_inference_net *net;
    bool packed;                               /* the panels of floats are filled; of this call */
    size_t max_batch, n_multiplications;       /* the latter of a row */
    size_t stride, rounded_stride, ref_stride; /* numbers from row to row */
    float *y[2];                               /* (max_batch, stride) of the layers in turn */
    uint32_t *rounded;                         /* (max_batch, rounded_stride) a layer's inputs as units */
    nqm_byte_scale *scale;                     /* (NQM_MAX_SEGMENTS, max_batch) what bytes stand for */
    float *difference;                         /* (max_batch, inputs of a reference) where the first layer wants it */
    /* References of this call: row i belongs to reference ref_of[i]; reference 0 is the last one of the call before. */
    size_t n_refs;              /* without that one */
    size_t *ref_of;             /* (max_batch) */
    uint8_t *begins;            /* (max_batch) whether a row's reference is another than that of the row before */
    uint32_t *ref;              /* (max_batch, ref_stride) inputs of references 1.. as units */
    nqm_byte_scale *ref_scale;  /* (max_batch) */
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
    const bool differences = net->layer[0].differences;
    w->difference = nqm_alloc(differences ? max_batch : 0, net->layer[0].segment[0].panel.k * sizeof *w->difference);
    w->ref_of = nqm_alloc(max_batch, sizeof *w->ref_of);
    w->begins = nqm_alloc(max_batch, sizeof *w->begins);
    w->ref = nqm_alloc(max_batch, w->ref_stride * sizeof *w->ref);
    w->ref_scale = nqm_alloc(max_batch, sizeof *w->ref_scale);
    w->part = nqm_alloc(max_batch + 1, w->stride * sizeof *w->part);
    w->kept = nqm_alloc(net->layer[0].segment[0].panel.k, sizeof *w->kept);
    if (w->y[0] && w->y[1] && w->rounded && w->scale && w->difference && w->ref_of && w->begins && w->ref &&
        w->ref_scale && w->part && w->kept) {
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
    void *blocks[] = {work->y[0],   work->y[1], work->rounded,   work->scale, work->difference, work->ref_of,
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
    const nqm_byte_scale *scale;
} factors;

static void round_units(const nqm_kernels *kernels, const nqm_panels *panel, const float *x, uint32_t *units,
                        nqm_byte_scale *scale) {
    if (panel->precision == NQM_PRECISION_F32)
        memcpy(units, x, panel->k * sizeof *x);
    else if (panel->precision == NQM_PRECISION_BF16)
        kernels->round_row(panel->k, x, units);
    else
        *scale = kernels->quantise_row(panel->k, x, units);
}

/* What segment s of a layer makes of row i of the layer's inputs: x, or how the test differs from the reference. */
static const float *inputs_of(nqm_inference_work *work, const nqm_inference_layer *layer, size_t s, size_t i,
                              const float *x) {
    const nqm_panels *panel = &layer->segment[s].panel;
    const float *test = x + layer->segment[s].from;
    if (s != 1 || !layer->differences)
        return test;
    float *difference = work->difference + i * panel->k;
#pragma omp simd
    for (size_t k = 0; k < panel->k; ++k)
        difference[k] = test[k] - x[k];
    return difference;
}

/* Row i of a layer's inputs as the segments from the first-th on want it, where they do not want floats. */
static void round_row(nqm_inference_work *work, const nqm_kernels *kernels, const nqm_inference_layer *layer,
                      size_t first, size_t i, const float *x) {
    for (size_t s = first; s < layer->n_segments; ++s) {
        const nqm_segment *segment = &layer->segment[s];
        if (segment->panel.precision != NQM_PRECISION_F32)
            round_units(kernels, &segment->panel, inputs_of(work, layer, s, i, x),
                        work->rounded + i * work->rounded_stride + segment->at, &work->scale[s * work->max_batch + i]);
    }
}

static factors factors_of(const nqm_inference_work *work, const nqm_segment *segment, size_t s, const float *x,
                          size_t ldx) {
    if (segment->panel.precision == NQM_PRECISION_F32)
        return (factors){.units = (const uint32_t *)(const void *)(x + segment->from), .ld = ldx};
    return (factors){work->rounded + segment->at, work->rounded_stride, work->scale + s * work->max_batch};
}

/* ---- products ---------------------------------------------------------------------------------------------------- */

/* Which part of C: rows [row, row + m), the columns of n panels. One row comes with several panels. */
typedef struct block {
    size_t row, m, panel, n;
} block;

static size_t panels_at_once(size_t n_rows) {
    return n_rows == 1 ? ROW_PANELS : 1;
}

static size_t ceil_div(size_t a, size_t b) {
    return (a + b - 1) / b;
}

/* Neighbouring blocks share their rows, which stay in the second cache. */
static block block_at(size_t i, size_t n_rows, const nqm_panels *panels) {
    const size_t step = panels_at_once(n_rows), n_across = ceil_div(panels->n_panels, step);
    const size_t row = i / n_across * BLOCK_ROWS, panel = i % n_across * step;
    return (block){row, smaller(n_rows - row, BLOCK_ROWS), panel, smaller(panels->n_panels - panel, step)};
}

static size_t count_blocks(size_t n_rows, const nqm_panels *panels) {
    return ceil_div(n_rows, BLOCK_ROWS) * ceil_div(panels->n_panels, panels_at_once(n_rows));
}

/* One row of a block, c (n, NQM_PANEL). */
static void multiply_row(const nqm_kernels *kernels, const nqm_panels *b, factors a, block at, bool add, void *c) {
    kernels->row_product[b->precision](&(nqm_row_product){.units = b->units,
                                                          .n_panels = at.n,
                                                          .stride = b->stride,
                                                          .add = add,
                                                          .a = a.units + at.row * a.ld,
                                                          .b = nqm_panel_at(b, at.panel),
                                                          .c = c});
}

static void multiply_rows(const nqm_kernels *kernels, const nqm_panels *b, factors a, block at, bool add, void *c,
                          size_t ldc) {
    if (at.m == 1)
        multiply_row(kernels, b, a, at, add, c);
    else
        kernels->product[b->precision](&(nqm_product){.m = at.m,
                                                      .units = b->units,
                                                      .add = add,
                                                      .a = a.units + at.row * a.ld,
                                                      .lda = a.ld,
                                                      .b = nqm_panel_at(b, at.panel),
                                                      .c = c,
                                                      .ldc = ldc});
}

/* A block of C, c (m, n NQM_PANEL), becomes A B or C + A B. */
static void multiply_block(const nqm_kernels *kernels, const nqm_panels *b, factors a, block at, bool add, float *c,
                           size_t ldc) {
    if (b->precision != NQM_PRECISION_INT8) {
        multiply_rows(kernels, b, a, at, add, c, ldc);
        return;
    }
    _Alignas(64) int32_t sums[BLOCK_ROWS * NQM_PANEL];
    multiply_rows(kernels, b, a, at, false, sums, NQM_PANEL);
    for (size_t i = 0; i < at.n; ++i) {
        const nqm_byte_columns columns = nqm_panel_columns(b, at.panel + i);
        kernels->dequantise(at.m, a.scale + at.row, &columns, add, sums + i * NQM_PANEL, c + i * NQM_PANEL, ldc);
    }
}

/* The same with a segment's weights as they lie. */
static void multiply_by_weights(const nqm_kernels *kernels, const nqm_segment *segment, factors a, block at, bool add,
                                float *c, size_t ldc) {
    const nqm_panels *b = &segment->panel;
    for (size_t i = 0, first = at.panel * NQM_PANEL; i < at.n; ++i, first += NQM_PANEL) {
        const nqm_product p = {.m = at.m,
                               .units = b->units,
                               .add = add,
                               .a = a.units + at.row * a.ld,
                               .lda = a.ld,
                               .c = c + i * NQM_PANEL,
                               .ldc = ldc};
        nqm_product_of_weights(kernels, &p, smaller(b->n - first, NQM_PANEL), segment->w + first * segment->ldw,
                               segment->ldw);
    }
}

static void multiply_segment(const nqm_inference_work *work, const nqm_kernels *kernels, const nqm_segment *segment,
                             factors a, block at, bool add, float *c) {
    if (segment->w && !work->packed)
        multiply_by_weights(kernels, segment, a, at, add, c, work->stride);
    else
        multiply_block(kernels, &segment->panel, a, at, add, c, work->stride);
}

/* What some references of this call add to some columns of the first layer. */
static void multiply_reference_block(nqm_inference_work *work, const nqm_kernels *kernels, block at) {
    const factors a = {work->ref, work->ref_stride, work->ref_scale};
    float *part = work->part + (1 + at.row) * work->stride + at.panel * NQM_PANEL;
    multiply_segment(work, kernels, &work->net->layer[0].segment[0], a, at, false, part);
}

/* The same of all references; dealt out. */
static void multiply_references(nqm_inference_work *work, const nqm_kernels *kernels) {
    const nqm_panels *panels = &work->net->layer[0].segment[0].panel;
#pragma omp for schedule(dynamic, 1)
    for (size_t i = 0; i < count_blocks(work->n_refs, panels); ++i)
        multiply_reference_block(work, kernels, block_at(i, work->n_refs, panels));
}

/* The first layer begins with what the references add. */
static void copy_parts(nqm_inference_work *work, block at, float *c) {
    for (size_t r = 0; r < at.m; ++r)
        memcpy(c + r * work->stride, work->part + work->ref_of[at.row + r] * work->stride + at.panel * NQM_PANEL,
               at.n * NQM_PANEL * sizeof *c);
}

/* y = the sum over the segments of a layer; dealt out. */
static void multiply_layer(nqm_inference_work *work, const nqm_kernels *kernels, size_t l, size_t n, const float *x,
                           size_t ldx, float *y) {
    const nqm_inference_layer *layer = &work->net->layer[l];
    const nqm_panels *panels = &layer->segment[0].panel;
#pragma omp for schedule(dynamic, 1)
    for (size_t i = 0; i < count_blocks(n, panels); ++i) {
        const block at = block_at(i, n, panels);
        float *c = y + at.row * work->stride + at.panel * NQM_PANEL;
        if (l == 0 && work->n_refs == n) /* each row has a reference of its own */
            multiply_reference_block(work, kernels, at);
        if (l == 0)
            copy_parts(work, at, c);
        for (size_t s = l == 0; s < layer->n_segments; ++s) {
            const nqm_segment *segment = &layer->segment[s];
            multiply_segment(work, kernels, segment, factors_of(work, segment, s, x, ldx), at, s > 0, c);
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
            round_units(kernels, panel, x + i * ldx, work->ref + at * work->ref_stride, &work->ref_scale[at]);
        round_row(work, kernels, layer, 1, i, x + i * ldx);
    }
}

/* The last reference becomes reference 0 of the next call. */
static void keep_reference(nqm_inference_work *work, const nqm_kernels *kernels, const float *last) {
    if (work->n_refs == 0)
        return;
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
        round_row(work, kernels, layer + 1, 0, i, row);
    }
}

void nqm_inference_run(nqm_inference_work *work, size_t n, const float *x, size_t ldx, float *z) {
    const nqm_inference_net *net = work->net;
    const nqm_kernels *kernels = nqm_kernels_get();
    const size_t last = net->n_layers - 1;
    if (n == 0)
        return;
    work->packed = nqm_inference_net_packed(net, kernels, n);
#pragma omp parallel if (n >= MIN_ROWS && n * work->n_multiplications >= MIN_PARALLEL)
    begin_rows(work, kernels, n, x, ldx);
    /* A call or two of a short process would only wait for a thread to start. */
#pragma omp parallel if (n * work->n_multiplications >= MIN_PARALLEL && (work->packed || n >= MIN_ROWS))
    {
        if (work->n_refs < n)
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
