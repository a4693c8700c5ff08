/* SPDX-License-Identifier: MIT
 *
 * isa_precision.h - the matrix products of one precision, for isa_products.h, which includes this file once for each:
 *
 * PRECISION      suffix of the functions' names
 * WORD, RIGHT    an element of A and a vector of elements of B
 * MADD           sum + a b for a vector sum of floats
 *
 * A tile of C stays in registers while A and B are read once; each word of A is broadcast to a vector.
 */

/* C (rows, vectors LANES) = A B, or C + A B. Where it is inlined, all but the pointers and strides are constants. */
typedef struct NAME(tile) {
    size_t rows, vectors; /* at most TILE_SUMS together */
    size_t words;
    const WORD *a; /* word u of row i is a[i * row_step + u * word_step] */
    size_t row_step, word_step;
    const WORD *b; /* (words, vectors LANES), ldb words from row to row */
    size_t ldb;
    float *c; /* (rows, vectors LANES) */
    size_t ldc;
    bool add;
    const float *const
        *prefetch; /* NQM_PREFETCH arrays, of which a tile's size is prefetched a cache line at a time; NULL: none */
    size_t part;   /* the first element that is prefetched */
} NAME(tile);

INLINE void NAME(multiply_tile)(NAME(tile) t) {
    const WORD *restrict a = t.a, *restrict b = t.b;
    float *restrict c = t.c;
    const size_t slice = t.prefetch ? (t.words + PREFETCH_LINES - 1) / PREFETCH_LINES : t.words;
    vector_f sum[TILE_SUMS];
    UNROLL for (size_t i = 0; i < t.rows; ++i) UNROLL for (size_t j = 0; j < t.vectors; ++j) sum[i * t.vectors + j] =
        t.add ? *(const vector_f *)(c + i * t.ldc + j * LANES) : (vector_f){0};
    for (size_t u = 0, line = 0; u < t.words; ++line) {
        for (size_t i = 0; t.prefetch && i < NQM_PREFETCH; ++i)
            __builtin_prefetch(t.prefetch[i] + t.part + line * LINE, 0, 2);
        for (size_t end = t.words - u < slice ? t.words : u + slice; u < end; ++u) {
            RIGHT right[PANEL_VECTORS];
            UNROLL for (size_t j = 0; j < t.vectors; ++j) right[j] = *(const RIGHT *)(b + j * LANES);
            UNROLL for (size_t i = 0; i < t.rows; ++i) {
                const WORD left = a[i * t.row_step];
                vector_f *row = sum + i * t.vectors;
                UNROLL for (size_t j = 0; j < t.vectors; ++j) row[j] = MADD(row[j], left, right[j]);
            }
            a += t.word_step;
            b += t.ldb;
        }
    }
    UNROLL for (size_t i = 0; i < t.rows; ++i) UNROLL for (size_t j = 0; j < t.vectors; ++j) *
        (vector_f *)(c + i * t.ldc + j * LANES) = sum[i * t.vectors + j];
}

/* n rows from `row` on, where t is the tile of row 0. */
INLINE void NAME(multiply_some)(NAME(tile) t, size_t row, size_t n) {
    t.rows = n;
    t.a += row * t.row_step;
    t.c += row * t.ldc;
    NAME(multiply_tile)(t);
}

/* All m rows, where t is the tile of row 0. */
INLINE void NAME(multiply_rows)(NAME(tile) t, size_t m) {
    size_t i = 0;
    for (; i + TILE_ROWS <= m; i += TILE_ROWS)
        NAME(multiply_some)(t, i, TILE_ROWS);
#define REST(n)                                                                                                        \
    case n:                                                                                                            \
        NAME(multiply_some)(t, i, (n) < TILE_ROWS ? (n) : 1);                                                          \
        break;
    switch (m - i) {
        REST(1)
        REST(2)
        REST(3)
        REST(4)
        REST(5)
        REST(6)
        REST(7)
        REST(8)
        REST(9)
        REST(10)
        REST(11)
    default: /* TILE_ROWS is at most 12 */
        break;
    }
#undef REST
}

