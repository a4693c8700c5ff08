/* SPDX-License-Identifier: MIT
 *
 * widened.h - products of bytes and several panels for tiles.h, on processors without an instruction for bytes. (VPMADDUBSW of AVX2
 * saturates.) Bytes are widened to 16 bits once for all rows and panels: a word of four bytes becomes a word of the even bytes and one
 * of the odd bytes. The innermost loop then only loads, multiplies and adds, from buffers in the L1 and L2 caches.
 */
enum {
    WIDE_WORDS = 64, /* of a row at a time: 16 KB of a panel, half of an L1 cache */
    WIDE_STRIPS = 8 * NQM_STRIP / TILE_ROWS
};

/* TILE_ROWS rows of the left factor, at most WIDE_WORDS of each: even bytes, then odd bytes. */
typedef struct wide_rows {
    _Alignas(64) vector_s words[2][TILE_ROWS][WIDE_WORDS / LANES];
} wide_rows;

/* A panel of the right factor, of at most WIDE_WORDS rows. */
typedef struct wide_panel {
    _Alignas(64) vector_s words[2][WIDE_WORDS][PANEL_VECTORS];
} wide_panel;

static void widen_row(size_t n, const uint32_t *words, size_t row, wide_rows *to) {
    for (size_t u = 0; u < n; u += LANES) {
        vector_h a = {0};
        if (n - u >= LANES)
            a = *(const vector_h *)(words + u);
        else
            memcpy(&a, words + u, (n - u) * sizeof *words);
        to->words[0][row][u / LANES] = (vector_s)(a & 255);
        to->words[1][row][u / LANES] = (vector_s)(a >> 8);
    }
}

static void widen_panel(size_t n, const uint32_t *words, wide_panel *to) {
    for (size_t u = 0; u < n; ++u)
        UNROLL for (size_t j = 0; j < PANEL_VECTORS; ++j) {
            const vector_i b = *(const vector_i *)(words + u * NQM_PANEL + j * LANES);
            to->words[0][u][j] = even_bytes(b);
            to->words[1][u][j] = odd_bytes(b);
        }
}

/* c (TILE_ROWS, TILE_COLUMNS) = the product of n words with the columns from vector `first` on, or c + this. */
static void multiply_wide(size_t n, const wide_rows *left, const wide_panel *right, size_t first, bool add,
                          int32_t *restrict c, size_t ldc) {
    vector_i sum[TILE_ROWS][TILE_VECTORS];
    UNROLL for (size_t i = 0; i < TILE_ROWS; ++i) UNROLL for (size_t j = 0; j < TILE_VECTORS; ++j) sum[i][j] =
        add ? *(const vector_i *)(c + i * ldc + j * LANES) : (vector_i){0};
    for (size_t odd = 0; odd < 2; ++odd) {
        const vector_word *a = (const vector_word *)left->words[odd];
        for (size_t u = 0; u < n; ++u) {
            vector_s b[TILE_VECTORS];
            UNROLL for (size_t j = 0; j < TILE_VECTORS; ++j) b[j] = right->words[odd][u][first + j];
            UNROLL for (size_t i = 0; i < TILE_ROWS; ++i) {
                const vector_s word = splat(a[i * WIDE_WORDS + u]);
                UNROLL for (size_t j = 0; j < TILE_VECTORS; ++j) sum[i][j] = MADD_INT16(sum[i][j], word, b[j]);
            }
        }
    }
    UNROLL for (size_t i = 0; i < TILE_ROWS; ++i) UNROLL for (size_t j = 0; j < TILE_VECTORS; ++j) *
        (vector_i *)(c + i * ldc + j * LANES) = sum[i][j];
}

/* Rows times n panels; a multiple of TILE_ROWS, at most WIDE_STRIPS of them. */
static void multiply_strips(const nqm_product *p, size_t n, size_t stride, size_t step) {
    wide_rows left[WIDE_STRIPS];
    wide_panel right;
    for (size_t word = 0; word < p->words; word += WIDE_WORDS) {
        const size_t n_words = nqm_smaller(p->words - word, WIDE_WORDS);
        for (size_t row = 0; row < p->m; ++row)
            widen_row(n_words, (const uint32_t *)p->a + row * p->lda + word, row % TILE_ROWS, &left[row / TILE_ROWS]);
        for (size_t panel = 0; panel < n; ++panel) {
            widen_panel(n_words, (const uint32_t *)p->b + (panel * stride + word) * NQM_PANEL, &right);
            int32_t *c = (int32_t *)p->c + panel * step;
            for (size_t row = 0; row < p->m; row += TILE_ROWS, c += TILE_ROWS * p->ldc)
                for (size_t j = 0; j < PANEL_VECTORS; j += TILE_VECTORS)
                    multiply_wide(n_words, &left[row / TILE_ROWS], &right, j, p->add || word > 0, c + j * LANES,
                                  p->ldc);
        }
    }
}

/* Rows [row, row + m) of a product. */
INLINE nqm_product rows_of_product(const nqm_product *p, size_t row, size_t m) {
    nqm_product part = *p;
    part.m = m;
    part.a = (const uint32_t *)p->a + row * p->lda;
    part.c = (int32_t *)p->c + row * p->ldc;
    return part;
}

/* Few rows, and those left over, are widened in registers: buffers would not pay. */
static void byte_panels(const nqm_product *p, size_t n, size_t stride, size_t step) {
    const size_t whole = p->m < 4 * TILE_ROWS ? 0 : p->m / TILE_ROWS * TILE_ROWS;
    for (size_t row = 0; row < whole; row += WIDE_STRIPS * TILE_ROWS) {
        const nqm_product part = rows_of_product(p, row, nqm_smaller(whole - row, WIDE_STRIPS * TILE_ROWS));
        multiply_strips(&part, n, stride, step);
    }
    nqm_product rest = rows_of_product(p, whole, p->m - whole);
    for (size_t i = 0; i < n && rest.m > 0; ++i) {
        product_int8(&rest);
        rest.b = (const uint32_t *)rest.b + stride * NQM_PANEL;
        rest.c = (int32_t *)rest.c + step;
    }
}
