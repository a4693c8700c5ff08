/* SPDX-License-Identifier: MIT
 *
 * Kernels in vectors of 16 bytes, for every machine of the build's target.
 */
#define VECTOR_BYTES 16
#ifdef __ARM_NEON
#include <arm_neon.h>
#define TILE_ROWS           4 /* 16 of 32 registers hold sums: with more, compilers spill */
#define TILE_VECTORS        4
#define MADD_F32(sum, a, b) ((vector_f)vfmaq_n_f32((float32x4_t)(sum), (float32x4_t)(b), a))
#else
#define TILE_ROWS           4 /* 8 of 16 registers hold sums: SSE instructions overwrite an operand */
#define TILE_VECTORS        2
#define MADD_F32(sum, a, b) ((sum) + (a) * (b))
#ifdef __SSE2__
#include <emmintrin.h>
#define MADD_INT16(sum, x, y) ((sum) + (vector_i)_mm_madd_epi16((__m128i)(x), (__m128i)(y)))
#endif
#endif
#include "kernel/isa_products.h"

#include "kernel/isa_rows.h"

NQM_DEFINE_KERNELS(generic, "generic");