/* All rows times the panel b, in parts of the panel. */
INLINE void NAME(multiply_panel)(const nqm_product *p, const WORD *b, float *c) {
    const size_t n_parts = (p->words - 1) / PART_WORDS + 1, n = (p->words - 1) / n_parts + 1;
    for (size_t first = 0; first < p->words; first += n)
        for (size_t column = 0; column < NQM_PANEL; column += TILE_COLUMNS)
            NAME(multiply_rows)
    ((NAME(tile)){.vectors = TILE_VECTORS,
                  .words = p->words - first < n ? p->words - first : n,
                  .a = (const WORD *)p->a + first,
                  .row_step = p->lda,
                  .word_step = 1,
                  .b = b + first * NQM_PANEL + column,
                  .ldb = NQM_PANEL,
                  .c = c + column,
                  .ldc = p->ldc,
                  .add = p->add || first > 0},
     p->m);
}

/* One row times n neighbouring panels from b on. Bound by memory bandwidth: several panels at once keep enough
 * accumulators busy. */
INLINE void NAME(multiply_row)(size_t n, const nqm_product *p, const WORD *restrict b, float *restrict c) {
    const WORD *restrict a = p->a;
    vector_f sum[ROW_PANELS * PANEL_VECTORS];
    UNROLL for (size_t i = 0; i < n * PANEL_VECTORS; ++i) sum[i] =
        p->add ? *(const vector_f *)(c + i * LANES) : (vector_f){0};
    for (size_t u = 0; u < p->words; ++u)
        UNROLL for (size_t i = 0; i < n * PANEL_VECTORS; ++i) {
            const WORD *right = b + i / PANEL_VECTORS * p->panel_step + u * NQM_PANEL + i % PANEL_VECTORS * LANES;
            sum[i] = MADD(sum[i], a[u], *(const RIGHT *)right);
        }
    UNROLL for (size_t i = 0; i < n * PANEL_VECTORS; ++i) * (vector_f *)(c + i * LANES) = sum[i];
}

static void NAME(product)(const nqm_product *p) {
    const WORD *b = p->b;
    float *c = p->c;
    size_t panel = 0;
    for (; p->m == 1 && panel + ROW_PANELS <= p->n_panels; panel += ROW_PANELS)
        NAME(multiply_row)(ROW_PANELS, p, b + panel * p->panel_step, c + panel * NQM_PANEL);
    for (; panel < p->n_panels; ++panel)
        if (p->m == 1)
            NAME(multiply_row)(1, p, b + panel * p->panel_step, c + panel * NQM_PANEL);
        else
            NAME(multiply_panel)(p, b + panel * p->panel_step, c + panel * NQM_PANEL);
}

INLINE void NAME(gradient_of_strip)(const nqm_tile_gradient *g, size_t strip) {
    const float *prefetch[NQM_PREFETCH];
    for (size_t i = 0; i < NQM_PREFETCH; ++i)
        prefetch[i] = g->prefetch[i] + strip * NQM_STRIP * NQM_PANEL;
    for (size_t column = 0; column < NQM_PANEL; column += TILE_COLUMNS)
        for (size_t i = 0; i < NQM_STRIP; i += TILE_ROWS)
            NAME(multiply_tile)
    ((NAME(tile)){.rows = TILE_ROWS,
                  .vectors = TILE_VECTORS,
                  .words = g->words,
                  .a = (const WORD *)g->left + strip * g->step + i,
                  .row_step = 1,
                  .word_step = NQM_STRIP,
                  .b = (const WORD *)g->right + column,
                  .ldb = NQM_PANEL,
                  .c = g->c + (strip * NQM_STRIP + i) * NQM_PANEL + column,
                  .ldc = NQM_PANEL,
                  .prefetch = prefetch,
                  .part = column * NQM_STRIP + i * TILE_COLUMNS});
}

static void NAME(gradient)(const nqm_tile_gradient *g) {
    for (size_t strip = 0; strip < g->n_strips; ++strip)
        NAME(gradient_of_strip)(g, strip);
}

#undef PRECISION
#undef WORD
#undef RIGHT
#undef MADD
