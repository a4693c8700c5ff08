/* SPDX-License-Identifier: MIT
 *
 * Kernels for x86-64 with AVX2 and FMA: 16 registers of 32 bytes, 12 of which hold sums.
 */
#if defined __x86_64__
#include <immintrin.h>

#define VECTOR_BYTES        32
#define TILE_ROWS           6
#define TILE_VECTORS        2
#define MADD_F32(sum, a, b) ((vector_f)_mm256_fmadd_ps(_mm256_set1_ps(a), (__m256)(b), (__m256)(sum)))
#include "kernel/tiles.h"

#include "kernel/rows.h"

NQM_DEFINE_KERNELS(avx2, "avx2");
#endif
