/* SPDX-License-Identifier: MIT
 *
 * Blocks of a layer's products: rounded inputs and packed weights, or floats and weights as they lie.
 */
#include "net/inference_product.h"

#include <string.h>

enum { BLOCK_ROWS = 16 * NQM_STRIP, ROW_PANELS = 4 };

void nqm_round_units(const nqm_kernels *kernels, const nqm_panels *panel, const float *x, uint32_t *units,
                     nqm_byte_scale *scale) {
    if (panel->precision == NQM_PRECISION_F32)
        memcpy(units, x, panel->k * sizeof *x);
    else if (panel->precision == NQM_PRECISION_BF16)
        kernels->round_row(panel->k, x, units);
    else
        *scale = kernels->quantise_row(panel->k, x, units);
}

/* What segment s of a layer makes of its inputs: x, or how the test differs from the reference. */
static const float *inputs_of(nqm_inference_work *work, const nqm_inference_layer *layer, size_t s, size_t at,
                              const float *x) {
    const nqm_panels *panel = &layer->segment[s].panel;
    const float *test = x + layer->segment[s].from;
    if (s != 1 || !layer->differences)
        return test;
    float *difference = work->difference + at * panel->k;
#pragma omp simd
    for (size_t k = 0; k < panel->k; ++k)
        difference[k] = test[k] - x[k];
    return difference;
}

void nqm_round_inputs(nqm_inference_work *work, const nqm_kernels *kernels, const nqm_inference_layer *layer,
                      size_t first, size_t at, const float *x) {
    for (size_t s = first; s < layer->n_segments; ++s) {
        const nqm_segment *segment = &layer->segment[s];
        if (segment->panel.precision != NQM_PRECISION_F32)
            nqm_round_units(kernels, &segment->panel, inputs_of(work, layer, s, at, x),
                            work->rounded + at * work->rounded_stride + segment->at,
                            &work->scale[s * work->n_slots + at]);
    }
}

nqm_factors nqm_factors_of(const nqm_inference_work *work, const nqm_segment *segment, size_t s, size_t at,
                           const float *x, size_t ldx) {
    if (segment->panel.precision == NQM_PRECISION_F32)
        return (nqm_factors){.units = (const uint32_t *)(const void *)(x + segment->from), .ld = ldx};
    return (nqm_factors){work->rounded + at * work->rounded_stride + segment->at, work->rounded_stride,
                         work->scale + s * work->n_slots + at};
}

/* ---- products ---------------------------------------------------------------------------------------------------- */

static size_t panels_at_once(size_t n_rows) {
    return n_rows == 1 ? ROW_PANELS : 1;
}

nqm_block nqm_block_at(size_t i, size_t n_rows, const nqm_panels *panels) {
    const size_t step = panels_at_once(n_rows), n_across = nqm_ceil_div(panels->n_panels, step);
    const size_t row = i / n_across * BLOCK_ROWS, panel = i % n_across * step;
    return (nqm_block){row, nqm_smaller(n_rows - row, BLOCK_ROWS), panel, nqm_smaller(panels->n_panels - panel, step)};
}

size_t nqm_count_blocks(size_t n_rows, const nqm_panels *panels) {
    return nqm_ceil_div(n_rows, BLOCK_ROWS) * nqm_ceil_div(panels->n_panels, panels_at_once(n_rows));
}

/* One row of a block, c (n, NQM_PANEL). */
static void multiply_row(const nqm_kernels *kernels, const nqm_panels *b, nqm_factors a, nqm_block at, bool add,
                         void *c) {
    kernels->row_product[b->precision](&(nqm_row_product){.units = b->units,
                                                          .n_panels = at.n,
                                                          .stride = b->stride,
                                                          .add = add,
                                                          .a = a.units + at.row * a.ld,
                                                          .b = nqm_panel_at(b, at.panel),
                                                          .c = c});
}

