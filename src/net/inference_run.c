/* SPDX-License-Identifier: MIT
 *
 * The forward pass. Two ways of using several threads share one code: either all threads work on a layer of all rows,
 * whose product is cut into blocks of rows and panels, or each thread takes some rows through all layers, so that their
 * activations stay in its caches.
 */
#include "net/inference.h"
#include "net/inference_state.h"

#include <omp.h>
#include <pthread.h>
#include <string.h>

enum {
    MIN_PARALLEL = 1 << 18,   /* multiply-adds; below, waking a thread costs more than it saves */
    MIN_PACKING_ROWS = 16,    /* below, the same for a call that packs weights */
    FEW_ROWS = 2 * NQM_STRIP, /* up to these, reading weights takes most of the time */
    BLOCK_ROWS = 16 * NQM_STRIP,

    /* Rows that a thread takes through all layers: few enough for activations to stay in its L2 cache, enough to amortise reading
     * all weights. With fewer than MIN_THREAD_ROWS for each thread, all threads work on all rows instead. */
    MAX_TASK_ROWS = 8 * NQM_STRIP,
    MIN_THREAD_ROWS = 2 * NQM_STRIP
};

/* Some rows of a call, computed by the threads of one parallel region. */
typedef struct rows {
    nqm_inference_work *work;
    const nqm_kernels *kernels;
    size_t first, n; /* rows of the call */
    size_t slot;     /* row of the workspace's arrays that holds the first of them */
    const float *x;  /* (n, inputs) ldx floats from row to row */
    size_t ldx;
    float *z; /* (n, outputs) */
} rows;

/* ---- products ---------------------------------------------------------------------------------------------------- */

/* The left factor of a product: rows of floats, or of rounded inputs. */
typedef struct left_rows {
    const uint32_t *words;
    size_t stride;
    const nqm_byte_scale *scale; /* (rows) NQM_PRECISION_INT8 */
} left_rows;

/* Rows [row, row + m) of a product and the columns of n panels. */
typedef struct block {
    size_t row, m, panel, n;
} block;

/* Panels that are packed for this call are multiplied one at a time, and so are those of rounded inputs, whose rows stay in the L2
 * cache. */
static size_t panels_of_block(const rows *r, size_t n_rows, const nqm_panels *p) {
    const bool one = !r->work->is_packed || (n_rows > 1 && p->precision != NQM_PRECISION_F32);
    return one ? 1 : nqm_panels_of_block(p, n_rows);
}

static size_t count_blocks(const rows *r, size_t n_rows, const nqm_panels *p) {
    return nqm_ceil_div(n_rows, BLOCK_ROWS) * nqm_ceil_div(p->n_panels, panels_of_block(r, n_rows, p));
}

/* Consecutive blocks have the same rows, which stay in the L2 cache. */
static block block_at(const rows *r, size_t i, size_t n_rows, const nqm_panels *p) {
    const size_t step = panels_of_block(r, n_rows, p), n_across = nqm_ceil_div(p->n_panels, step);
    const size_t row = i / n_across * BLOCK_ROWS, panel = i % n_across * step;
    return (block){row, nqm_smaller(n_rows - row, BLOCK_ROWS), panel, nqm_smaller(p->n_panels - panel, step)};
}

/* The packed panels of a block; packs them into the thread's buffer where the network's are empty. */
static const uint32_t *panels_at(const rows *r, const nqm_segment *s, block at) {
    const nqm_inference_work *work = r->work;
    if (!nqm_has_weights(s->weights) || work->is_packed)
        return nqm_panel_at(&s->panels, at.panel);
    const size_t column = at.panel * NQM_PANEL, thread = (size_t)omp_get_thread_num();
    float *panel = work->panel + thread * work->panel_size;
    nqm_pack_panel(nqm_smaller(s->panels.n - column, NQM_PANEL), s->panels.k, nqm_weights_at(s->weights, column, 0),
                   panel);
    return (const uint32_t *)(const void *)panel;
}

