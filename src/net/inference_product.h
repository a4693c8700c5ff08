/* SPDX-License-Identifier: MIT
 *
 * inference_product.h - a layer's inputs in the units of its precision, and their products with its weights.
 */
#ifndef NQM_SRC_NET_INFERENCE_PRODUCT_H
#define NQM_SRC_NET_INFERENCE_PRODUCT_H

#include "net/inference_work.h"

/** Factors of a product: rows of units, and for bytes what they stand for. */
typedef struct nqm_factors {
    const uint32_t *units;
    size_t ld;
    const nqm_byte_scale *scale;
} nqm_factors;

/** Which part of C: rows [row, row + m), the columns of n panels. One row comes with several panels. */
typedef struct nqm_block {
    size_t row, m, panel, n;
} nqm_block;

/** x (panel->k) in the units of a segment. */
void nqm_round_units(const nqm_kernels *kernels, const nqm_panels *panel, const float *x, uint32_t *units,
                     nqm_byte_scale *scale);
/** x, the inputs of a layer, as its segments from the first-th on want them, where they do not want floats: into row `at`
 *  of the work. */
void nqm_round_inputs(nqm_inference_work *work, const nqm_kernels *kernels, const nqm_inference_layer *layer,
                      size_t first, size_t at, const float *x);
/** The inputs of segment s: those that nqm_round_inputs() put into rows from `at` on, or floats x, ldx from row to row. */
nqm_factors nqm_factors_of(const nqm_inference_work *work, const nqm_segment *segment, size_t s, size_t at,
                           const float *x, size_t ldx);

/** The i-th block of n_rows rows. Neighbours share their rows, which stay in the second cache. */
nqm_block nqm_block_at(size_t i, size_t n_rows, const nqm_panels *panels);
size_t nqm_count_blocks(size_t n_rows, const nqm_panels *panels);
/** A block of C, c (m, n NQM_PANEL) with the work's stride, becomes A B or C + A B. */
void nqm_multiply_segment(const nqm_inference_work *work, const nqm_kernels *kernels, const nqm_segment *segment,
                          nqm_factors a, nqm_block at, bool add, float *c);

/** One row times panel `panel` of b, c (NQM_PANEL). */
typedef struct nqm_beside {
    const nqm_panels *b;
    nqm_factors a;
    size_t panel;
    float *c;
} nqm_beside;

/** c = C + A B for a block of at most NQM_STRIP rows and one panel, and beside it one row of a product of as many units:
 *  its panel comes from the third cache meanwhile. */
void nqm_multiply_beside(const nqm_inference_work *work, const nqm_kernels *kernels, const nqm_panels *b, nqm_factors a,
                         nqm_block at, float *c, const nqm_beside *one);

#endif
