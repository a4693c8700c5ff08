/* SPDX-License-Identifier: MIT
 *
 * The loops over panels, strips and rows. A product is cut into blocks that depend on its shape only, and each element is
 * summed within one block, so that blocks may be scheduled dynamically: on a busy machine no thread waits for another.
 */
#include "kernel/panel.h"

#include <omp.h>
#include <string.h>

enum {
    MIN_PARALLEL = 1 << 18, /* multiply-adds; below, waking a thread costs more than it saves */
    ROWS_AT_ONCE = 11 * NQM_STRIP,
    PANELS_AT_ONCE = 4, /* of a single row */
    STRIPS_AT_ONCE = 25
};

static void multiply_row(const nqm_panels *b, const void *a, bool add, void *c) {
    const nqm_kernels *kernels = nqm_kernels_get();
    const size_t n_blocks = nqm_ceil_div(b->n_panels, PANELS_AT_ONCE);
#pragma omp parallel for schedule(dynamic, 1) if (b->n * b->k >= MIN_PARALLEL && n_blocks > 1)
    for (size_t i = 0; i < n_blocks; ++i) {
        const size_t first = i * PANELS_AT_ONCE;
        kernels->row_product[b->precision](
            &(nqm_row_product){.words = b->words,
                               .n_panels = nqm_smaller(b->n_panels - first, PANELS_AT_ONCE),
                               .stride = b->stride,
                               .add = add,
                               .a = a,
                               .b = nqm_panel_at(b, first),
                               .c = (uint32_t *)c + first * NQM_PANEL});
    }
}

void nqm_multiply(const nqm_panels *b, size_t m, const void *a, size_t lda, bool add, void *c, size_t ldc) {
    if (m == 1) {
        multiply_row(b, a, add, c);
        return;
    }
    const nqm_kernels *kernels = nqm_kernels_get();
    const size_t n_row_blocks = nqm_ceil_div(m, ROWS_AT_ONCE), n_blocks = n_row_blocks * b->n_panels;
    /* Consecutive blocks read the same panel, which stays in the L2 cache. */
#pragma omp parallel for schedule(dynamic, 1) if (m * b->n * b->k >= MIN_PARALLEL && n_blocks > 1)
    for (size_t i = 0; i < n_blocks; ++i) {
        const size_t panel = i / n_row_blocks, row = i % n_row_blocks * ROWS_AT_ONCE;
        nqm_product p = {
            .m = nqm_smaller(m - row, ROWS_AT_ONCE), .words = b->words, .add = add, .lda = lda, .ldc = ldc};
        p.a = (const uint32_t *)a + row * lda;
        p.b = nqm_panel_at(b, panel);
        p.c = (uint32_t *)c + row * ldc + panel * NQM_PANEL; /* float and int32_t have one size */
        kernels->product[b->precision](&p);
    }
}

nqm_columns nqm_columns_of(nqm_precision precision, size_t width, size_t m) {
    return (nqm_columns){.step = nqm_row_stride(width * nqm_words(precision, m)), .ld = width};
}

size_t nqm_columns_size(nqm_precision precision, size_t width, size_t m, size_t n) {
    return nqm_ceil_div(n, width) * nqm_columns_of(precision, width, m).step;
}

void nqm_columns_copy(size_t n, const float *x, size_t width, size_t step, float *to) {
    for (size_t i = 0; i < n; i += width, to += step) {
        const size_t n_copied = nqm_smaller(width, n - i);
        memcpy(to, x + i, n_copied * sizeof *to);
        memset(to + n_copied, 0, (width - n_copied) * sizeof *to);
    }
}

void nqm_gradient_run(const nqm_gradient *g) {
    const nqm_kernels *kernels = nqm_kernels_get();
    const size_t words = nqm_words(g->precision, g->m), n_strips = nqm_ceil_div(g->k, NQM_STRIP);
    const size_t n_across = nqm_ceil_div(n_strips, STRIPS_AT_ONCE), n_blocks = n_across * nqm_ceil_div(g->n, NQM_PANEL);
#pragma omp parallel for schedule(dynamic, 1) if (g->m * g->n * g->k >= MIN_PARALLEL && n_blocks > 1)
    for (size_t i = 0; i < n_blocks; ++i) {
        /* Enough tiles for the sink to read its own arrays in long runs, few enough to stay in the L2 cache. */
        _Alignas(64) float tiles[STRIPS_AT_ONCE * NQM_STRIP * NQM_PANEL];
        const size_t panel = i / n_across, first = i % n_across * STRIPS_AT_ONCE;
        nqm_tile_gradient tile = {.n_strips = nqm_smaller(n_strips - first, STRIPS_AT_ONCE),
                                  .words = words,
                                  .left = (const uint32_t *)g->x.data + first * g->x.step,
                                  .step = g->x.step,
                                  .ld_left = g->x.ld,
                                  .right = (const uint32_t *)g->z.data + panel * g->z.step,
                                  .ld_right = g->z.ld,
                                  .c = tiles,
                                  .prefetch = {tiles, tiles, tiles}};
        if (g->prefetch)
            g->prefetch(g->user, first, panel, tile.prefetch);
        kernels->gradient[g->precision](&tile);
        g->sink(g->user, first, tile.n_strips, panel, tiles);
    }
}