/* c (m, n NQM_PANEL) = the block `at` of A B, or c + A B, in float for any precision; c has the workspace's stride. */
static void multiply_block(const rows *r, const nqm_segment *s, left_rows a, block at, bool add, float *c) {
    _Alignas(64) int32_t sums[BLOCK_ROWS * NQM_PANEL]; /* of bytes: for rows and a panel, or a row and some panels */
    const nqm_panels *p = &s->panels;
    const bool is_int8 = p->precision == NQM_PRECISION_INT8;
    const size_t ldc = r->work->stride;
    nqm_multiply_block(r->kernels, p,
                       &(nqm_product){.m = at.m,
                                      .words = p->words,
                                      .n_panels = at.n,
                                      .add = add && !is_int8,
                                      .a = a.words + at.row * a.stride,
                                      .b = panels_at(r, s, at),
                                      .panel_step = p->stride * NQM_PANEL,
                                      .c = is_int8 ? (void *)sums : c,
                                      .lda = a.stride,
                                      .ldc = is_int8 ? NQM_PANEL : ldc});
    for (size_t i = 0; is_int8 && i < at.n; ++i) {
        const nqm_byte_columns columns = nqm_panel_columns(p, at.panel + i);
        r->kernels->dequantise(at.m, a.scale + at.row, &columns, add, sums + i * NQM_PANEL, c + i * NQM_PANEL, ldc);
    }
}

/* ---- inputs of a layer ------------------------------------------------------------------------------------------- */

/* x (inputs of the panels) in their precision. */
static void round_inputs(const nqm_kernels *kernels, const nqm_panels *p, const float *x, uint32_t *words,
                         nqm_byte_scale *scale) {
    if (p->precision == NQM_PRECISION_F32)
        memcpy(words, x, p->k * sizeof *x);
    else if (p->precision == NQM_PRECISION_BF16)
        kernels->round_row(p->k, x, words);
    else
        *scale = kernels->quantise_row(p->k, x, words);
}

static const float *subtract_reference(const rows *r, size_t n, const float *test, const float *ref, size_t i) {
    float *difference = r->work->difference + (r->slot + i) * n;
#pragma omp simd
    for (size_t k = 0; k < n; ++k)
        difference[k] = test[k] - ref[k];
    return difference;
}

/* Round the inputs x of layer l for row i; its segments of floats are read in place, and the references' are done. */
static void round_segments(const rows *r, size_t l, size_t i, const float *x) {
    const nqm_inference_work *work = r->work;
    const nqm_inference_layer *layer = &work->net->layer[l];
    for (size_t s = l == 0; s < layer->n_segments; ++s) {
        const nqm_segment *segment = &layer->segment[s];
        const float *own = x + segment->first;
        if (segment->panels.precision == NQM_PRECISION_F32)
            continue;
        if (layer->differences && s == 1)
            own = subtract_reference(r, segment->panels.k, own, x, i);
        round_inputs(r->kernels, &segment->panels, own,
                     work->rounded + (r->slot + i) * work->rounded_stride + segment->word,
                     &work->scale[s * work->max_batch + r->slot + i]);
    }
}

/* The inputs of a segment of layer l, as round_segments() left them. */
static left_rows inputs_of(const rows *r, size_t l, size_t s, const float *x, size_t ldx) {
    const nqm_inference_work *work = r->work;
    const nqm_segment *segment = &work->net->layer[l].segment[s];
    if (segment->panels.precision == NQM_PRECISION_F32)
        return (left_rows){.words = (const uint32_t *)(const void *)(x + segment->first), .stride = ldx};
    return (left_rows){work->rounded + r->slot * work->rounded_stride + segment->word, work->rounded_stride,
                       work->scale + s * work->max_batch + r->slot};
}

/* ---- references -------------------------------------------------------------------------------------------------- */

/* Number the references of a call: a row with the same reference inputs as the row before has the same number. */
static void find_references(const rows *all) {
    nqm_inference_work *work = all->work;
    const size_t n_bytes = work->net->layer[0].segment[0].panels.k * sizeof *all->x;
    const float *before = work->kept_kernels == all->kernels ? work->kept_ref : NULL;
    work->n_refs = 0;
    for (size_t i = 0; i < all->n; ++i) {
        const float *x = all->x + i * all->ldx;
        /* NOLINTNEXTLINE(bugprone-suspicious-memory-comparison): equal bits are meant */
        if (!before || memcmp(before, x, n_bytes) != 0)
            work->ref_row[work->n_refs++] = i;
        work->ref_of[i] = work->n_refs;
        before = x;
    }
}

