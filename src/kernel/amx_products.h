/* SPDX-License-Identifier: MIT
 *
 * amx_products.h - products of bfloat16 and of bytes, and the weight gradient of bfloat16, by Intel's tile registers (AMX). It is
 * included by isa_amx.c, and by the tests over an emulation of the instructions. Both define these first, where t, c, a and b are
 * the literal numbers of tile registers (Intel 64 and IA-32 Architectures Software Developer's Manual, volume 2):
 *
 * TILE_CONFIGURE(from), TILE_CONFIGURATION(to)   LDTILECFG, STTILECFG: 64 bytes
 * TILE_ZERO(t)                                   t = 0
 * TILE_LOAD(t, from, step), TILE_STORE(t, to, step)  rows of t from and to memory, `step` bytes from row to row
 * TILE_BF16(c, a, b), TILE_INT8(c, a, b)         c += a b: TDPBF16PS, TDPBUSD
 *
 * A tile register has up to 16 rows of up to 16 words. The right factor in panels, and the left factor in rows, have the layout of
 * these instructions. Edges are tile registers with fewer rows or words, so nothing beyond a matrix is read.
 *
 * An element of C depends only on its row of A, its column of B and where k is cut into multiples of 16 words from the first:
 * the products of 16 words are summed and added to C. Therefore all cuts of rows and columns give the same bits, and so does any
 * number of threads; a product that is continued (`add`) does if its first part has a multiple of 16 words.
 */
#include "kernel/kernel.h"
#include "kernel/transpose.h"

#include <string.h>

/* A block of C is 2 x 2 tile registers. */
#define C_00 0
#define C_01 1
#define C_10 2
#define C_11 3
#define A_0  4
#define A_1  5
#define B_0  6
#define B_1  7

#define INLINE static inline __attribute__((always_inline))

enum {
    EDGE = 16, /* rows of a tile register, words of its rows */
    BLOCK = 2 * EDGE,
    GRADIENT_WORDS = 256,                    /* of the right factor, transposed at a time: they stay in the L1 cache */
    GRADIENT_STRIDE = GRADIENT_WORDS + EDGE, /* an odd number of cache lines */
    LINE = 16                                /* floats of a cache line */
};

_Static_assert((int)NQM_PANEL == (int)BLOCK && (int)NQM_STRIP <= (int)EDGE,
               "a panel has two tile registers across, a strip one");

/* The operand of LDTILECFG. */
typedef struct configuration {
    uint8_t palette, start_row, reserved[14];
    uint16_t row_bytes[16];
    uint8_t rows[16];
} configuration;

_Static_assert(sizeof(configuration) == 64, "the layout of the processor");

/* The tile registers during a call of a kernel. The caller's configuration is restored at the end, so that a program may use
 * tile registers itself; their contents are lost, as in any call of a function (System V ABI). */
typedef struct session {
    configuration caller;
    size_t rows, columns, depth; /* configured: of C, and words of A; 0: nothing yet */
} session;

/* Some compilers do not know that the instructions above access memory: order them with C code's accesses to *p and to all
 * memory that others may have the address of. */
#define ORDER_MEMORY(p) __asm__ volatile("" ::"r"(p) : "memory")

static void begin(session *s) {
    *s = (session){.rows = 0};
    ORDER_MEMORY(s);
    TILE_CONFIGURATION(&s->caller);
    ORDER_MEMORY(s);
}

static void end(session *s) {
    ORDER_MEMORY(s);
    TILE_CONFIGURE(&s->caller);
    ORDER_MEMORY(s);
}

static void shape(configuration *c, size_t t, size_t rows, size_t words) {
    if (rows > 0 && words > 0) { /* both are 0 in an unused register */
        c->rows[t] = (uint8_t)rows;
        c->row_bytes[t] = (uint16_t)(4 * words);
    }
}

