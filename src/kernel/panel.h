/* SPDX-License-Identifier: MIT
 *
 * panel.h - how matrices are stored for the products of kernel/kernel.h, and the loops over them on several threads.
 *
 *   rows     the left factor of a product: row-major, nqm_words() words a row
 *   panels   the right factor B (k, n), cut into panels of NQM_PANEL columns that a product reads once and in order; weights
 *            W (out, in) are stored as panels of W^T
 *   columns  both factors of a weight gradient: a group of NQM_STRIP or NQM_PANEL columns is read row by row; in
 *            NQM_PRECISION_BF16 a word holds two rows of a column
 *
 * Elements beyond the edge of a matrix are 0.
 */
#ifndef NQM_SRC_KERNEL_PANEL_H
#define NQM_SRC_KERNEL_PANEL_H

#include "kernel/half.h"
#include "kernel/kernel.h"

/** A matrix (k, n) in panels: one block, free with nqm_panels_free(). */
typedef struct nqm_panels {
    nqm_precision precision;
    size_t k, n;
    size_t words;    /**< nqm_words(precision, k): rows of a panel */
    size_t stride;   /**< rows from one panel to the next: `words` rounded up to NQM_STRIP */
    size_t n_panels; /**< n / NQM_PANEL, rounded up */
    uint32_t *data;  /**< (n_panels, stride, NQM_PANEL) */
} nqm_panels;

/** Panels of zeros. NQM_ERR_NOMEM. */
NQM_MUST_CHECK nqm_status nqm_panels_create(nqm_precision precision, size_t k, size_t n, nqm_panels *panels_ret,
                                            nqm_error *err);
void nqm_panels_free(nqm_panels *panels);
/** Fill panels of (k, n), NQM_PRECISION_F32, from the transpose of w (n, k), on all threads. */
void nqm_panels_pack(nqm_panels *panels, nqm_weights w);
/** One panel (k, NQM_PANEL) of floats from the transpose of w (width, k); zeros beyond width. */
void nqm_pack_panel(size_t width, size_t k, nqm_weights w, float *panel);
/** The inverse of nqm_panels_pack(). */
void nqm_panels_unpack(const nqm_panels *panels, float *w, size_t ldw);
/** to (n, k) = the transpose of from (k, n); from is NQM_PRECISION_F32, to is _F32 or _BF16. */
void nqm_panels_transpose(const nqm_panels *from, nqm_panels *to);
/** The same for rows [first, first + n) of one panel of `from`; first and n are multiples of 4. */
void nqm_panels_transpose_rows(const nqm_panels *from, nqm_panels *to, size_t first, size_t n, size_t panel);
/** to (NQM_PRECISION_BF16) = from (NQM_PRECISION_F32) rounded. */
void nqm_panels_round(const nqm_panels *from, nqm_panels *to);
/** Panel p. */
static inline uint32_t *nqm_panel_at(const nqm_panels *panels, size_t p) {
    return panels->data + p * panels->stride * NQM_PANEL;
}

/**
 * C (m, n) = A B, or C + A B, on all threads unless the product is small.
 *
 * @param a    (m, b->words) rows, lda words from row to row; nqm_row_stride() is fastest, multiples of 1024 are slow
 * @param c    (m, b->n_panels NQM_PANEL), ldc floats from row to row
 */
void nqm_multiply(const nqm_panels *b, size_t m, const void *a, size_t lda, bool add, float *c, size_t ldc);

/** A block of such a product, of some rows and some panels of b (or copies of these), for callers that distribute blocks to threads
 *  themselves. */
void nqm_multiply_block(const nqm_kernels *kernels, const nqm_panels *b, const nqm_product *p);
/** Panels of a block of a product of m rows: so many that the rows are read from beyond the L2 cache less often. */
size_t nqm_panels_of_block(const nqm_panels *b, size_t m);

/** Floats or words from row to row for rows of n: whole panels, and an odd number of cache lines, so that the rows of a tile
 *  are not stored in the same few sets of a cache. */
static inline size_t nqm_row_stride(size_t n) {
    return (n + NQM_PANEL - 1) / NQM_PANEL * NQM_PANEL + 16;
}

/** Receives finished tiles (n_strips, NQM_STRIP, NQM_PANEL) of a gradient: rows from NQM_STRIP strip on, columns from
 *  NQM_PANEL panel on. Called on several threads, once for each tile. */
typedef void (*nqm_tile_sink)(void *user, size_t strip, size_t n_strips, size_t panel, const float *tiles);

/** A factor of a weight gradient: columns of activations in groups of NQM_STRIP or NQM_PANEL, the last group filled up with
 *  zeros. A row of a group follows the one before it. In NQM_PRECISION_BF16 a word holds two rows of a column (round_pair() of
 *  kernel.h), with 0 for a missing last row. */
typedef struct nqm_columns {
    const void *data;
    size_t step; /**< words from one group to the next */
} nqm_columns;

/** The fastest step for m rows in groups of `width`. */
size_t nqm_columns_step(nqm_precision precision, size_t width, size_t m);
/** Copy a row (n) to such groups in NQM_PRECISION_F32; to: the row of the first group. */
void nqm_columns_copy(size_t n, const float *x, size_t width, size_t step, float *to);

/** X^T Z of x (m, k) and z (m, n): the gradient of weights (k, n) for a batch of m rows. Tiles are passed to `sink` as they
 *  are finished, so that the gradient need not be stored. */
typedef struct nqm_gradient {
    nqm_precision precision; /**< NQM_PRECISION_F32 or _BF16 */
    size_t m, k, n;
    nqm_columns x; /**< in groups of NQM_STRIP */
    nqm_columns z; /**< in groups of NQM_PANEL */
    nqm_tile_sink sink;
    /** Called before tiles of consecutive strips from `strip` on are computed: sets the arrays that the sink will read for them,
     *  stored like the tiles, to be prefetched. NULL: none. */
    void (*prefetch)(void *user, size_t strip, size_t panel, const float *prefetch[NQM_PREFETCH]);
    void *user;
} nqm_gradient;
void nqm_gradient_run(const nqm_gradient *gradient);

#endif
