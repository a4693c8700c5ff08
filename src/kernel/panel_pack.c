/* SPDX-License-Identifier: MIT
 *
 * Conversion of matrices to panels and back, with rounding to bfloat16 or to signed bytes with a scale for each column.
 */
#include "kernel/panel.h"
#include "kernel/transpose.h"

#include <math.h>
#include <string.h>

enum { MIN_PARALLEL = 65536 }; /* elements; below, waking a thread costs more than it saves */

/* Rows of NQM_PANEL words of the whole block; for each panel of bytes, scale and sum are one more row each. */
static size_t n_rows(const nqm_panels *panels) {
    return panels->n_panels * (panels->stride + (panels->precision == NQM_PRECISION_INT8 ? 2 : 0));
}

nqm_status nqm_panels_create(nqm_precision precision, size_t k, size_t n, nqm_panels *panels, nqm_error *err) {
    *panels = (nqm_panels){.precision = precision, .k = k, .n = n, .words = nqm_words(precision, k)};
    panels->stride = nqm_ceil_div(panels->words, NQM_STRIP) * NQM_STRIP;
    panels->n_panels = nqm_ceil_div(n, NQM_PANEL);
    panels->data = nqm_alloc_pages(n_rows(panels), NQM_PANEL * sizeof *panels->data);
    if (!panels->data) {
        *panels = (nqm_panels){0};
        return nqm_fail_nomem(err, k * n * sizeof(float));
    }
    if (precision == NQM_PRECISION_INT8) {
        panels->scale = (float *)(void *)nqm_panel_at(panels, panels->n_panels);
        panels->sum = (int32_t *)(void *)(panels->scale + panels->n_panels * NQM_PANEL);
    }
    return NQM_OK;
}

void nqm_panels_free(nqm_panels *panels) {
    nqm_free_pages(panels->data, n_rows(panels), NQM_PANEL * sizeof *panels->data);
    *panels = (nqm_panels){0};
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
        nqm_transpose_4x4(rows + i, ld, columns + i * NQM_PANEL, NQM_PANEL);
    for (size_t i = whole; i < n; ++i)
        for (size_t j = 0; j < n_rows; ++j)
            columns[i * NQM_PANEL + j] = rows[j * ld + i];
}

static float largest_magnitude(size_t n, const float *x) {
    float largest = 0;
#pragma omp simd reduction(max : largest)
    for (size_t i = 0; i < n; ++i)
        largest = fabsf(x[i]) > largest ? fabsf(x[i]) : largest;
    return largest;
}

/* x (n), n <= PACK_COLUMNS, as signed bytes to nearest; adds them to *sum. */
static void signed_bytes(size_t n, const float *x, float per_scale, uint32_t *words, int32_t *sum) {
    signed char bytes[PACK_COLUMNS] = {0};
    int32_t total = 0;
#pragma omp simd reduction(+ : total)
    for (size_t i = 0; i < n; ++i) {
        int32_t q = (int32_t)(x[i] * per_scale + copysignf(0.5f, x[i]));
        total += q;
        bytes[i] = (signed char)q;
    }
    *sum += total;
    memcpy(words, bytes, sizeof bytes);
}

/* The columns of a panel of signed bytes: the scale of each, whose inverse is per_scale (width). */
static void find_scales(size_t width, size_t k, nqm_weights w, float *scale, float *per_scale) {
    float converted[PACK_COLUMNS];
    for (size_t j = 0; j < width; ++j) {
        float largest = 0;
        for (size_t first = 0; first < k; first += PACK_COLUMNS) {
            const size_t n = nqm_smaller(k - first, PACK_COLUMNS);
            largest = fmaxf(largest, largest_magnitude(n, nqm_weights_row(nqm_weights_at(w, j, first), n, converted)));
        }
        scale[j] = largest > 0 ? largest / 127 : 1;
        per_scale[j] = 1 / scale[j];
    }
}

/* One panel from w (width, k), width <= NQM_PANEL, PACK_COLUMNS columns of w at a time. per_scale, sum (width): of the
 * columns of a panel of bytes; sum is 0 on entry. */
static void pack(nqm_precision precision, size_t width, size_t k, nqm_weights w, uint32_t *panel,
                 const float *per_scale, int32_t *sum) {
    const nqm_kernels *kernels = nqm_kernels_get();
    const bool in_place = precision == NQM_PRECISION_F32 && w.w;
    const size_t ld = in_place ? w.ld : (size_t)PACK_COLUMNS >> precision;
    uint32_t words[PACK_ROWS * PACK_COLUMNS];
    float converted[PACK_COLUMNS];
    for (size_t first = 0; first < k; first += PACK_COLUMNS)
        for (size_t j = 0; j < width; j += PACK_ROWS) {
            const size_t n = nqm_smaller(k - first, PACK_COLUMNS), n_rows = nqm_smaller(width - j, PACK_ROWS);
            for (size_t r = 0; !in_place && r < n_rows; ++r) {
                const nqm_weights at = nqm_weights_at(w, j + r, first);
                if (precision == NQM_PRECISION_F32)
                    nqm_half_to_float(n, at.half, (float *)words + r * ld);
                else if (precision == NQM_PRECISION_BF16)
                    kernels->round_row(n, nqm_weights_row(at, n, converted), words + r * ld);
                else
                    signed_bytes(n, nqm_weights_row(at, n, converted), per_scale[j + r], words + r * ld, &sum[j + r]);
            }
            rows_to_columns(n_rows, nqm_words(precision, n), in_place ? (const uint32_t *)w.w + j * ld + first : words,
                            ld, panel + (first >> precision) * NQM_PANEL + j);
        }
}

void nqm_panels_pack(nqm_panels *panels, nqm_weights w) {
#pragma omp parallel for schedule(dynamic, 1) if (panels->n * panels->k > MIN_PARALLEL)
    for (size_t p = 0; p < panels->n_panels; ++p) {
        const size_t first = p * NQM_PANEL, width = nqm_smaller(panels->n - first, NQM_PANEL);
        const nqm_weights rows = nqm_weights_at(w, first, 0);
        float per_scale[NQM_PANEL];
        int32_t sum[NQM_PANEL] = {0};
        if (panels->precision == NQM_PRECISION_INT8)
            find_scales(width, panels->k, rows, panels->scale + first, per_scale);
        pack(panels->precision, width, panels->k, rows, nqm_panel_at(panels, p), per_scale, sum);
        if (panels->precision == NQM_PRECISION_INT8)
            memcpy(panels->sum + first, sum, width * sizeof *sum);
    }
}

void nqm_pack_panel(size_t width, size_t k, nqm_weights w, float *panel) {
    if (width < NQM_PANEL)
        memset(panel, 0, k * NQM_PANEL * sizeof *panel);
    pack(NQM_PRECISION_F32, width, k, w, (uint32_t *)(void *)panel, NULL, NULL);
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
            nqm_transpose_4x4(rows + u, n_words, words + u * NQM_PANEL, NQM_PANEL);
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
