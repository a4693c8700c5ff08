/* SPDX-License-Identifier: MIT
 *
 * Kernels for x86-64 with AVX2 and FMA: 16 registers of 32 bytes, 12 of which hold sums. A tile is as wide as a panel, so that panels
 * are read in order: caches fetch every second line of one much later.
 */
#if defined __x86_64__
#include <immintrin.h>

#define VECTOR_BYTES         32
#define TILE_ROWS            3
#define TILE_VECTORS         4
#define PART_WORDS           200 /* 25 KB of a panel: fits into an L1 cache of 32 KB with the rows of a tile */
#define MADD_F32(sum, a, b)  ((vector_f)_mm256_fmadd_ps(_mm256_set1_ps(a), (__m256)(b), (__m256)(sum)))
#define MADD_INT8(sum, a, b) ((vector_i)madd_bytes((__m256i)(sum), _mm256_set1_epi32((int)(a)), (__m256i)(b)))

/* Even and odd bytes as 16-bit integers, so that no product saturates: VPMADDUBSW would. */
static inline __attribute__((always_inline)) __m256i madd_bytes(__m256i sum, __m256i a, __m256i b) {
    const __m256i a_even = _mm256_and_si256(a, _mm256_set1_epi16(255)), a_odd = _mm256_srli_epi16(a, 8);
    const __m256i b_even = _mm256_srai_epi16(_mm256_slli_epi16(b, 8), 8), b_odd = _mm256_srai_epi16(b, 8);
    sum = _mm256_add_epi32(sum, _mm256_madd_epi16(a_even, b_even));
    return _mm256_add_epi32(sum, _mm256_madd_epi16(a_odd, b_odd));
}

#include "kernel/tiles.h"

#include "kernel/rows.h"

NQM_DEFINE_KERNELS(avx2, "avx2");
#endif
