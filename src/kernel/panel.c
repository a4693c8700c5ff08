/* SPDX-License-Identifier: MIT
 *
 * The loops over panels, strips and rows. A product is cut into blocks by its shape, the size of the L2 cache and the number of
 * threads. Each element is summed within one block in one order, so that its bits depend on none of these, and blocks may be
 * scheduled dynamically: on a busy machine no thread waits for another.
 */
#include "kernel/panel.h"
#include "base/os.h"

#include <omp.h>
#include <string.h>

enum {
    MIN_PARALLEL = 1 << 18, /* multiply-adds; below, waking a thread costs more than it saves */
    ROWS_AT_ONCE = 16 * NQM_STRIP,
    BLOCKS_PER_THREAD = 8, /* at least, so that threads end at about the same time */
    PANELS_OF_ROW = 4,     /* at most, of a block with a single row */

    /* Strips of a gradient that are multiplied with all panels before the next: those of 512 rows take 288 KB of the L2
     * cache. Enough for the sink to read its own arrays in long runs. */
    STRIPS_AT_ONCE = 12
};

static size_t l2_bytes;

static void find_l2(void) {
    l2_bytes = nqm_os_l2_bytes();
}

/* ---- products ---------------------------------------------------------------------------------------------------- */

/* How a product is cut. A block is ROWS_AT_ONCE rows of A times some panels. Where the L2 cache holds several panels and a group
 * of rows, all panels of the block are multiplied with a group before the next is read: A is read once for each block. */
typedef struct cut {
    size_t rows;   /* of a group: whole tiles of vector registers */
    size_t panels; /* of a block */
    size_t n_down, n_blocks;
} cut;

static cut cut_product(const nqm_panels *b, size_t m) {
    const size_t rows = 2 * NQM_STRIP, row_bytes = 4 * b->words;
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    pthread_once(&once, find_l2);
    const size_t usable = l2_bytes / 8 * 5; /* what remains is for C and for others */
    const size_t fitting = usable > rows * row_bytes ? (usable - rows * row_bytes) / (NQM_PANEL * row_bytes) : 0;
    const size_t n_down = nqm_ceil_div(m, ROWS_AT_ONCE);
    const size_t fair = n_down * b->n_panels / (BLOCKS_PER_THREAD * (size_t)omp_get_max_threads());
    cut c = {.rows = rows, .panels = nqm_smaller(fitting, fair), .n_down = n_down};
    if (m == 1)
        c.panels = nqm_smaller(PANELS_OF_ROW, nqm_ceil_div(b->n_panels, (size_t)omp_get_max_threads()));
    else if (c.panels <= 1)
        c = (cut){.rows = ROWS_AT_ONCE, .panels = 1, .n_down = n_down};
    c.n_blocks = n_down * nqm_ceil_div(b->n_panels, c.panels);
    return c;
}

/* A block, a group of rows at a time. */
static void multiply_block(const nqm_kernels *kernels, nqm_precision precision, const nqm_product *p, size_t group) {
    for (size_t row = 0; row < p->m; row += group) {
        nqm_product part = *p;
        part.m = nqm_smaller(p->m - row, group);
        part.a = (const uint32_t *)p->a + row * p->lda;
        part.c += row * p->ldc;
        kernels->product[precision](&part);
    }
}

size_t nqm_panels_of_block(const nqm_panels *b, size_t m) {
    return cut_product(b, m).panels;
}

void nqm_multiply_block(const nqm_kernels *kernels, const nqm_panels *b, const nqm_product *p) {
    multiply_block(kernels, b->precision, p, cut_product(b, p->m).rows);
}

void nqm_multiply(const nqm_panels *b, size_t m, const void *a, size_t lda, bool add, float *c, size_t ldc) {
    const nqm_kernels *kernels = nqm_kernels_get();
    const cut by = cut_product(b, m);
    /* Consecutive blocks read the same panels, which stay in the L2 cache. */
#pragma omp parallel for schedule(dynamic, 1) if (m * b->n * b->k >= MIN_PARALLEL && by.n_blocks > 1)
    for (size_t i = 0; i < by.n_blocks; ++i) {
        const size_t panel = i / by.n_down * by.panels, row = i % by.n_down * ROWS_AT_ONCE;
        multiply_block(kernels, b->precision,
                       &(nqm_product){.m = nqm_smaller(m - row, ROWS_AT_ONCE),
                                      .words = b->words,
                                      .n_panels = nqm_smaller(b->n_panels - panel, by.panels),
                                      .add = add,
                                      .a = (const uint32_t *)a + row * lda,
                                      .b = nqm_panel_at(b, panel),
                                      .panel_step = b->stride * NQM_PANEL,
                                      .c = c + row * ldc + panel * NQM_PANEL,
                                      .lda = lda,
                                      .ldc = ldc},
                       by.rows);
    }
}

/* ---- weight gradients --------------------------------------------------------------------------------------------- */

size_t nqm_columns_step(nqm_precision precision, size_t width, size_t m) {
    return nqm_row_stride(width * nqm_words(precision, m));
}

/* Inlined with a constant width: a copy is a few instructions. */
static inline void copy_groups(size_t n, const float *x, size_t width, size_t step, float *to) {
    size_t i = 0;
    for (; i + width <= n; i += width, to += step)
        memcpy(to, x + i, width * sizeof *to);
    if (i < n) {
        memcpy(to, x + i, (n - i) * sizeof *to);
        memset(to + (n - i), 0, (width - (n - i)) * sizeof *to);
    }
}

void nqm_columns_copy(size_t n, const float *x, size_t width, size_t step, float *to) {
    if (width == NQM_STRIP)
        copy_groups(n, x, NQM_STRIP, step, to);
    else
        copy_groups(n, x, NQM_PANEL, step, to);
}

void nqm_gradient_run(const nqm_gradient *g) {
    const nqm_kernels *kernels = nqm_kernels_get();
    const size_t words = nqm_words(g->precision, g->m), n_strips = nqm_ceil_div(g->k, NQM_STRIP);
    const size_t n_panels = nqm_ceil_div(g->n, NQM_PANEL), n_blocks = n_panels * nqm_ceil_div(n_strips, STRIPS_AT_ONCE);
#pragma omp parallel for schedule(dynamic, 1) if (g->m * g->n * g->k >= MIN_PARALLEL && n_blocks > 1)
    for (size_t i = 0; i < n_blocks; ++i) {
        _Alignas(64) float tiles[STRIPS_AT_ONCE * NQM_STRIP * NQM_PANEL];
        const size_t panel = i % n_panels, first = i / n_panels * STRIPS_AT_ONCE;
        nqm_tile_gradient tile = {.n_strips = nqm_smaller(n_strips - first, STRIPS_AT_ONCE),
                                  .words = words,
                                  .left = (const uint32_t *)g->x.data + first * g->x.step,
                                  .step = g->x.step,
                                  .right = (const uint32_t *)g->z.data + panel * g->z.step,
                                  .c = tiles,
                                  .prefetch = {tiles, tiles, tiles}};
        if (g->prefetch)
            g->prefetch(g->user, first, panel, tile.prefetch);
        kernels->gradient[g->precision](&tile);
        g->sink(g->user, first, tile.n_strips, panel, tiles);
    }
}
