/* SPDX-License-Identifier: MIT
 *
 * Kernels for x86-64 with AVX-512 and its products of bfloat16 (BF16).
 */
#if defined __x86_64__
#include <immintrin.h>

#define VECTOR_BYTES        64
#define TILE_ROWS           12
#define TILE_VECTORS        2
#define MADD_F32(sum, a, b) ((vector_f)_mm512_fmadd_ps(_mm512_set1_ps(a), (__m512)(b), (__m512)(sum)))
#define MADD_BF16(sum, a, b)                                                                                           \
    ((vector_f)_mm512_dpbf16_ps((__m512)(sum), (__m512bh)_mm512_set1_epi32((int)(a)), (__m512bh)(b)))
#include "kernel/isa_products.h"

#include "kernel/isa_rows.h"

NQM_DEFINE_KERNELS(avx512_bf16, "avx512+bf16");
#endif
