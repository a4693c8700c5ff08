/* SPDX-License-Identifier: MIT
 *
 * isa_products.h - the matrix products of kernel.h for one instruction set. A file isa_*.c defines these and includes this file:
 *
 * VECTOR_BYTES           size of a vector register
 * TILE_ROWS, TILE_VECTORS  a tile of C is TILE_ROWS rows of TILE_VECTORS registers, all of which hold sums
 * PART_WORDS             optional: words of a panel that are multiplied with all rows before the next, so that they stay in the
 *                        L1 cache
 * MADD_F32(sum, a, b)    sum + a b for vectors sum and b of float and one float a
 * MADD_BF16(sum, a, b)   sum + a b for vectors sum of float, b of 32-bit words with two bfloat16 each, and one word a
 *
 * The functions themselves are in isa_precision.h, which is compiled once for each precision. Vectors are types of GCC and Clang,
 * so that one source serves every instruction set.
 */
#include "kernel/kernel.h"

#include <string.h>

#ifdef NQM_SANITIZED /* each access becomes many instructions: small tiles do the same operations, and compile */
#undef TILE_ROWS
#undef TILE_VECTORS
#define TILE_ROWS    2
#define TILE_VECTORS 1
#endif

#ifndef PART_WORDS
#define PART_WORDS SIZE_MAX
#endif

typedef float vector_f __attribute__((vector_size(VECTOR_BYTES), aligned(4), may_alias));
typedef uint32_t vector_u __attribute__((vector_size(VECTOR_BYTES), aligned(4), may_alias));

enum { LANES = VECTOR_BYTES / 4, TILE_COLUMNS = LANES * TILE_VECTORS };

#define UNROLL _Pragma("GCC unroll 16")
#define INLINE static inline __attribute__((always_inline))

#ifndef MADD_BF16 /* for processors without bfloat16: the same two steps in float, whose products are exact */
#define MADD_BF16 madd_bf16
INLINE vector_f madd_bf16(vector_f sum, uint32_t a, vector_u b) {
    float low, high;
    uint32_t low_bits = a << 16, high_bits = a & 0xffff0000u;
    memcpy(&low, &low_bits, sizeof low);
    memcpy(&high, &high_bits, sizeof high);
    sum = MADD_F32(sum, high, (vector_f)(b & 0xffff0000u));
    return MADD_F32(sum, low, (vector_f)(b << 16));
}
#endif

#define TILE_PASTE(name, precision)  name##_##precision
#define TILE_EXPAND(name, precision) TILE_PASTE(name, precision)
#define NAME(name)                   TILE_EXPAND(name, PRECISION)

enum {
    PANEL_VECTORS = NQM_PANEL / LANES,
    TILE_SUMS = TILE_ROWS * TILE_VECTORS,
    ROW_PANELS = PANEL_VECTORS < 8 ? 8 / PANEL_VECTORS : 1,       /* panels of a row product: eight registers of sums */
    LINE = 16,                                                    /* floats of a cache line */
    PREFETCH_LINES = (TILE_ROWS * TILE_COLUMNS + LINE - 1) / LINE /* of a tile */
};

_Static_assert(NQM_STRIP % TILE_ROWS == 0 && NQM_PANEL % TILE_COLUMNS == 0, "tiles fill strips and panels");

#define PRECISION f32
#define WORD      float
#define RIGHT     vector_f
#define MADD      MADD_F32
#include "kernel/isa_precision.h"

#define PRECISION bf16
#define WORD      uint32_t
#define RIGHT     vector_u
#define MADD      MADD_BF16
#include "kernel/isa_precision.h"

static void strided_product(const nqm_strided_product *p) {
    tile_f32 t = {.vectors = TILE_VECTORS,
                  .words = p->k,
                  .a = p->a,
                  .row_step = p->lda,
                  .word_step = p->step,
                  .b = p->b,
                  .ldb = p->ldb,
                  .c = p->c,
                  .ldc = p->ldc,
                  .add = p->add};
    for (size_t column = 0; column < NQM_PANEL; column += TILE_COLUMNS) {
        multiply_rows_f32(t, p->m);
        t.b += TILE_COLUMNS;
        t.c += TILE_COLUMNS;
    }
}
