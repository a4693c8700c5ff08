/* SPDX-License-Identifier: MIT
 *
 * bf16.h - rounding to bfloat16: the upper half of a float.
 */
#ifndef NQM_SRC_KERNEL_BF16_H
#define NQM_SRC_KERNEL_BF16_H

#include <stdint.h>
#include <string.h>

/** The bits of x as bfloat16, to nearest, ties to even; a NaN stays a NaN. */
static inline uint32_t nqm_bf16_bits(float x) {
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    uint32_t rounded = (bits + 0x7fff + (bits >> 16 & 1)) >> 16;
    return (bits & 0x7fffffff) > 0x7f800000 ? bits >> 16 | 0x40 : rounded;
}

#endif