/* Whether each row has a reference of its own: its partial product is then computed with the row's other products. */
static bool has_own_references(const rows *r) {
    return r->work->n_refs == r->work->n_rows;
}

static void round_reference(const rows *all, size_t i, const float *x) {
    const nqm_inference_work *work = all->work;
    round_inputs(all->kernels, &work->net->layer[0].segment[0].panels, x, work->ref + i * work->ref_stride,
                 &work->ref_scale[i]);
}

/* A block of the references' partial products of layer 0. */
static void multiply_reference_block(const rows *r, block at) {
    const nqm_inference_work *work = r->work;
    multiply_block(r, &work->net->layer[0].segment[0], (left_rows){work->ref, work->ref_stride, work->ref_scale}, at,
                   false, work->partial + (1 + at.row) * work->stride + at.panel * NQM_PANEL);
}

/* All of them; by the threads of a parallel region. */
static void multiply_references(const rows *all) {
    const nqm_inference_work *work = all->work;
    const nqm_panels *panels = &work->net->layer[0].segment[0].panels;
    const size_t n_blocks = count_blocks(all, work->n_refs, panels);
#pragma omp for schedule(static)
    for (size_t i = 0; i < work->n_refs; ++i)
        round_reference(all, i, all->x + work->ref_row[i] * all->ldx);
#pragma omp for schedule(dynamic, 1)
    for (size_t i = 0; i < n_blocks; ++i)
        multiply_reference_block(all, block_at(all, i, work->n_refs, panels));
}

/* Keep the last reference as reference 0 of the next call. */
static void keep_reference(const rows *all) {
    nqm_inference_work *work = all->work;
    if (work->n_refs == 0)
        return;
    memcpy(work->kept_ref, all->x + (all->n - 1) * all->ldx, work->net->layer[0].segment[0].panels.k * sizeof *all->x);
    memcpy(work->partial, work->partial + work->n_refs * work->stride, work->stride * sizeof *work->partial);
    work->kept_kernels = all->kernels;
}

/* ---- layers ------------------------------------------------------------------------------------------------------ */

/* (n, stride) the product of layer l, then its output. */
static float *output_of(const rows *r, size_t l) {
    return r->work->y[l % 2] + r->slot * r->work->stride;
}

/* A block of the product of layer l. */
static void multiply_layer_block(const rows *r, size_t l, block at) {
    const nqm_inference_work *work = r->work;
    const nqm_inference_layer *layer = &work->net->layer[l];
    const size_t column = at.panel * NQM_PANEL, stride = work->stride;
    float *c = output_of(r, l) + at.row * stride + column;
    if (l == 0 && has_own_references(r))
        multiply_reference_block(r, (block){r->first + at.row, at.m, at.panel, at.n});
    for (size_t i = 0; l == 0 && i < at.m; ++i)
        memcpy(c + i * stride, work->partial + work->ref_of[r->first + at.row + i] * stride + column,
               at.n * NQM_PANEL * sizeof *c);
    for (size_t s = l == 0; s < layer->n_segments; ++s)
        multiply_block(r, &layer->segment[s],
                       l == 0 ? inputs_of(r, l, s, r->x, r->ldx) : inputs_of(r, l, s, output_of(r, l - 1), stride), at,
                       l == 0 || s > 0, c);
}

/* Row i from the product of layer l to the inputs of the next layer, or to z. */
static void finish_row(const rows *r, size_t l, size_t i) {
    const nqm_inference_net *net = r->work->net;
    const nqm_inference_layer *layer = &net->layer[l];
    float *y = output_of(r, l) + i * r->work->stride;
    r->kernels->hidden_row(&(nqm_hidden_row){
        .n = layer->n_out, .bias = layer->bias, .gamma = layer->gamma, .beta = layer->beta, .x = y, .y = y});
    if (l + 1 < net->n_layers)
        round_segments(r, l + 1, i, y);
    else
        for (size_t o = 0; o < net->n_outputs; ++o)
            r->z[i * net->n_outputs + o] =
                r->kernels->dot(layer->n_out, net->output + o * layer->n_out, y) + net->output_bias[o];
}

