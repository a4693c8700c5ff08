/* SPDX-License-Identifier: MIT
 *
 * half.h - weights as files store them: floats, or 16 bits each (IEEE 754 binary16: 11 bits of precision).
 */
#ifndef NQM_SRC_KERNEL_HALF_H
#define NQM_SRC_KERNEL_HALF_H

#include "base/base.h"

/** n finite binary16 values at any address to floats, exactly. */
void nqm_half_to_float(size_t n, const void *half, float *x);
/** n finite floats to binary16, to nearest, ties to even; magnitudes from 65520 on become infinite. */
void nqm_half_from_float(size_t n, const float *x, uint16_t *half);

/** A matrix of weights, row-major: w or half, the other is NULL. */
typedef struct nqm_weights {
    const float *w;
    const uint16_t *half; /**< binary16 */
    size_t ld;            /**< values from row to row */
} nqm_weights;

/** The part of a matrix from (row, column) on. */
static inline nqm_weights nqm_weights_at(nqm_weights from, size_t row, size_t column) {
    const size_t skip = row * from.ld + column;
    return (nqm_weights){from.w ? from.w + skip : NULL, from.half ? from.half + skip : NULL, from.ld};
}

#endif
