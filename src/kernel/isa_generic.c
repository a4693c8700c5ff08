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
#endif
#include "kernel/isa_products.h"

#include "kernel/isa_rows.h"

NQM_DEFINE_KERNELS(generic, "generic");
