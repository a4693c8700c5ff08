/* SPDX-License-Identifier: MIT
 *
 * Kernels for x86-64 with AVX2 and FMA: 16 registers of 32 bytes, 12 of which hold sums. A tile is as wide as a panel,
 * so that panels are read in order: caches fetch every second line of one much later.
 */
#if defined __x86_64__
#include <immintrin.h>

#define VECTOR_BYTES        32
#define TILE_ROWS           3
#define TILE_VECTORS        4
#define PART_WORDS          200 /* 25 KB of a panel: fits into an L1 cache of 32 KB with the rows of a tile */
#define MADD_F32(sum, a, b) ((vector_f)_mm256_fmadd_ps(_mm256_set1_ps(a), (__m256)(b), (__m256)(sum)))
#include "kernel/isa_products.h"

#include "kernel/isa_rows.h"

NQM_DEFINE_KERNELS(avx2, "avx2");
#endif
