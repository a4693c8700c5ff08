/* SPDX-License-Identifier: MIT
 *
 * The forward pass: all threads work on a layer of all rows, whose product is cut into blocks of rows and panels.
 */
#include "base/os.h"
#include "net/inference.h"
#include "net/inference_state.h"

#include <omp.h>
#include <string.h>

enum {
    MIN_PARALLEL = 1 << 18,   /* multiply-adds; below, waking a thread costs more than it saves */
    MIN_PACKING_ROWS = 16,    /* below, the same for a call that packs weights */
    FEW_ROWS = 2 * NQM_STRIP, /* up to these, reading weights takes most of the time */
    BLOCK_ROWS = 16 * NQM_STRIP
};

/* A call of nqm_inference_run(). */
typedef struct call {
    nqm_inference_work *work;
    const nqm_kernels *kernels;
    size_t n;       /* rows */
    const float *x; /* (n, inputs) ldx floats from row to row */
    size_t ldx;
    float *z;       /* (n, outputs) */
    bool is_packed; /* it reads the network's panels; false: each is packed into a thread's buffer */
    size_t n_refs;  /* references of the workspace, without reference 0 */
} call;

/* ---- products ---------------------------------------------------------------------------------------------------- */

/* Rows [row, row + m) of a product and the columns of n panels. */
typedef struct block {
    size_t row, m, panel, n;
} block;

/* Panels that are packed for this call are multiplied one at a time. */
static size_t panels_of_block(const call *c, size_t n_rows, const nqm_panels *p) {
    return c->is_packed ? nqm_panels_of_block(p, n_rows) : 1;
}

static size_t count_blocks(const call *c, size_t n_rows, const nqm_panels *p) {
    return nqm_ceil_div(n_rows, BLOCK_ROWS) * nqm_ceil_div(p->n_panels, panels_of_block(c, n_rows, p));
}

/* Consecutive blocks have the same rows, which stay in the L2 cache. */
static block block_at(const call *c, size_t i, size_t n_rows, const nqm_panels *p) {
    const size_t step = panels_of_block(c, n_rows, p), n_across = nqm_ceil_div(p->n_panels, step);
    const size_t row = i / n_across * BLOCK_ROWS, panel = i % n_across * step;
    return (block){row, nqm_smaller(n_rows - row, BLOCK_ROWS), panel, nqm_smaller(p->n_panels - panel, step)};
}

/* The packed panels of a block. */
static const void *panels_at(const call *c, const nqm_packed_weights *w, block at) {
    if (c->is_packed)
        return nqm_panel_at(&w->panels, at.panel);
    const size_t column = at.panel * NQM_PANEL, thread = (size_t)omp_get_thread_num();
    float *panel = c->work->panel + thread * c->work->panel_size;
    nqm_pack_panel(nqm_smaller(w->panels.n - column, NQM_PANEL), w->panels.k, nqm_weights_at(w->weights, column, 0),
                   panel);
    return panel;
}

/* to = the block `at` of A W^T, or to + A W^T. a: row 0 of A, lda floats from row to row; to: row 0 of a product with the
 * workspace's stride. */
static void multiply_block(const call *c, const nqm_packed_weights *w, const float *a, size_t lda, block at, bool add,
                           float *to) {
    const size_t stride = c->work->stride;
    nqm_multiply_block(c->kernels, &w->panels,
                       &(nqm_product){.m = at.m,
                                      .words = w->panels.words,
                                      .n_panels = at.n,
                                      .add = add,
                                      .a = a + at.row * lda,
                                      .b = panels_at(c, w, at),
                                      .panel_step = w->panels.stride * NQM_PANEL,
                                      .c = to + at.row * stride + at.panel * NQM_PANEL,
                                      .lda = lda,
                                      .ldc = stride});
}

/* ---- references -------------------------------------------------------------------------------------------------- */

/* Number the references of a call: a row with the same reference inputs as the row before has the same number. Returns the last
 * number. */
static size_t find_references(const call *c) {
    nqm_inference_work *work = c->work;
    const size_t n_bytes = work->net->ref.panels.k * sizeof *c->x;
    const float *before = work->kept_kernels == c->kernels ? work->kept_ref : NULL;
    size_t n_refs = 0;
    for (size_t i = 0; i < c->n; ++i) {
        const float *x = c->x + i * c->ldx;
        /* NOLINTNEXTLINE(bugprone-suspicious-memory-comparison): equal bits are meant */
        if (!before || memcmp(before, x, n_bytes) != 0)
            work->ref_row[n_refs++] = i;
        work->ref_of[i] = n_refs;
        before = x;
    }
    return n_refs;
}

/* The references' partial products of layer 0, by the threads of a parallel region. */
static void multiply_references(const call *c) {
    const nqm_inference_work *work = c->work;
    const nqm_packed_weights *w = &work->net->ref;
    const bool in_place = c->n_refs == c->n; /* each row has a reference of its own */
    const float *a = in_place ? c->x : work->ref;
    const size_t lda = in_place ? c->ldx : work->ref_stride, n_blocks = count_blocks(c, c->n_refs, &w->panels);
#pragma omp for schedule(static)
    for (size_t i = 0; i < (in_place ? 0 : c->n_refs); ++i)
        memcpy(work->ref + i * lda, c->x + work->ref_row[i] * c->ldx, w->panels.k * sizeof *a);
#pragma omp for schedule(dynamic, 1)
    for (size_t i = 0; i < n_blocks; ++i)
        multiply_block(c, w, a, lda, block_at(c, i, c->n_refs, &w->panels), false, work->partial + work->stride);
}

