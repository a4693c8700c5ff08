/* SPDX-License-Identifier: MIT
 *
 * Rows through a packed network, in one of three ways. Together: all threads work on one layer at a time; its blocks of
 * rows and panels are dealt out by the shape only, then its rows. Alone: a thread takes some rows through all layers, so
 * that what lies between layers stays in its caches; who comes first takes the next. One row: the panels are dealt out,
 * but each thread does the rest for itself, so that they wait for each other only once in a layer.
 */
#include "net/inference.h"
#include "net/inference_product.h"

#include <omp.h>
#include <string.h>

enum {
    MIN_PARALLEL = 1 << 18, /* multiplications; below, waking a thread costs more than it saves */
    MIN_ROWS = 16,          /* the same for rows that are compared and rounded */

    /* rows that a thread takes: few enough for its second cache, enough to read all weights for */
    MAX_TAKE = 8 * NQM_STRIP,
    MIN_SHARE = 2 * NQM_STRIP /* of a call for each thread */
};

/* Some rows of a call on their way. */
typedef struct trip {
    nqm_inference_work *work;
    const nqm_kernels *kernels;
    bool alone;      /* else all threads of a region make it together: */
    bool one_row;    /* each with a copy of its own */
    bool one_ref;    /* the references of all rows are the last one and one that is new */
    size_t first, n; /* rows of the call */
    size_t at;       /* where their numbers begin in the work */
    const float *x;  /* (n, ldx) their inputs */
    size_t ldx;
    float *z; /* (n) their outputs */
} trip;

/* ---- layers ------------------------------------------------------------------------------------------------------ */

/* Where the products of layer l for row i of a trip are. */
static float *products_at(const trip *t, size_t l, size_t i) {
    return t->work->y[l % 2] + (t->one_row ? 0 : t->at + i) * t->work->stride;
}

/* Where they become outputs. */
static float *outputs_at(const trip *t, size_t l, size_t i) {
    return t->work->y[l % 2] + (t->at + i) * t->work->stride;
}

/* The first layer begins with what the references add. */
static void copy_parts(const trip *t, nqm_block at, float *c) {
    const nqm_inference_work *work = t->work;
    for (size_t r = 0; r < at.m; ++r)
        memcpy(c + r * work->stride,
               work->part + work->ref_of[t->first + at.row + r] * work->stride + at.panel * NQM_PANEL,
               at.n * NQM_PANEL * sizeof *c);
}

/* Where each row has a reference of its own, what the last one adds is taken from its row. */
static void keep_part(const trip *t, nqm_block at, const float *c) {
    nqm_inference_work *work = t->work;
    if (t->first + at.row + at.m == work->n_rows)
        memcpy(work->part + at.panel * NQM_PANEL, c + (at.m - 1) * work->stride, at.n * NQM_PANEL * sizeof *c);
}

static void multiply_layer_block(const trip *t, size_t l, nqm_block at) {
    const nqm_inference_work *work = t->work;
    const nqm_inference_layer *layer = &work->net->layer[l];
    const float *in = l == 0 ? t->x : outputs_at(t, l - 1, 0);
    const size_t ld = l == 0 ? t->ldx : work->stride, first = l == 0 && !work->own_refs;
    float *c = products_at(t, l, at.row) + at.panel * NQM_PANEL;
    if (first > 0)
        copy_parts(t, at, c);
    for (size_t s = first; s < layer->n_segments; ++s) {
        const nqm_segment *segment = &layer->segment[s];
        nqm_multiply_segment(work, t->kernels, segment, nqm_factors_of(work, segment, s, t->at, in, ld), at, s > 0, c);
        if (l == 0 && s == 0)
            keep_part(t, at, c);
    }
}

/* A few rows whose references are the last one and one that is new: what that adds to a panel is computed beside the
 * products of the rows with the panel before. Each thread has its share of the panels. */
static bool one_new_reference(const trip *all) {
    const nqm_inference_work *work = all->work;
    const nqm_segment *segment = work->net->layer[0].segment;
    return work->n_refs == 1 && all->n > 1 && all->n < NQM_STRIP && (work->packed || !segment->w) &&
           segment[0].panel.units == segment[1].panel.units && segment[0].panel.precision == segment[1].panel.precision;
}

