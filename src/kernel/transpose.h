/* SPDX-License-Identifier: MIT
 *
 * transpose.h - the transpose of blocks of 32-bit words.
 */
#ifndef NQM_SRC_KERNEL_TRANSPOSE_H
#define NQM_SRC_KERNEL_TRANSPOSE_H

#include <stddef.h>
#include <stdint.h>

/** to (4, 4) = the transpose of from (4, 4); ld words from row to row. */
static inline void nqm_transpose_4x4(const uint32_t *from, size_t ld_from, uint32_t *to, size_t ld_to) {
    typedef uint32_t four __attribute__((vector_size(16), aligned(4), may_alias));
    const four a = *(const four *)from, b = *(const four *)(from + ld_from), c = *(const four *)(from + 2 * ld_from),
               d = *(const four *)(from + 3 * ld_from);
    const four ab_low = __builtin_shufflevector(a, b, 0, 4, 1, 5), ab_high = __builtin_shufflevector(a, b, 2, 6, 3, 7);
    const four cd_low = __builtin_shufflevector(c, d, 0, 4, 1, 5), cd_high = __builtin_shufflevector(c, d, 2, 6, 3, 7);
    *(four *)to = __builtin_shufflevector(ab_low, cd_low, 0, 1, 4, 5);
    *(four *)(to + ld_to) = __builtin_shufflevector(ab_low, cd_low, 2, 3, 6, 7);
    *(four *)(to + 2 * ld_to) = __builtin_shufflevector(ab_high, cd_high, 0, 1, 4, 5);
    *(four *)(to + 3 * ld_to) = __builtin_shufflevector(ab_high, cd_high, 2, 3, 6, 7);
}

#endif
