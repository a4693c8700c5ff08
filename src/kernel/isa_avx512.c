/* SPDX-License-Identifier: MIT
 *
 * Kernels for x86-64 with AVX-512 (F, BW, DQ, VL): 32 registers of 64 bytes, 24 of which hold sums.
 */
#if defined __x86_64__
#include <immintrin.h>

#define VECTOR_BYTES        64
#define TILE_ROWS           12
#define TILE_VECTORS        2
#define MADD_F32(sum, a, b) ((vector_f)_mm512_fmadd_ps(_mm512_set1_ps(a), (__m512)(b), (__m512)(sum)))
#include "kernel/isa_products.h"

#include "kernel/isa_rows.h"

NQM_DEFINE_KERNELS(avx512, "avx512");
#endif
