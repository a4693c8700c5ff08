/* SPDX-License-Identifier: MIT
 *
 * Kernels for x86-64 with AVX-512 and its products of bfloat16 and of bytes (BF16, VNNI).
 */
#if defined __x86_64__
#include <immintrin.h>

#define VECTOR_BYTES        64
#define TILE_ROWS           12
#define TILE_VECTORS        2
#define MADD_F32(sum, a, b) ((vector_f)_mm512_fmadd_ps(_mm512_set1_ps(a), (__m512)(b), (__m512)(sum)))
#define MADD_BF16(sum, a, b)                                                                                           \
    ((vector_f)_mm512_dpbf16_ps((__m512)(sum), (__m512bh)_mm512_set1_epi32((int)(a)), (__m512bh)(b)))
#define MADD_INT8(sum, a, b) ((vector_i)_mm512_dpbusd_epi32((__m512i)(sum), _mm512_set1_epi32((int)(a)), (__m512i)(b)))
#include "kernel/tiles.h"

/* Rounding by the processor, which takes denormals for 0, as its products do. */
#define NQM_NATIVE_ROUNDING
static void round_row(size_t n, const float *x, uint32_t *units) {
    enum { AT_ONCE = 32 };
    size_t i = 0;
    for (; i + AT_ONCE <= n; i += AT_ONCE) {
        __m512bh both = _mm512_cvtne2ps_pbh(_mm512_loadu_ps(x + i + 16), _mm512_loadu_ps(x + i));
        _mm512_storeu_si512(units + i / 2, (__m512i)both);
    }
    const size_t left = n - i, n_low = left < 16 ? left : 16;
    const __mmask16 low = (__mmask16)((1u << n_low) - 1), high = (__mmask16)((1u << (left - n_low)) - 1);
    const __mmask16 out = (__mmask16)((1u << (left + 1) / 2) - 1);
    /* Where nothing is left, nothing is read or written. */
    __m512bh both = _mm512_cvtne2ps_pbh(_mm512_maskz_loadu_ps(high, x + i + n_low), _mm512_maskz_loadu_ps(low, x + i));
    _mm512_mask_storeu_epi32(units + i / 2, out, (__m512i)both);
}

/* A unit for each of at most 16 columns. */
static inline void round_columns(__mmask16 there, const float *even, const float *odd, uint32_t *units) {
    static const uint16_t pairs[32] = {0, 16, 1, 17, 2,  18, 3,  19, 4,  20, 5,  21, 6,  22, 7,  23,
                                       8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31};
    __m512bh both = _mm512_cvtne2ps_pbh(_mm512_maskz_loadu_ps(there, odd), _mm512_maskz_loadu_ps(there, even));
    _mm512_mask_storeu_epi32(units, there, _mm512_permutexvar_epi16(_mm512_loadu_si512(pairs), (__m512i)both));
}

static void round_pair(size_t n, const float *even, const float *odd, size_t width, size_t step, uint32_t *units) {
    for (size_t first = 0; first < n; first += width, units += step) {
        const size_t there = n - first < width ? n - first : width;
        for (size_t i = 0; i < there; i += 16)
            round_columns(there - i < 16 ? (__mmask16)((1u << (there - i)) - 1) : 0xffff, even + first + i,
                          odd + first + i, units + i);
    }
}

#include "kernel/rows.h"

NQM_DEFINE_KERNELS(avx512_bf16, "avx512+bf16");
#endif
