/* SPDX-License-Identifier: MIT
 *
 * Values in 16 bits (IEEE 754 binary16: 5 bits of exponent, 10 of fraction) and back: by the processor's instruction where it
 * has one (F16C), else in integer arithmetic that compilers turn into vectors. Both are exact.
 */
#include "kernel/half.h"

#include <math.h>
#include <string.h>
#if defined __x86_64__
#include <immintrin.h>
#endif

enum { HALF_SUBNORMAL = 0x400, HALF_SIGN = 0x8000 }; /* magnitudes below the former have no implicit leading 1 */
#define REBIAS 0x38000000u                           /* the exponents' offsets differ by 127 - 15 = 112 */

static inline uint32_t bits_of(float x) {
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

static void widen_by_integers(size_t n, const unsigned char *from, float *x) {
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

#if defined __x86_64__
__attribute__((target("avx,f16c"))) static void widen_by_instruction(size_t n, const unsigned char *from, float *x) {
    size_t i = 0;
    for (; i + 8 <= n; i += 8)
        _mm256_storeu_ps(x + i, _mm256_cvtph_ps(_mm_loadu_si128((const __m128i *)(const void *)(from + 2 * i))));
    widen_by_integers(n - i, from + 2 * i, x + i);
}

static bool has_f16c(void) {
#if defined __clang__ /* its version 14 cannot ask for f16c, which every processor with AVX2 has */
    return __builtin_cpu_supports("avx2");
#else
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("f16c");
#endif
}
#endif

void nqm_half_to_float(size_t n, const void *half, float *x) {
#if defined __x86_64__
    if (has_f16c()) {
        widen_by_instruction(n, half, x);
        return;
    }
#endif
    widen_by_integers(n, half, x);
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
