/* SPDX-License-Identifier: MIT
 *
 * tiles.h - the products of kernel.h for one instruction set. A file isa_*.c defines the parameters and includes this:
 *
 * VECTOR_BYTES           of a register
 * TILE_ROWS, TILE_VECTORS  rows and registers a row of the part of C that is summed in registers
 * MADD_F32(sum, a, b)    sum + a b: a a float, b and sum vectors of float
 * MADD_BF16(sum, a, b)   the same for both halves of units of bfloat16
 * MADD_INT8(sum, a, b)   the same for the four quarters of units, a unsigned, b signed; sum a vector of int32_t
 *
 * Vectors are GCC's and Clang's own types, so that one text serves all: the tile's loops are unrolled, its sums stay in
 * registers, and each unit of A is spread over a vector as it is read.
 */
#include "kernel/kernel.h"

#include <string.h>

#ifdef __SANITIZE_ADDRESS__ /* each access becomes many instructions: small tiles do the same operations, and compile */
#undef TILE_ROWS
#undef TILE_VECTORS
#define TILE_ROWS    2
#define TILE_VECTORS 1
#endif

typedef float vector_f __attribute__((vector_size(VECTOR_BYTES), aligned(4), may_alias));
typedef int32_t vector_i __attribute__((vector_size(VECTOR_BYTES), aligned(4), may_alias));
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

#ifndef MADD_INT8
#define MADD_INT8 madd_int8
INLINE vector_i madd_int8(vector_i sum, uint32_t a, vector_i b) {
    sum += (int32_t)(a & 255) * (b << 24 >> 24);
    sum += (int32_t)(a >> 8 & 255) * (b << 16 >> 24);
    sum += (int32_t)(a >> 16 & 255) * (b << 8 >> 24);
    return sum + (int32_t)(a >> 24) * (b >> 24);
}
#endif

/* Types cannot stand in parentheses; where a tile is small, some cases of what may be left are alike. */
/* NOLINTBEGIN(bugprone-macro-parentheses, bugprone-branch-clone) */

/* C (rows, TILE_COLUMNS) = A B, or C + A B. Known constants where it is inlined: all but the pointers and their steps. */
typedef struct tile {
    size_t rows, units;
    const void *a; /* unit u of row i: row_step i + unit_step u units on */
    size_t row_step, unit_step;
    const void *b; /* (units, TILE_COLUMNS), ldb units from row to row */
    size_t ldb;
    void *c;
    size_t ldc;
    bool add;
    size_t ahead; /* so many units on from each of A is asked for: no processor guesses what lies far apart; 0: not */
    const float *const *wanted; /* NQM_WANTED arrays, a line of which is asked for now and then; NULL: none */
    bool beside;                /* one row more, one_c = one_a one_b, with units as neighbours and panels like b */
    const void *one_a, *one_b;
    void *one_c;
} tile;

enum { LINE = 16, WANTED_LINES = NQM_STRIP * NQM_PANEL / LINE };

#define DEFINE_TILE(NAME, UNIT, VECTOR_B, NUMBER, VECTOR_C, MADD)                                                      \
    INLINE void NAME(tile t) {                                                                                         \
        const UNIT *restrict a = t.a, *restrict b = t.b;                                                               \
        NUMBER *restrict c = t.c;                                                                                      \
        const size_t slice = t.wanted ? (t.units + WANTED_LINES - 1) / WANTED_LINES : t.units;                         \
        const UNIT *restrict one_a = t.one_a, *restrict one_b = t.one_b;                                               \
        NUMBER *restrict one_c = t.one_c;                                                                              \
        VECTOR_C sum[TILE_ROWS][TILE_VECTORS], one[TILE_VECTORS] = {{0}};                                              \
        UNROLL for (size_t i = 0; i < t.rows; ++i) UNROLL for (size_t j = 0; j < TILE_VECTORS; ++j) sum[i][j] =        \
            t.add ? *(const VECTOR_C *)(c + i * t.ldc + j * LANES) : (VECTOR_C){0};                                    \
        for (size_t u = 0, line = 0; u < t.units; ++line) {                                                            \
            for (size_t i = 0; t.wanted && i < NQM_WANTED; ++i)                                                        \
                __builtin_prefetch(t.wanted[i] + line * LINE, 0, 2);                                                   \
            for (size_t end = t.units - u < slice ? t.units : u + slice; u < end; ++u) {                               \
                VECTOR_B right[TILE_VECTORS];                                                                          \
                UNROLL for (size_t j = 0; j < TILE_VECTORS; ++j) right[j] = *(const VECTOR_B *)(b + j * LANES);        \
                if (t.ahead)                                                                                           \
                    __builtin_prefetch(a + t.ahead, 0, 2);                                                             \
                UNROLL for (size_t i = 0; i < t.rows; ++i) {                                                           \
                    UNIT left = a[i * t.row_step];                                                                     \
                    UNROLL for (size_t j = 0; j < TILE_VECTORS; ++j) sum[i][j] = MADD(sum[i][j], left, right[j]);      \
                }                                                                                                      \
                if (t.beside) {                                                                                        \
                    UNROLL for (size_t j = 0; j < TILE_VECTORS; ++j) one[j] =                                          \
                        MADD(one[j], *one_a, *(const VECTOR_B *)(one_b + j * LANES));                                  \
                    one_a += 1;                                                                                        \
                    one_b += t.ldb;                                                                                    \
                }                                                                                                      \
                a += t.unit_step;                                                                                      \
                b += t.ldb;                                                                                            \
            }                                                                                                          \
        }                                                                                                              \
        UNROLL for (size_t i = 0; i < t.rows; ++i) UNROLL for (size_t j = 0; j < TILE_VECTORS; ++j) *                  \
            (VECTOR_C *)(c + i * t.ldc + j * LANES) = sum[i][j];                                                       \
        if (t.beside)                                                                                                  \
            UNROLL for (size_t j = 0; j < TILE_VECTORS; ++j) * (VECTOR_C *)(one_c + j * LANES) = one[j];               \
    }