static void multiply_first_layer(const trip *t) {
    const nqm_inference_work *work = t->work;
    const nqm_inference_layer *layer = &work->net->layer[0];
    const nqm_segment *ref = &layer->segment[0], *next = &layer->segment[1];
    const size_t thread = (size_t)omp_get_thread_num(), n_threads = (size_t)omp_get_num_threads();
    const size_t n = ref->panel.n_panels, end = (thread + 1) * n / n_threads;
    nqm_block at = {.m = t->n, .panel = thread * n / n_threads, .n = 1};
    float *part = work->part + work->stride;
    const nqm_factors a = {work->ref, work->ref_stride, work->ref_scale};
    if (at.panel < end)
        nqm_multiply_segment(work, t->kernels, ref, a, (nqm_block){0, 1, at.panel, 1}, false,
                             part + at.panel * NQM_PANEL);
    for (; at.panel < end; ++at.panel) {
        float *c = products_at(t, 0, 0) + at.panel * NQM_PANEL;
        copy_parts(t, at, c);
        const nqm_factors rows = nqm_factors_of(work, next, 1, t->at, t->x, t->ldx);
        if (at.panel + 1 < end)
            nqm_multiply_beside(work, t->kernels, &next->panel, rows, at, c,
                                &(nqm_beside){&ref->panel, a, at.panel + 1, part + (at.panel + 1) * NQM_PANEL});
        else
            nqm_multiply_segment(work, t->kernels, next, rows, at, true, c);
        for (size_t s = 2; s < layer->n_segments; ++s)
            nqm_multiply_segment(work, t->kernels, &layer->segment[s],
                                 nqm_factors_of(work, &layer->segment[s], s, t->at, t->x, t->ldx), at, true, c);
    }
#pragma omp barrier
}

static void multiply_layer(const trip *t, size_t l) {
    const nqm_panels *panels = &t->work->net->layer[l].segment[0].panel;
    const size_t n_blocks = nqm_count_blocks(t->n, panels);
    if (t->alone) {
        for (size_t i = 0; i < n_blocks; ++i)
            multiply_layer_block(t, l, nqm_block_at(i, t->n, panels));
        return;
    }
#pragma omp for schedule(dynamic, 1)
    for (size_t i = 0; i < n_blocks; ++i)
        multiply_layer_block(t, l, nqm_block_at(i, t->n, panels));
}

/* From the products of the layer before l, or from the network's inputs, to what layer l multiplies; past the last hidden
 * layer to the network's output. */
static void row_to_layer(const trip *t, size_t l, size_t i) {
    const nqm_inference_net *net = t->work->net;
    if (l == 0) {
        nqm_round_inputs(t->work, t->kernels, &net->layer[0], !t->work->own_refs, t->at + i, t->x + i * t->ldx);
        return;
    }
    const nqm_inference_layer *before = &net->layer[l - 1];
    const float *products = products_at(t, l - 1, i);
    float *row = outputs_at(t, l - 1, i);
    if (row != products)
        memcpy(row, products, t->work->stride * sizeof *row);
    t->kernels->hidden_row(&(nqm_hidden_row){
        .n = before->n_out, .bias = before->bias, .gamma = before->gamma, .beta = before->beta, .x = row, .y = row});
    if (l < net->n_layers)
        nqm_round_inputs(t->work, t->kernels, &net->layer[l], 0, t->at + i, row);
    else
        t->z[i] = t->kernels->dot(before->n_out, net->output, row) + net->output_bias[0];
}

static void rows_to_layer(const trip *t, size_t l) {
    if (t->alone) {
        for (size_t i = 0; i < t->n; ++i)
            row_to_layer(t, l, i);
        return;
    }
#pragma omp for schedule(static)
    for (size_t i = 0; i < t->n; ++i)
        row_to_layer(t, l, i);
}

static void travel_with_one_row(const trip *t) {
    const size_t n_layers = t->work->net->n_layers;
    const size_t thread = (size_t)omp_get_thread_num(), n_threads = (size_t)omp_get_num_threads();
    row_to_layer(t, 0, 0);
    for (size_t l = 0; l < n_layers; ++l) {
        const nqm_panels *panels = &t->work->net->layer[l].segment[0].panel;
        const size_t n_blocks = nqm_count_blocks(1, panels);
        for (size_t i = thread * n_blocks / n_threads; i < (thread + 1) * n_blocks / n_threads; ++i)
            multiply_layer_block(t, l, nqm_block_at(i, 1, panels));
#pragma omp barrier
        if (l + 1 < n_layers || thread == 0)
            row_to_layer(t, l + 1, 0);
    }
}

static void travel(const trip *t) {
    const size_t n_layers = t->work->net->n_layers;
    rows_to_layer(t, 0);
    for (size_t l = 0; l < n_layers; ++l) {
        if (l == 0 && t->one_ref)
            multiply_first_layer(t);
        else
            multiply_layer(t, l);
        rows_to_layer(t, l + 1);
    }
}

/* ---- the first layer's references -------------------------------------------------------------------------------- */

static bool same_inputs(size_t n, const float *a, const float *b) {
    /* NOLINTNEXTLINE(bugprone-suspicious-memory-comparison): the same bits are meant */
    return memcmp(a, b, n * sizeof *a) == 0;
}

/* Find the references of this call; dealt out. */
static void find_references(const trip *all) {
    nqm_inference_work *work = all->work;
    const nqm_panels *panel = &work->net->layer[0].segment[0].panel;
    const float *kept = work->kept_by == all->kernels ? work->kept : NULL;
#pragma omp for schedule(static)
    for (size_t i = 0; i < all->n; ++i) {
        const float *before = i > 0 ? all->x + (i - 1) * all->ldx : kept;
        work->begins[i] = !before || !same_inputs(panel->k, before, all->x + i * all->ldx);
    }
#pragma omp single
    {
        work->n_refs = 0;
        for (size_t i = 0; i < all->n; ++i)
            work->ref_of[i] = work->n_refs += work->begins[i];
        work->own_refs = work->n_refs == all->n;
    }
}

