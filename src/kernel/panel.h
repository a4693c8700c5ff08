/* SPDX-License-Identifier: MIT
 *
 * panel.h - matrices as the products of kernel/kernel.h read them, and the loops over them on several threads.
 *
 * Panels: a matrix B (k, n) cut into panels of NQM_PANEL columns, so that a product reads it once, in order. Weights are
 * kept this way. Strips: NQM_STRIP neighbouring columns of activations, the left factor of a tile of a weight gradient. Rows:
 * the left factor of a product, row-major in words (nqm_words()). Whatever stands beyond an edge is 0.
 */
#ifndef NQM_SRC_KERNEL_PANEL_H
#define NQM_SRC_KERNEL_PANEL_H

#include "kernel/kernel.h"

/** A matrix (k, n) in panels. */
typedef struct nqm_panels {
    nqm_precision precision;
    size_t k, n;
    size_t words;    /**< nqm_words(precision, k) */
    size_t stride;   /**< words from one panel to the next, a row of NQM_PANEL each: `words` rounded up to NQM_STRIP */
    size_t n_panels; /**< n / NQM_PANEL, rounded up */
    uint32_t *data;  /**< (n_panels, stride, NQM_PANEL) words */
    float *scale; /**< NQM_PRECISION_INT8: (n_panels NQM_PANEL) a signed factor stands for factor * scale; else NULL */
    int32_t *sum; /**< NQM_PRECISION_INT8: (n_panels NQM_PANEL) the sum of each column's signed factors; else NULL */
} nqm_panels;

/** Room for a matrix, all 0. NQM_ERR_NOMEM. */
NQM_MUST_CHECK nqm_status nqm_panels_create(nqm_precision precision, size_t k, size_t n, nqm_panels *panels_ret,
                                            nqm_error *err);
void nqm_panels_free(nqm_panels *panels);
/** Fill panels of (k, n) from the transpose of w (n, k), row-major, ldw numbers from row to row: weights (out, in).
 *  Works on all threads. */
void nqm_panels_pack(nqm_panels *panels, const float *w, size_t ldw);
/** One panel (k, NQM_PANEL) of floats from the transpose of w (width, k), ldw floats from row to row; zeros beyond width. */
void nqm_pack_panel(size_t width, size_t k, const float *w, size_t ldw, float *panel);
/** The way back, from NQM_PRECISION_F32. */
void nqm_panels_unpack(const nqm_panels *panels, float *w, size_t ldw);
/** to (n, k) becomes the transpose of from (k, n); from is in NQM_PRECISION_F32, `to` in that or in _BF16. */
void nqm_panels_transpose(const nqm_panels *from, nqm_panels *to);
/** Of that the rows [first, first + n), multiples of 4, of a panel of `from`. */
void nqm_panels_transpose_rows(const nqm_panels *from, nqm_panels *to, size_t first, size_t n, size_t panel);
/** `to` (NQM_PRECISION_BF16) becomes `from` (NQM_PRECISION_F32) rounded. */
void nqm_panels_round(const nqm_panels *from, nqm_panels *to);
/** Panel p. */
static inline uint32_t *nqm_panel_at(const nqm_panels *panels, size_t p) {
    return panels->data + p * panels->stride * NQM_PANEL;
}

/** What the bytes of panel p stand for. */
static inline nqm_byte_columns nqm_panel_columns(const nqm_panels *panels, size_t p) {
    return (nqm_byte_columns){panels->scale + p * NQM_PANEL, panels->sum + p * NQM_PANEL};
}

/** x (n) as a row of bfloat16: nqm_words() words; by the table in use. */
static inline void nqm_round_row(size_t n, const float *x, uint32_t *words) {
    nqm_kernels_get()->round_row(n, x, words);
}
/** x (n) as a row of unsigned bytes, with the smallest scale that holds all and 0; by the table in use. */
static inline nqm_byte_scale nqm_quantise_row(size_t n, const float *x, uint32_t *words) {
    return nqm_kernels_get()->quantise_row(n, x, words);
}

/**
 * C (m, n) = A B, or C + A B, on all threads where that pays.
 *
 * @param a    (m, b->words) words, lda words from row to row; best not a multiple of 1024: see nqm_row_stride()
 * @param c    (m, b->n_panels NQM_PANEL) numbers, ldc from row to row: float, or int32_t for NQM_PRECISION_INT8
 */
void nqm_multiply(const nqm_panels *b, size_t m, const void *a, size_t lda, bool add, void *c, size_t ldc);

/** Numbers from row to row for rows of n: whole panels, and an odd number of cache lines, so that rows one below the
 *  other do not fall upon the same few places of a cache. */
static inline size_t nqm_row_stride(size_t n) {
    return (n + NQM_PANEL - 1) / NQM_PANEL * NQM_PANEL + 16;
}

/** Takes finished tiles (n_strips, NQM_STRIP, NQM_PANEL) of a gradient, one below the other: rows from NQM_STRIP strip on,
 *  columns from NQM_PANEL panel on. Called on several threads, for each tile once. */
typedef void (*nqm_tile_sink)(void *user, size_t strip, size_t n_strips, size_t panel, const float *tiles);

/** Columns of activations as a factor of a weight gradient, in groups of NQM_STRIP or NQM_PANEL; the last group goes on with
 *  zeros. Floats may lie in rows as they are (step: the columns of a group); of bfloat16 a unit holds two neighbours of a
 *  column (round_pair() of kernel.h), with 0 for one that is missing, best with each group in one piece. */
typedef struct nqm_columns {
    const void *data;
    size_t step; /**< words from a group to the next */
    size_t ld;   /**< words from row to row; best an odd number of cache lines, or a group */
} nqm_columns;

/** How columns (m, n), in groups of `width`, lie best; nqm_row_stride() for rows of floats, each group in one piece for pairs
 *  of bfloat16. data is NULL. */
nqm_columns nqm_columns_of(nqm_precision precision, size_t width, size_t m, size_t n);
/** The words that they take. */
size_t nqm_columns_size(nqm_precision precision, size_t width, size_t m, size_t n);

/** X^T Z of x (m, k), in strips, and z (m, n), in panels. Some tiles at a time into `sink`, so that a gradient need not be
 *  stored before it is used. */
typedef struct nqm_gradient {
    nqm_precision precision; /**< NQM_PRECISION_F32 or _BF16 */
    size_t m, k, n;
    nqm_columns x, z;
    nqm_tile_sink sink;
    /** Called before a tile is computed: what the sink will read for it, so that it is there in time. NULL: not. */
    void (*prefetch)(void *user, size_t strip, size_t panel, const float *prefetch[NQM_PREFETCH]);
    void *user;
} nqm_gradient;
void nqm_gradient_run(const nqm_gradient *gradient);

#endif