/* Prepare for blocks of C (rows, columns) and `depth` words of A at a time. */
static void configure(session *s, size_t rows, size_t columns, size_t depth) {
    if (s->rows == rows && s->columns == columns && s->depth == depth)
        return;
    const size_t down[2] = {nqm_smaller(rows, EDGE), rows - nqm_smaller(rows, EDGE)};
    const size_t across[2] = {nqm_smaller(columns, EDGE), columns - nqm_smaller(columns, EDGE)};
    configuration c = {.palette = 1};
    for (size_t i = 0; i < 2; ++i) {
        shape(&c, A_0 + i, down[i], depth);
        shape(&c, B_0 + i, depth, across[i]);
        for (size_t j = 0; j < 2; ++j)
            shape(&c, C_00 + 2 * i + j, down[i], across[j]);
    }
    s->rows = rows, s->columns = columns, s->depth = depth;
    ORDER_MEMORY(&c);
    TILE_CONFIGURE(&c);
    ORDER_MEMORY(&c);
}

/* C (m, columns) = A B, or C + A B; columns <= BLOCK. */
typedef struct operands {
    size_t m, columns, words;
    bool add;
    const uint32_t *a, *b;
    uint32_t *c; /* float or int32_t */
    size_t lda, ldb, ldc;
} operands;

/* A block of at most BLOCK rows, where `words` is a multiple of depth; tall, wide: it has more than EDGE rows, columns. The first
 * three parameters are constants where this is inlined. */
INLINE void multiply_block(nqm_precision precision, bool tall, bool wide, size_t depth, const operands *o) {
    const size_t a_step = 4 * o->lda, b_step = 4 * o->ldb, c_step = 4 * o->ldc;
    uint32_t *c = o->c, *c_low = c + EDGE * o->ldc;
#define EACH_C(DO, ...)                                                                                                \
    DO(C_00, c, __VA_ARGS__);                                                                                          \
    if (wide)                                                                                                          \
        DO(C_01, c + EDGE, __VA_ARGS__);                                                                               \
    if (tall)                                                                                                          \
        DO(C_10, c_low, __VA_ARGS__);                                                                                  \
    if (tall && wide)                                                                                                  \
    DO(C_11, c_low + EDGE, __VA_ARGS__)
#define MADD(c, a, b)                                                                                                  \
    if (precision == NQM_PRECISION_BF16)                                                                               \
        TILE_BF16(c, a, b);                                                                                            \
    else                                                                                                               \
        TILE_INT8(c, a, b)
#define ZERO(t, ...) TILE_ZERO(t)
    ORDER_MEMORY(c);
    if (o->add) {
        EACH_C(TILE_LOAD, c_step);
    } else {
        EACH_C(ZERO, 0);
    }
    const uint32_t *a = o->a, *b = o->b;
    for (size_t u = 0; u < o->words; u += depth, a += depth, b += depth * o->ldb) {
        TILE_LOAD(A_0, a, a_step);
        TILE_LOAD(B_0, b, b_step);
        MADD(C_00, A_0, B_0);
        if (wide) {
            TILE_LOAD(B_1, b + EDGE, b_step);
            MADD(C_01, A_0, B_1);
        }
        if (tall) {
            TILE_LOAD(A_1, a + EDGE * o->lda, a_step);
            MADD(C_10, A_1, B_0);
        }
        if (tall && wide) {
            MADD(C_11, A_1, B_1);
        }
    }
    EACH_C(TILE_STORE, c_step);
#undef ZERO
#undef MADD
#undef EACH_C
}

/* All rows, where `words` is a multiple of depth. */
INLINE void multiply_rows(nqm_precision precision, session *s, size_t depth, operands o) {
    const size_t m = o.m;
    for (size_t row = 0; row < m; row += BLOCK, o.a += BLOCK * o.lda, o.c += BLOCK * o.ldc) {
        const size_t rows = nqm_smaller(m - row, BLOCK);
        configure(s, rows, o.columns, depth);
        if (o.columns <= EDGE && rows > EDGE)
            multiply_block(precision, true, false, depth, &o);
        else if (o.columns <= EDGE)
            multiply_block(precision, false, false, depth, &o);
        else if (rows > EDGE)
            multiply_block(precision, true, true, depth, &o);
        else
            multiply_block(precision, false, true, depth, &o);
    }
}