/* References in the units of the first layer, where rows share them; dealt out. */
static void round_references(const trip *all) {
    nqm_inference_work *work = all->work;
    const nqm_panels *panel = &work->net->layer[0].segment[0].panel;
#pragma omp for schedule(static)
    for (size_t i = 0; i < all->n; ++i)
        if (work->begins[i]) {
            const size_t at = work->ref_of[i] - 1;
            nqm_round_units(all->kernels, panel, all->x + i * all->ldx, work->ref + at * work->ref_stride,
                            &work->ref_scale[at]);
        }
}

/* What they add to the first layer; dealt out. */
static void multiply_references(const trip *all) {
    nqm_inference_work *work = all->work;
    const nqm_segment *segment = &work->net->layer[0].segment[0];
    const nqm_factors a = {work->ref, work->ref_stride, work->ref_scale};
#pragma omp for schedule(dynamic, 1)
    for (size_t i = 0; i < nqm_count_blocks(work->n_refs, &segment->panel); ++i) {
        const nqm_block at = nqm_block_at(i, work->n_refs, &segment->panel);
        float *part = work->part + (1 + at.row) * work->stride + at.panel * NQM_PANEL;
        nqm_multiply_segment(work, all->kernels, segment, a, at, false, part);
    }
}

/* The last reference becomes reference 0 of the next call. */
static void keep_reference(const trip *all) {
    nqm_inference_work *work = all->work;
    if (work->n_refs == 0)
        return;
    const float *last = all->x + (all->n - 1) * all->ldx;
    memcpy(work->kept, last, work->net->layer[0].segment[0].panel.k * sizeof *last);
    if (!work->own_refs)
        memcpy(work->part, work->part + work->n_refs * work->stride, work->stride * sizeof *work->part);
    work->kept_by = all->kernels;
}

/* ---- calls ------------------------------------------------------------------------------------------------------- */

/* How many rows a thread may take at a time; 0: all threads go together. Floats do, for whose weights the third cache is
 * too slow to read them more often. */
static size_t rows_to_take(const trip *all) {
    if (all->work->net->layer[0].segment[0].panel.precision == NQM_PRECISION_F32)
        return 0;
    const size_t share = all->n / (size_t)omp_get_num_threads() / NQM_STRIP * NQM_STRIP;
    return share < MIN_SHARE ? 0 : nqm_smaller(share, MAX_TAKE);
}

/* The next rows that nobody has taken: fewer towards the end, so that all threads end at about the same time. */
static bool take_rows(const trip *all, size_t most, trip *t) {
    nqm_inference_work *work = all->work;
    const size_t n_threads = (size_t)omp_get_num_threads();
    size_t first = atomic_load(&work->taken), n;
    do {
        const size_t left = all->n - first, share = left / (2 * n_threads * NQM_STRIP) * NQM_STRIP;
        n = nqm_smaller(left, share < NQM_STRIP ? NQM_STRIP : nqm_smaller(share, most));
    } while (!atomic_compare_exchange_weak(&work->taken, &first, first + n));
    *t = *all;
    t->alone = true;
    t->first = first;
    t->n = n;
    t->at = (size_t)omp_get_thread_num() * most;
    t->x += t->first * t->ldx;
    t->z += t->first;
    return t->n > 0;
}

void nqm_inference_run(nqm_inference_work *work, size_t n, const float *x, size_t ldx, float *z) {
    const nqm_kernels *kernels = nqm_kernels_get();
    const trip all = {.work = work, .kernels = kernels, .n = n, .x = x, .ldx = ldx, .z = z};
    if (n == 0)
        return;
    work->packed = nqm_inference_net_packed(work->net, kernels, n);
    work->n_rows = n;
    atomic_store(&work->taken, 0);
#pragma omp parallel if (n >= MIN_ROWS && n * work->n_multiplications >= MIN_PARALLEL)
    find_references(&all);
    /* A call or two of a short process would only wait for a thread to start. */
#pragma omp parallel if (n * work->n_multiplications >= MIN_PARALLEL && (work->packed || n >= MIN_ROWS))
    {
        const size_t most = rows_to_take(&all);
        trip t = all;
        t.one_ref = one_new_reference(&all);
        if (!work->own_refs && work->n_refs > 0)
            round_references(&all);
        if (!work->own_refs && work->n_refs > 0 && !t.one_ref)
            multiply_references(&all);
        if (most > 0)
            while (take_rows(&all, most, &t))
                travel(&t);
        else if (n == 1 && (size_t)omp_get_num_threads() < work->n_slots) {
            t.one_row = true;
            t.at = 1 + (size_t)omp_get_thread_num();
            travel_with_one_row(&t);
        } else
            travel(&t);
    }
    keep_reference(&all);
}
