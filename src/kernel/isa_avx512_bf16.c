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
#include "kernel/isa_products.h"

/* Rounding by the processor's instruction, which flushes denormals to 0, as its products do. */
#define NQM_NATIVE_ROUNDING
static void round_row(size_t n, const float *x, uint32_t *words) {
    enum { AT_ONCE = 32 };
    size_t i = 0;
    for (; i + AT_ONCE <= n; i += AT_ONCE) {
        __m512bh both = _mm512_cvtne2ps_pbh(_mm512_loadu_ps(x + i + 16), _mm512_loadu_ps(x + i));
        _mm512_storeu_si512(words + i / 2, (__m512i)both);
    }
    const size_t left = n - i, n_low = left < 16 ? left : 16;
    const __mmask16 low = (__mmask16)((1u << n_low) - 1), high = (__mmask16)((1u << (left - n_low)) - 1);
    const __mmask16 out = (__mmask16)((1u << (left + 1) / 2) - 1);
    /* With left = 0 all masks are 0: nothing is read or written. */
    __m512bh both = _mm512_cvtne2ps_pbh(_mm512_maskz_loadu_ps(high, x + i + n_low), _mm512_maskz_loadu_ps(low, x + i));
    _mm512_mask_storeu_epi32(words + i / 2, out, (__m512i)both);
}

enum { COLUMNS = 16 };

static inline __mmask16 first_columns(size_t n) {
    return (__mmask16)(n < COLUMNS ? (1u << n) - 1 : 0xffffu);
}

/* n groups of `width` columns of two rows; inlined with a constant width. */
INLINE void round_groups(size_t n, size_t width, const float *even, const float *odd, size_t step, uint32_t *words) {
    static const uint16_t pairs[32] = {0, 16, 1, 17, 2,  18, 3,  19, 4,  20, 5,  21, 6,  22, 7,  23,
                                       8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31};
    const __m512i order = _mm512_loadu_si512(pairs);
    for (size_t g = 0; g < n; ++g, even += width, odd += width, words += step)
        for (size_t i = 0; i < width; i += COLUMNS) {
            const __mmask16 mask = first_columns(width - i);
            __m512bh both =
                _mm512_cvtne2ps_pbh(_mm512_maskz_loadu_ps(mask, odd + i), _mm512_maskz_loadu_ps(mask, even + i));
            _mm512_mask_storeu_epi32(words + i, mask, _mm512_permutexvar_epi16(order, (__m512i)both));
        }
}

static void round_pair(size_t n, const float *even, const float *odd, size_t width, size_t step, uint32_t *words) {
    const size_t whole = n / width, at = whole * width;
    if (width == NQM_STRIP)
        round_groups(whole, NQM_STRIP, even, odd, step, words);
    else
        round_groups(whole, NQM_PANEL, even, odd, step, words);
    if (at < n) {
        words += whole * step;
        memset(words, 0, width * sizeof *words);
        round_groups(1, n - at, even + at, odd + at, 0, words);
    }
}

static void round_tile(const float *x, uint32_t *words) {
    for (size_t i = 0; i < NQM_STRIP / 2; ++i, x += 2 * NQM_PANEL)
        round_groups(1, NQM_PANEL, x, x + NQM_PANEL, 0, words + i * NQM_PANEL);
}

#include "kernel/isa_rows.h"

NQM_DEFINE_KERNELS(avx512_bf16, "avx512+bf16");
#endif