DEFINE_TILE(tile_f32, float, vector_f, float, vector_f, MADD_F32)
DEFINE_TILE(tile_bf16, uint32_t, vector_u, float, vector_f, MADD_BF16)
DEFINE_TILE(tile_int8, uint32_t, vector_i, int32_t, vector_i, MADD_INT8)

/* Rows in tiles, the rest in one that is as high as it must be. */
#define PRODUCT_TILE(ROWS, BESIDE, TILE, UNIT, NUMBER)                                                                 \
    TILE((tile){.rows = (ROWS),                                                                                        \
                .units = p->units,                                                                                     \
                .a = (const UNIT *)p->a + i * p->lda,                                                                  \
                .row_step = p->lda,                                                                                    \
                .unit_step = 1,                                                                                        \
                .b = (const UNIT *)p->b + column,                                                                      \
                .ldb = NQM_PANEL,                                                                                      \
                .c = (NUMBER *)p->c + i * p->ldc + column,                                                             \
                .ldc = p->ldc,                                                                                         \
                .add = p->add,                                                                                         \
                .beside = (BESIDE),                                                                                    \
                .one_a = p->one_a,                                                                                     \
                .one_b = (BESIDE) ? (const UNIT *)p->one_b + column : NULL,                                            \
                .one_c = (BESIDE) ? (NUMBER *)p->one_c + column : NULL})
#define REST(N, TILE, UNIT, NUMBER)                                                                                    \
    case N:                                                                                                            \
        if (p->one_a)                                                                                                  \
            PRODUCT_TILE(N < TILE_ROWS ? N : 1, true, TILE, UNIT, NUMBER);                                             \
        else if (N > 0)                                                                                                \
            PRODUCT_TILE(N < TILE_ROWS ? N : 1, false, TILE, UNIT, NUMBER);                                            \
        break;

#define DEFINE_PRODUCT(NAME, TILE, UNIT, NUMBER)                                                                       \
    static void NAME(const nqm_product *p) {                                                                           \
        for (size_t column = 0; column < NQM_PANEL; column += TILE_COLUMNS) {                                          \
            size_t i = 0;                                                                                              \
            for (; i + TILE_ROWS <= p->m; i += TILE_ROWS)                                                              \
                PRODUCT_TILE(TILE_ROWS, false, TILE, UNIT, NUMBER);                                                    \
            switch (p->m - i) { /* fewer than TILE_ROWS */                                                             \
                REST(0, TILE, UNIT, NUMBER)                                                                            \
                REST(1, TILE, UNIT, NUMBER)                                                                            \
                REST(2, TILE, UNIT, NUMBER)                                                                            \
                REST(3, TILE, UNIT, NUMBER)                                                                            \
                REST(4, TILE, UNIT, NUMBER)                                                                            \
                REST(5, TILE, UNIT, NUMBER)                                                                            \
                REST(6, TILE, UNIT, NUMBER)                                                                            \
                REST(7, TILE, UNIT, NUMBER)                                                                            \
                REST(8, TILE, UNIT, NUMBER)                                                                            \
                REST(9, TILE, UNIT, NUMBER)                                                                            \
                REST(10, TILE, UNIT, NUMBER)                                                                           \
                REST(11, TILE, UNIT, NUMBER)                                                                           \
            default:                                                                                                   \
                break;                                                                                                 \
            }                                                                                                          \
        }                                                                                                              \
    }