/* All layers for some rows, by the threads of the parallel region that it is called in. */
static void run_rows(const rows *r) {
    const nqm_inference_net *net = r->work->net;
#pragma omp for schedule(static)
    for (size_t i = 0; i < r->n; ++i) {
        if (has_own_references(r))
            round_reference(r, r->first + i, r->x + i * r->ldx);
        round_segments(r, 0, i, r->x + i * r->ldx);
    }
    for (size_t l = 0; l < net->n_layers; ++l) {
        const nqm_panels *panels = &net->layer[l].segment[0].panels;
        const size_t n_blocks = count_blocks(r, r->n, panels);
        if (r->n <= FEW_ROWS) { /* a thread reads the same weights in every call: its caches may still have them */
#pragma omp for schedule(static)
            for (size_t i = 0; i < n_blocks; ++i)
                multiply_layer_block(r, l, block_at(r, i, r->n, panels));
        } else {
#pragma omp for schedule(dynamic, 1)
            for (size_t i = 0; i < n_blocks; ++i)
                multiply_layer_block(r, l, block_at(r, i, r->n, panels));
        }
#pragma omp for schedule(static)
        for (size_t i = 0; i < r->n; ++i)
            finish_row(r, l, i);
    }
}

/* ---- calls ------------------------------------------------------------------------------------------------------- */

static void pack_floats(nqm_inference_net *net) {
    for (size_t l = 0; l < net->n_layers; ++l)
        for (size_t s = 0; s < net->layer[l].n_segments; ++s) {
            nqm_segment *segment = &net->layer[l].segment[s];
            if (nqm_has_weights(segment->weights))
                nqm_panels_pack(&segment->panels, segment->weights);
        }
}

/* Whether a call with n rows is to read packed floats; packs them if they are not. Packing writes as much memory as all
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
        pack_floats(own);
        atomic_store_explicit(&own->is_packed, true, memory_order_release);
    }
    pthread_mutex_unlock(&packing);
    return true;
}

/* How many rows a thread takes through all layers at a time; 0: all threads work on all rows. Floats do that always:
 * their weights are too large to be read once for each task. */
static size_t rows_of_task(const rows *all) {
    if (all->work->net->layer[0].segment[0].panels.precision == NQM_PRECISION_F32)
        return 0;
    const size_t n = all->n / (size_t)omp_get_num_threads() / NQM_STRIP * NQM_STRIP;
    return n < MIN_THREAD_ROWS ? 0 : nqm_smaller(n, MAX_TASK_ROWS);
}

/* Take the next rows: fewer towards the end, so that all threads end at about the same time. */
static bool take_rows(const rows *all, size_t most, rows *part) {
    nqm_inference_work *work = all->work;
    const size_t n_threads = (size_t)omp_get_num_threads();
    size_t first = atomic_load(&work->n_taken), n;
    do {
        const size_t left = all->n - first, fair = left / (2 * n_threads * NQM_STRIP) * NQM_STRIP;
        n = nqm_smaller(left, fair < NQM_STRIP ? NQM_STRIP : nqm_smaller(fair, most));
    } while (!atomic_compare_exchange_weak(&work->n_taken, &first, first + n));
    *part = *all;
    part->first = first;
    part->n = n;
    part->slot = (size_t)omp_get_thread_num() * most;
    part->x += first * part->ldx;
    part->z += first * work->net->n_outputs;
    return n > 0;
}

void nqm_inference_run(nqm_inference_work *work, size_t n, const float *x, size_t ldx, float *z) {
    const rows all = {.work = work, .kernels = nqm_kernels_get(), .n = n, .x = x, .ldx = ldx, .z = z};
    if (n == 0)
        return;
    work->is_packed = pack_when_it_pays(work->net, n);
    work->n_rows = n;
    work->n_taken = 0;
    find_references(&all);
    const bool parallel = n * work->n_products >= MIN_PARALLEL && (work->is_packed || n >= MIN_PACKING_ROWS);
    const size_t n_threads = nqm_smaller((size_t)omp_get_max_threads(), work->n_threads);
#pragma omp parallel num_threads((int)n_threads) if (parallel)
    {
        const size_t most = rows_of_task(&all);
        rows part;
        if (!has_own_references(&all))
            multiply_references(&all);
        if (most == 0)
            run_rows(&all);
        while (most > 0 && take_rows(&all, most, &part)) {
#pragma omp parallel num_threads(1) /* the loops of run_rows() are this thread's alone */
            run_rows(&part);
        }
    }
    keep_reference(&all);
}
