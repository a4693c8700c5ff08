/* SPDX-License-Identifier: MIT
 *
 * Conversion of matrices of floats to panels and back, their transposes, and rounding of panels to bfloat16.
 */
#include "kernel/panel.h"

#include <string.h>

enum { MIN_PARALLEL = 65536 }; /* elements; below, waking a thread costs more than it saves */

nqm_status nqm_panels_create(nqm_precision precision, size_t k, size_t n, nqm_panels *panels, nqm_error *err) {
    *panels = (nqm_panels){.precision = precision, .k = k, .n = n, .words = nqm_words(precision, k)};
    panels->stride = nqm_ceil_div(panels->words, NQM_STRIP) * NQM_STRIP;
    panels->n_panels = nqm_ceil_div(n, NQM_PANEL);
    panels->data = nqm_alloc_pages(panels->n_panels * panels->stride, NQM_PANEL * sizeof *panels->data);
    if (!panels->data) {
        *panels = (nqm_panels){0};
        return nqm_fail_nomem(err, k * n * sizeof(float));
    }
    return NQM_OK;
}

void nqm_panels_free(nqm_panels *panels) {
    nqm_free_pages(panels->data, panels->n_panels * panels->stride, NQM_PANEL * sizeof *panels->data);
    *panels = (nqm_panels){0};
}

/* to (4, 4) = the transpose of from (4, 4); ld words from row to row. */
static inline void transpose_4x4(const uint32_t *from, size_t ld_from, uint32_t *to, size_t ld_to) {
    typedef uint32_t four __attribute__((vector_size(16), aligned(4), may_alias));
    const four a = *(const four *)from, b = *(const four *)(from + ld_from), c = *(const four *)(from + 2 * ld_from),
               d = *(const four *)(from + 3 * ld_from);
    const four ab_low = __builtin_shufflevector(a, b, 0, 4, 1, 5), ab_high = __builtin_shufflevector(a, b, 2, 6, 3, 7);
    const four cd_low = __builtin_shufflevector(c, d, 0, 4, 1, 5), cd_high = __builtin_shufflevector(c, d, 2, 6, 3, 7);
    *(four *)to = __builtin_shufflevector(ab_low, cd_low, 0, 1, 4, 5);
    *(four *)(to + ld_to) = __builtin_shufflevector(ab_low, cd_low, 2, 3, 6, 7);
    *(four *)(to + 2 * ld_to) = __builtin_shufflevector(ab_high, cd_high, 0, 1, 4, 5);
    *(four *)(to + 3 * ld_to) = __builtin_shufflevector(ab_high, cd_high, 2, 3, 6, 7);
}

/* ---- weights ----------------------------------------------------------------------------------------------------- */

enum {
    PACK_COLUMNS = 192, /* of W at a time: the lines that are written stay in the L1 cache for all rows of a panel */
    PACK_ROWS = 4
};

/* Copy consecutive rows of n words, ld words apart, to columns of a panel. */
static inline void rows_to_columns(size_t n_rows, size_t n, const uint32_t *rows, size_t ld, uint32_t *columns) {
    const size_t whole = n_rows == PACK_ROWS ? n / 4 * 4 : 0;
    for (size_t i = 0; i < whole; i += 4)
        transpose_4x4(rows + i, ld, columns + i * NQM_PANEL, NQM_PANEL);
    for (size_t i = whole; i < n; ++i)
        for (size_t j = 0; j < n_rows; ++j)
            columns[i * NQM_PANEL + j] = rows[j * ld + i];
}