/* Keep the last reference as reference 0 of the next call. */
static void keep_reference(const call *c) {
    nqm_inference_work *work = c->work;
    if (c->n_refs == 0)
        return;
    memcpy(work->kept_ref, c->x + (c->n - 1) * c->ldx, work->net->ref.panels.k * sizeof *c->x);
    memcpy(work->partial, work->partial + c->n_refs * work->stride, work->stride * sizeof *work->partial);
    work->kept_kernels = c->kernels;
}

/* ---- layers ------------------------------------------------------------------------------------------------------ */

/* A block of the product of layer l. */
static void multiply_layer_block(const call *c, size_t l, block at) {
    const nqm_inference_work *work = c->work;
    const nqm_packed_weights *w = &work->net->layer[l].w;
    const size_t stride = work->stride, column = at.panel * NQM_PANEL;
    float *to = work->y[l % 2];
    for (size_t i = at.row; l == 0 && i < at.row + at.m; ++i)
        memcpy(to + i * stride + column, work->partial + work->ref_of[i] * stride + column,
               at.n * NQM_PANEL * sizeof *to);
    if (l == 0)
        multiply_block(c, w, c->x + work->net->ref.panels.k, c->ldx, at, true, to);
    else
        multiply_block(c, w, work->y[(l - 1) % 2], stride, at, false, to);
}

/* Row i from the product of layer l to the inputs of the next layer, or to z. */
static void finish_row(const call *c, size_t l, size_t i) {
    const nqm_inference_net *net = c->work->net;
    const nqm_inference_layer *layer = &net->layer[l];
    float *y = c->work->y[l % 2] + i * c->work->stride;
    c->kernels->hidden_row(&(nqm_hidden_row){
        .n = layer->n_out, .bias = layer->bias, .gamma = layer->gamma, .beta = layer->beta, .x = y, .y = y});
    for (size_t o = 0; l + 1 == net->n_layers && o < net->n_outputs; ++o)
        c->z[i * net->n_outputs + o] =
            c->kernels->dot(layer->n_out, net->output + o * layer->n_out, y) + net->output_bias[o];
}

/* By the threads of a parallel region. */
static void run_layer(const call *c, size_t l) {
    const nqm_panels *panels = &c->work->net->layer[l].w.panels;
    const size_t n_blocks = count_blocks(c, c->n, panels);
    if (c->n <= FEW_ROWS) { /* a thread reads the same weights in every call: its caches may still have them */
#pragma omp for schedule(static)
        for (size_t i = 0; i < n_blocks; ++i)
            multiply_layer_block(c, l, block_at(c, i, c->n, panels));
    } else {
#pragma omp for schedule(dynamic, 1)
        for (size_t i = 0; i < n_blocks; ++i)
            multiply_layer_block(c, l, block_at(c, i, c->n, panels));
    }
#pragma omp for schedule(static)
    for (size_t i = 0; i < c->n; ++i)
        finish_row(c, l, i);
}

/* ---- calls ------------------------------------------------------------------------------------------------------- */

static void pack(nqm_inference_net *net) {
    nqm_panels_pack(&net->ref.panels, net->ref.weights);
    for (size_t l = 0; l < net->n_layers; ++l)
        nqm_panels_pack(&net->layer[l].w.panels, net->layer[l].w.weights);
}

/* Whether a call with n rows is to read packed weights; packs them if they are not. Packing writes as much memory as all
 * weights take, which costs more than a whole call with few rows: the first such call packs a panel at a time into a
 * buffer that stays in the L2 cache. Most processes make one call only. */
static bool pack_when_it_pays(const nqm_inference_net *net, size_t n) {
    static pthread_mutex_t packing = PTHREAD_MUTEX_INITIALIZER;   /* held while any network is packed */
    nqm_inference_net *own = (nqm_inference_net *)(uintptr_t)net; /* logically constant */
    if (atomic_load_explicit(&own->is_packed, memory_order_acquire))
        return true;
    if (n <= BLOCK_ROWS && !atomic_exchange(&own->has_run, true))
        return false;
    pthread_mutex_lock(&packing);
    if (!own->is_packed) {
        pack(own);
        atomic_store_explicit(&own->is_packed, true, memory_order_release);
    }
    pthread_mutex_unlock(&packing);
    return true;
}

void nqm_inference_run(nqm_inference_work *work, size_t n, const float *x, size_t ldx, float *z) {
    call c = {.work = work, .kernels = nqm_kernels_get(), .n = n, .x = x, .ldx = ldx, .z = z};
    if (n == 0)
        return;
    c.is_packed = pack_when_it_pays(work->net, n);
    c.n_refs = find_references(&c);
    const bool parallel = n * work->n_products >= MIN_PARALLEL && (c.is_packed || n >= MIN_PACKING_ROWS);
    const size_t n_threads = nqm_smaller((size_t)omp_get_max_threads(), work->n_threads);
#pragma omp parallel num_threads((int)n_threads) if (parallel)
    {
        multiply_references(&c);
        for (size_t l = 0; l < work->net->n_layers; ++l)
            run_layer(&c, l);
    }
    keep_reference(&c);
}