/* The last words, fewer than EDGE, in a second pass: a new configuration clears all tile registers. */
INLINE void multiply(nqm_precision precision, session *s, operands o) {
    const size_t last = o.words % EDGE, whole = o.words - last;
    o.words = whole;
    if (whole > 0)
        multiply_rows(precision, s, EDGE, o);
    o.words = last;
    o.a += whole;
    o.b += whole * o.ldb;
    o.add = o.add || whole > 0;
    if (last > 0)
        multiply_rows(precision, s, last, o);
}

INLINE void multiply_panels(nqm_precision precision, const nqm_product *p) {
    session s;
    begin(&s);
    for (size_t i = 0; i < p->n_panels; ++i)
        multiply(precision, &s,
                 (operands){.m = p->m,
                            .columns = NQM_PANEL,
                            .words = p->words,
                            .add = p->add,
                            .a = p->a,
                            .b = (const uint32_t *)p->b + i * p->panel_step,
                            .c = (uint32_t *)p->c + i * NQM_PANEL,
                            .lda = p->lda,
                            .ldb = NQM_PANEL,
                            .ldc = p->ldc});
    end(&s);
}

static void amx_product_bf16(const nqm_product *p) {
    multiply_panels(NQM_PRECISION_BF16, p);
}

static void amx_product_int8(const nqm_product *p) {
    multiply_panels(NQM_PRECISION_INT8, p);
}

/* The transposed tiles are right^T left: strips have the layout of a right factor, and `right` is transposed once for all. */
static void amx_gradient_bf16(const nqm_tile_gradient *g) {
    enum { TILE = NQM_STRIP * NQM_PANEL };
    _Alignas(64) uint32_t right[NQM_PANEL * GRADIENT_STRIDE];
    session s;
    begin(&s);
    for (size_t first = 0; first < g->words; first += GRADIENT_WORDS) {
        const size_t words = nqm_smaller(g->words - first, GRADIENT_WORDS);
        nqm_transpose_words(words, NQM_PANEL, (const uint32_t *)g->right + first * NQM_PANEL, NQM_PANEL, right,
                            GRADIENT_STRIDE);
        for (size_t strip = 0; strip < g->n_strips; ++strip) {
            for (size_t i = 0; first == 0 && i < NQM_PREFETCH * TILE; i += LINE)
                __builtin_prefetch(g->prefetch[i / TILE] + strip * TILE + i % TILE, 0, 2);
            multiply(NQM_PRECISION_BF16, &s,
                     (operands){.m = NQM_PANEL,
                                .columns = NQM_STRIP,
                                .words = words,
                                .add = first > 0,
                                .a = right,
                                .b = (const uint32_t *)g->left + strip * g->step + first * NQM_STRIP,
                                .c = (uint32_t *)(void *)(g->c + strip * TILE),
                                .lda = GRADIENT_STRIDE,
                                .ldb = NQM_STRIP,
                                .ldc = NQM_STRIP});
        }
    }
    end(&s);
    for (size_t strip = 0; strip < g->n_strips; ++strip) { /* each in its place */
        uint32_t tile[TILE];
        memcpy(tile, g->c + strip * TILE, sizeof tile);
        nqm_transpose_words(NQM_PANEL, NQM_STRIP, tile, NQM_STRIP, (uint32_t *)(void *)(g->c + strip * TILE),
                            NQM_PANEL);
    }
}

/* The kernels of `base` with these products. */
static nqm_kernels with_amx_products(const nqm_kernels *base, const char *name) {
    nqm_kernels kernels = *base;
    kernels.name = name;
    kernels.product[NQM_PRECISION_BF16] = amx_product_bf16;
    kernels.product[NQM_PRECISION_INT8] = amx_product_int8;
    kernels.gradient[NQM_PRECISION_BF16] = amx_gradient_bf16;
    return kernels;
}