/* One panel from w (width, k), width <= NQM_PANEL, PACK_COLUMNS columns of w at a time. */
static void pack(size_t width, size_t k, nqm_weights w, float *panel) {
    float converted[PACK_ROWS * PACK_COLUMNS];
    for (size_t first = 0; first < k; first += PACK_COLUMNS)
        for (size_t j = 0; j < width; j += PACK_ROWS) {
            const size_t n = nqm_smaller(k - first, PACK_COLUMNS), n_rows = nqm_smaller(width - j, PACK_ROWS);
            const nqm_weights at = nqm_weights_at(w, j, first);
            for (size_t r = 0; at.half && r < n_rows; ++r)
                nqm_half_to_float(n, at.half + r * at.ld, converted + r * PACK_COLUMNS);
            rows_to_columns(n_rows, n, (const uint32_t *)(at.w ? at.w : converted), at.w ? at.ld : PACK_COLUMNS,
                            (uint32_t *)panel + first * NQM_PANEL + j);
        }
}

void nqm_panels_pack(nqm_panels *panels, nqm_weights w) {
#pragma omp parallel for schedule(dynamic, 1) if (panels->n * panels->k > MIN_PARALLEL)
    for (size_t p = 0; p < panels->n_panels; ++p) {
        const size_t first = p * NQM_PANEL, width = nqm_smaller(panels->n - first, NQM_PANEL);
        pack(width, panels->k, nqm_weights_at(w, first, 0), (float *)nqm_panel_at(panels, p));
    }
}

void nqm_pack_panel(size_t width, size_t k, nqm_weights w, float *panel) {
    if (width < NQM_PANEL)
        memset(panel, 0, k * NQM_PANEL * sizeof *panel);
    pack(width, k, w, panel);
}

void nqm_panels_unpack(const nqm_panels *panels, float *w, size_t ldw) {
    for (size_t j = 0; j < panels->n; ++j) {
        const uint32_t *column = nqm_panel_at(panels, j / NQM_PANEL) + j % NQM_PANEL;
        for (size_t i = 0; i < panels->k; ++i)
            memcpy(&w[j * ldw + i], &column[i * NQM_PANEL], sizeof(float));
    }
}

/* Panels are filled up with zeros, so that whole 4 x 4 blocks can be moved. */
void nqm_panels_transpose_rows(const nqm_panels *from, nqm_panels *to, size_t first, size_t n, size_t panel) {
    const size_t end = nqm_smaller(first + n, to->n_panels * NQM_PANEL); /* rows beyond are 0 */
    const size_t n_words = NQM_PANEL >> to->precision, last = nqm_smaller(to->stride - panel * n_words, n_words);
    for (size_t row = first; row < end; row += 4) {
        const uint32_t *rows = nqm_panel_at(from, panel) + row * NQM_PANEL;
        uint32_t *words = nqm_panel_at(to, row / NQM_PANEL) + panel * n_words * NQM_PANEL + row % NQM_PANEL;
        uint32_t rounded[4 * NQM_PANEL / 2];
        if (to->precision == NQM_PRECISION_BF16) {
            nqm_kernels_get()->round_row((size_t)4 * NQM_PANEL, (const float *)rows, rounded);
            rows = rounded;
        }
        for (size_t u = 0; u < last; u += 4) /* n_words and NQM_STRIP are multiples of 4 */
            transpose_4x4(rows + u, n_words, words + u * NQM_PANEL, NQM_PANEL);
    }
}

void nqm_panels_transpose(const nqm_panels *from, nqm_panels *to) {
#pragma omp parallel for schedule(dynamic, 1) if (from->n_panels > 1)
    for (size_t p = 0; p < from->n_panels; ++p)
        nqm_panels_transpose_rows(from, to, 0, from->stride, p);
}

void nqm_panels_round(const nqm_panels *from, nqm_panels *to) {
    const nqm_kernels *kernels = nqm_kernels_get();
#pragma omp parallel for schedule(static) if (from->n_panels > 1)
    for (size_t p = 0; p < from->n_panels; ++p)
        for (size_t i = 0; i < from->stride; i += NQM_STRIP)
            kernels->round_tile((const float *)nqm_panel_at(from, p) + i * NQM_PANEL,
                                nqm_panel_at(to, p) + i / 2 * NQM_PANEL);
}