static nqm_product product_of(const nqm_panels *b, nqm_factors a, nqm_block at, bool add, void *c, size_t ldc) {
    return (nqm_product){.m = at.m,
                         .units = b->units,
                         .add = add,
                         .a = a.units + at.row * a.ld,
                         .lda = a.ld,
                         .b = nqm_panel_at(b, at.panel),
                         .c = c,
                         .ldc = ldc};
}

static void multiply_rows(const nqm_kernels *kernels, const nqm_panels *b, nqm_factors a, nqm_block at, bool add,
                          void *c, size_t ldc) {
    if (at.m == 1)
        multiply_row(kernels, b, a, at, add, c);
    else {
        const nqm_product p = product_of(b, a, at, add, c, ldc);
        kernels->product[b->precision](&p);
    }
}

static void dequantise(const nqm_kernels *kernels, const nqm_panels *b, nqm_factors a, nqm_block at, bool add,
                       const int32_t *sums, float *c, size_t ldc) {
    for (size_t i = 0; i < at.n; ++i) {
        const nqm_byte_columns columns = nqm_panel_columns(b, at.panel + i);
        kernels->dequantise(at.m, a.scale + at.row, &columns, add, sums + i * NQM_PANEL, c + i * NQM_PANEL, ldc);
    }
}

/* A block of C, c (m, n NQM_PANEL), becomes A B or C + A B. */
static void multiply_block(const nqm_kernels *kernels, const nqm_panels *b, nqm_factors a, nqm_block at, bool add,
                           float *c, size_t ldc) {
    if (b->precision != NQM_PRECISION_INT8) {
        multiply_rows(kernels, b, a, at, add, c, ldc);
        return;
    }
    _Alignas(64) int32_t sums[BLOCK_ROWS * NQM_PANEL];
    multiply_rows(kernels, b, a, at, false, sums, NQM_PANEL);
    dequantise(kernels, b, a, at, add, sums, c, ldc);
}

void nqm_multiply_beside(const nqm_inference_work *work, const nqm_kernels *kernels, const nqm_panels *b, nqm_factors a,
                         nqm_block at, float *c, const nqm_beside *one) {
    const bool bytes = b->precision == NQM_PRECISION_INT8;
    _Alignas(64) int32_t sums[NQM_STRIP * NQM_PANEL], one_sums[NQM_PANEL];
    nqm_product p = bytes ? product_of(b, a, at, false, sums, NQM_PANEL) : product_of(b, a, at, true, c, work->stride);
    p.one_a = one->a.units;
    p.one_b = nqm_panel_at(one->b, one->panel);
    p.one_c = bytes ? (void *)one_sums : one->c;
    kernels->product[b->precision](&p);
    if (bytes) {
        dequantise(kernels, b, a, at, true, sums, c, work->stride);
        dequantise(kernels, one->b, one->a, (nqm_block){0, 1, one->panel, 1}, false, one_sums, one->c, NQM_PANEL);
    }
}

/* The same with a segment's weights as they lie. */
static void multiply_by_weights(const nqm_kernels *kernels, const nqm_segment *segment, nqm_factors a, nqm_block at,
                                bool add, float *c, size_t ldc) {
    const nqm_panels *b = &segment->panel;
    for (size_t i = 0, first = at.panel * NQM_PANEL; i < at.n; ++i, first += NQM_PANEL) {
        const nqm_product p = {.m = at.m,
                               .units = b->units,
                               .add = add,
                               .a = a.units + at.row * a.ld,
                               .lda = a.ld,
                               .c = c + i * NQM_PANEL,
                               .ldc = ldc};
        nqm_product_of_weights(kernels, &p, nqm_smaller(b->n - first, NQM_PANEL), segment->w + first * segment->ldw,
                               segment->ldw);
    }
}

void nqm_multiply_segment(const nqm_inference_work *work, const nqm_kernels *kernels, const nqm_segment *segment,
                          nqm_factors a, nqm_block at, bool add, float *c) {
    if (segment->w && !work->packed)
        multiply_by_weights(kernels, segment, a, at, add, c, work->stride);
    else
        multiply_block(kernels, &segment->panel, a, at, add, c, work->stride);
}
