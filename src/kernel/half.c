/* SPDX-License-Identifier: MIT
 *
 * Values in 16 bits (IEEE 754 binary16: 5 bits of exponent, 10 of fraction) and back: in integer arithmetic
 * that compilers turn into vectors. Widening is exact.
 */
#include "kernel/half.h"

#include <math.h>

enum { HALF_SUBNORMAL = 0x400, HALF_SIGN = 0x8000 }; /* magnitudes below the former have no implicit leading 1 */
#define REBIAS 0x38000000u                           /* the exponents' offsets differ by 127 - 15 = 112 */

static inline uint32_t bits_of(float x) {
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

NQM_FOR_EACH_VECTOR_WIDTH
void nqm_half_to_float(size_t n, const void *half, float *x) {
    const unsigned char *from = half;
#pragma omp simd
    for (size_t i = 0; i < n; ++i) {
        uint16_t h;
        memcpy(&h, from + 2 * i, sizeof h);
        const uint32_t magnitude = h & 0x7fffu, sign = (uint32_t)(h & HALF_SIGN) << 16;
        const uint32_t subnormal = bits_of((float)(int32_t)magnitude * 0x1p-24f);
        const uint32_t bits = sign | (magnitude < HALF_SUBNORMAL ? subnormal : (magnitude << 13) + REBIAS);
        memcpy(x + i, &bits, sizeof bits);
    }
}

void nqm_half_from_float(size_t n, const float *x, uint16_t *half) {
    for (size_t i = 0; i < n; ++i) {
        const uint32_t bits = bits_of(x[i]), magnitude = bits & 0x7fffffff;
        uint32_t h;
        if (magnitude >= bits_of(65520))
            h = 0x7c00;
        else if (magnitude >= bits_of(0x1p-14f)) /* half a unit, less one bit where the result is even already */
            h = (magnitude - REBIAS + 0xfff + (magnitude >> 13 & 1)) >> 13;
        else /* the sum's last bit is 2^-24: the addition rounds to a multiple of it */
            h = bits_of(fabsf(x[i]) + 0.5f) - bits_of(0.5f);
        half[i] = (uint16_t)(h | (bits >> 16 & HALF_SIGN));
    }
}