_Static_assert(TILE_ROWS <= 12, "REST covers what may be left");
DEFINE_PRODUCT(product_f32, tile_f32, float, float)
DEFINE_PRODUCT(product_bf16, tile_bf16, uint32_t, float)
DEFINE_PRODUCT(product_int8, tile_int8, uint32_t, int32_t)

/* One row: ROW_PANELS panels side by side are eight registers of sums. */
enum { PANEL_VECTORS = NQM_PANEL / LANES, ROW_PANELS = PANEL_VECTORS < 8 ? 8 / PANEL_VECTORS : 1 };

#define DEFINE_ROW_PRODUCT(NAME, UNIT, VECTOR_B, NUMBER, VECTOR_C, MADD)                                               \
    INLINE void NAME##_panels(size_t n, const nqm_row_product *p, const UNIT *restrict b, NUMBER *restrict c) {        \
        const UNIT *restrict a = p->a;                                                                                 \
        VECTOR_C sum[ROW_PANELS * PANEL_VECTORS];                                                                      \
        UNROLL for (size_t i = 0; i < n * PANEL_VECTORS; ++i) sum[i] =                                                 \
            p->add ? *(const VECTOR_C *)(c + i * LANES) : (VECTOR_C){0};                                               \
        for (size_t u = 0; u < p->units; ++u)                                                                          \
            UNROLL for (size_t i = 0; i < n * PANEL_VECTORS; ++i) {                                                    \
                const UNIT *right = b + (i / PANEL_VECTORS * p->stride + u) * NQM_PANEL + i % PANEL_VECTORS * LANES;   \
                sum[i] = MADD(sum[i], a[u], *(const VECTOR_B *)right);                                                 \
            }                                                                                                          \
        UNROLL for (size_t i = 0; i < n * PANEL_VECTORS; ++i) * (VECTOR_C *)(c + i * LANES) = sum[i];                  \
    }                                                                                                                  \
    static void NAME(const nqm_row_product *p) {                                                                       \
        const UNIT *b = p->b;                                                                                          \
        NUMBER *c = p->c;                                                                                              \
        size_t panel = 0;                                                                                              \
        for (; panel + ROW_PANELS <= p->n_panels; panel += ROW_PANELS)                                                 \
            NAME##_panels(ROW_PANELS, p, b + panel * p->stride * NQM_PANEL, c + panel * NQM_PANEL);                    \
        for (; panel < p->n_panels; ++panel)                                                                           \
            NAME##_panels(1, p, b + panel * p->stride * NQM_PANEL, c + panel * NQM_PANEL);                             \
    }

DEFINE_ROW_PRODUCT(row_product_f32, float, vector_f, float, vector_f, MADD_F32)
DEFINE_ROW_PRODUCT(row_product_bf16, uint32_t, vector_u, float, vector_f, MADD_BF16)
DEFINE_ROW_PRODUCT(row_product_int8, uint32_t, vector_i, int32_t, vector_i, MADD_INT8)

#define DEFINE_GRADIENT(NAME, TILE, UNIT, AHEAD)                                                                       \
    static void NAME(const nqm_tile_gradient *g) {                                                                     \
        for (size_t column = 0; column < NQM_PANEL; column += TILE_COLUMNS)                                            \
            for (size_t i = 0; i < NQM_STRIP; i += TILE_ROWS)                                                          \
                TILE((tile){.rows = TILE_ROWS,                                                                         \
                            .units = g->units,                                                                         \
                            .a = (const UNIT *)g->left + i,                                                            \
                            .row_step = 1,                                                                             \
                            .unit_step = g->ld_left,                                                                   \
                            .b = (const UNIT *)g->right + column,                                                      \
                            .ldb = g->ld_right,                                                                        \
                            .c = g->c + i * NQM_PANEL + column,                                                        \
                            .ldc = NQM_PANEL,                                                                          \
                            .ahead = (AHEAD),                                                                          \
                            .wanted = g->wanted});                                                                     \
    }

_Static_assert(NQM_STRIP % TILE_ROWS == 0 && NQM_PANEL % TILE_COLUMNS == 0, "tiles fill strips and panels");
DEFINE_GRADIENT(gradient_f32, tile_f32, float, 2 * NQM_STRIP)
DEFINE_GRADIENT(gradient_bf16, tile_bf16, uint32_t, 0)
/* NOLINTEND(bugprone-macro-parentheses, bugprone-branch-clone) */
