/* SPDX-License-Identifier: MIT
 *
 * Into panels, strips and rows, and back: rounding to bfloat16, to signed bytes with a scale for each column, to unsigned
 * bytes with a scale for each row.
 */
#include "kernel/panel.h"

#include <math.h>
#include <string.h>

static size_t ceil_div(size_t a, size_t b) {
    return (a + b - 1) / b;
}

static size_t smaller(size_t a, size_t b) {
    return a < b ? a : b;
}

/* To nearest, ties to even; a NaN stays one. */
static inline uint32_t bf16_bits(float x) {
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    uint32_t rounded = (bits + 0x7fff + (bits >> 16 & 1)) >> 16;
    return (bits & 0x7fffffff) > 0x7f800000 ? bits >> 16 | 0x40 : rounded;
}

static inline uint32_t float_bits(float x) {
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

nqm_status nqm_panels_create(nqm_precision precision, size_t k, size_t n, nqm_panels *panels, nqm_error *err) {
    *panels = (nqm_panels){.precision = precision, .k = k, .n = n, .units = nqm_units(precision, k)};
    panels->stride = ceil_div(panels->units, NQM_STRIP) * NQM_STRIP;
    panels->n_panels = ceil_div(n, NQM_PANEL);
    bool bytes = precision == NQM_PRECISION_INT8;
    panels->data = nqm_alloc(panels->n_panels * panels->stride, NQM_PANEL * sizeof *panels->data);
    panels->scale = bytes ? nqm_alloc(panels->n_panels, NQM_PANEL * sizeof *panels->scale) : NULL;
    panels->sum = bytes ? nqm_alloc(panels->n_panels, NQM_PANEL * sizeof *panels->sum) : NULL;
    if (panels->data && (!bytes || (panels->scale && panels->sum)))
        return NQM_OK;
    nqm_panels_free(panels);
    return nqm_fail_nomem(err, k * n * sizeof(float));
}

void nqm_panels_free(nqm_panels *panels) {
    nqm_free(panels->data);
    nqm_free(panels->scale);
    nqm_free(panels->sum);
    *panels = (nqm_panels){0};
}

/* ---- weights ----------------------------------------------------------------------------------------------------- */

/* Column j of a panel from row j of w: x (k). */
static void pack_f32(size_t k, const float *x, uint32_t *panel) {
    for (size_t i = 0; i < k; ++i)
        panel[i * NQM_PANEL] = float_bits(x[i]);
}

static void pack_bf16(size_t k, const float *x, uint32_t *panel) {
    for (size_t i = 0; i < k; ++i) {
        uint32_t *unit = panel + i / 2 * NQM_PANEL, bits = bf16_bits(x[i]);
        *unit = i % 2 ? *unit | bits << 16 : bits;
    }
}

static float largest_magnitude(size_t n, const float *x) {
    float largest = 0;
    for (size_t i = 0; i < n; ++i)
        largest = fmaxf(largest, fabsf(x[i]));
    return largest;
}

static void pack_int8(size_t k, const float *x, uint32_t *panel, float *scale_ret, int32_t *sum_ret) {
    const float largest = largest_magnitude(k, x), scale = largest > 0 ? largest / 127 : 1;
    int32_t sum = 0;
    for (size_t i = 0; i < k; ++i) {
        uint32_t *unit = panel + i / 4 * NQM_PANEL;
        int32_t q = (int32_t)lrintf(x[i] / scale);
        sum += q;
        *unit = (i % 4 ? *unit : 0) | ((uint32_t)q & 255) << i % 4 * 8;
    }
    *scale_ret = scale;
    *sum_ret = sum;
}

void nqm_panels_pack(nqm_panels *panels, const float *w, size_t ldw) {
#pragma omp parallel for schedule(static) if (panels->n_panels > 1)
    for (size_t p = 0; p < panels->n_panels; ++p)
        for (size_t j = p * NQM_PANEL; j < smaller((p + 1) * NQM_PANEL, panels->n); ++j) {
            uint32_t *column = nqm_panel_at(panels, p) + j % NQM_PANEL;
            if (panels->precision == NQM_PRECISION_F32)
                pack_f32(panels->k, w + j * ldw, column);
            else if (panels->precision == NQM_PRECISION_BF16)
                pack_bf16(panels->k, w + j * ldw, column);
            else
                pack_int8(panels->k, w + j * ldw, column, &panels->scale[j], &panels->sum[j]);
        }
}

void nqm_panels_unpack(const nqm_panels *panels, float *w, size_t ldw) {
    for (size_t j = 0; j < panels->n; ++j) {
        const uint32_t *column = nqm_panel_at(panels, j / NQM_PANEL) + j % NQM_PANEL;
        for (size_t i = 0; i < panels->k; ++i)
            memcpy(&w[j * ldw + i], &column[i * NQM_PANEL], sizeof(float));
    }
}

/* Rows [first, first + NQM_PANEL) of `from` are panel first / NQM_PANEL of `to`. */
static void transpose_panel(const nqm_panels *from, nqm_panels *to, size_t first) {
    uint32_t *panel = nqm_panel_at(to, first / NQM_PANEL);
    const size_t width = smaller(to->n - first, NQM_PANEL);
    const size_t per_unit = to->precision == NQM_PRECISION_BF16 ? 2 : 1;
    for (size_t j = 0; j < from->n; ++j) {
        const uint32_t *column = nqm_panel_at(from, j / NQM_PANEL) + first * NQM_PANEL + j % NQM_PANEL;
        uint32_t *units = panel + j / per_unit * NQM_PANEL;
        if (per_unit == 1) {
            for (size_t i = 0; i < width; ++i)
                units[i] = column[i * NQM_PANEL];
            continue;
        }
        for (size_t i = 0; i < width; ++i) {
            float value;
            memcpy(&value, &column[i * NQM_PANEL], sizeof value);
            units[i] = j % 2 ? units[i] | bf16_bits(value) << 16 : bf16_bits(value);
        }
    }
}

void nqm_panels_transpose(const nqm_panels *from, nqm_panels *to) {
#pragma omp parallel for schedule(static) if (to->n_panels > 1)
    for (size_t p = 0; p < to->n_panels; ++p)
        transpose_panel(from, to, p * NQM_PANEL);
}

void nqm_round_tile(const float *tile, uint32_t *units) {
    for (size_t i = 0; i < NQM_STRIP; i += 2, tile += 2 * NQM_PANEL, units += NQM_PANEL)
#pragma omp simd
        for (size_t j = 0; j < NQM_PANEL; ++j)
            units[j] = bf16_bits(tile[j]) | bf16_bits(tile[j + NQM_PANEL]) << 16;
}

void nqm_panels_round(const nqm_panels *from, nqm_panels *to) {
#pragma omp parallel for schedule(static) if (from->n_panels > 1)
    for (size_t p = 0; p < from->n_panels; ++p)
        for (size_t i = 0; i < from->stride; i += NQM_STRIP)
            nqm_round_tile((const float *)nqm_panel_at(from, p) + i * NQM_PANEL,
                           nqm_panel_at(to, p) + i / 2 * NQM_PANEL);
}

/* ---- activations ------------------------------------------------------------------------------------------------- */

void nqm_round_row(size_t n, const float *x, uint32_t *units) {
#pragma omp simd
    for (size_t i = 0; i < n / 2; ++i)
        units[i] = bf16_bits(x[2 * i]) | bf16_bits(x[2 * i + 1]) << 16;
    if (n % 2)
        units[n / 2] = bf16_bits(x[n - 1]);
}

float nqm_quantise_row(size_t n, const float *x, uint32_t *units) {
    const float largest = largest_magnitude(n, x), scale = largest > 0 ? largest / 127 : 1;
    unsigned char *bytes = (unsigned char *)units;
    const float per_unit = 1 / scale;
    for (size_t i = 0; i < n; ++i)
        bytes[i] = (unsigned char)(lrintf(x[i] * per_unit) + 128);
    memset(bytes + n, 128, -n & 3); /* zeros, which the panels' zeros make harmless anyway */
    return scale;
}

void nqm_dequantise_panel(const nqm_panels *b, size_t panel, float scale, bool add, const int32_t *sums, float *c) {
    const float *scales = b->scale + panel * NQM_PANEL;
    const int32_t *columns = b->sum + panel * NQM_PANEL;
#pragma omp simd
    for (size_t j = 0; j < NQM_PANEL; ++j)
        c[j] = (add ? c[j] : 0) + scale * scales[j] * (float)(sums[j] - 128 * columns[j]);
}

void nqm_dequantise_row(const nqm_panels *b, float scale, bool add, const int32_t *sums, float *c) {
    for (size_t p = 0; p < b->n_panels; ++p)
        nqm_dequantise_panel(b, p, scale, add, sums + p * NQM_PANEL, c + p * NQM_PANEL);
}

enum { ROWS_AT_ONCE = 16 }; /* even */

/* Rows [row, row + rows) of one group of columns; `width` is a constant where this is inlined. */
static inline void pack_group_f32(size_t width, size_t rows, size_t there, const float *x, size_t ldx, uint32_t *out) {
    for (size_t i = 0; i < rows; ++i) {
        memcpy(out + i * width, x + i * ldx, there * sizeof *x);
        memset(out + i * width + there, 0, (width - there) * sizeof *out);
    }
}

static inline void pack_group_bf16(size_t width, size_t rows, size_t there, const float *x, size_t ldx, uint32_t *out) {
    for (size_t i = 0; i < rows; i += 2) {
        const bool alone = i + 1 == rows;
        const float *even = x + i * ldx, *odd = even + (alone ? 0 : ldx);
        const uint32_t second = alone ? 0 : 0xffffffffu;
        uint32_t *units = out + i / 2 * width;
#pragma omp simd
        for (size_t j = 0; j < there; ++j)
            units[j] = bf16_bits(even[j]) | (bf16_bits(odd[j]) << 16 & second);
        memset(units + there, 0, (width - there) * sizeof *units);
    }
}

static inline void pack_rows(nqm_precision precision, size_t width, size_t rows, size_t n, size_t group_units,
                             const float *x, size_t ldx, uint32_t *out) {
    for (size_t first = 0; first < n; first += width, out += group_units * width)
        if (precision == NQM_PRECISION_BF16)
            pack_group_bf16(width, rows, smaller(n - first, width), x + first, ldx, out);
        else if (n - first >= width)
            pack_group_f32(width, rows, width, x + first, ldx, out);
        else
            pack_group_f32(width, rows, n - first, x + first, ldx, out);
}

void nqm_pack_columns(nqm_precision precision, size_t width, size_t m, size_t n, const float *x, size_t ldx,
                      uint32_t *out) {
    const size_t units = nqm_units(precision, m);
    /* Some rows at a time, all the way across: they are read in order, and what is written stays a few lines a group. */
#pragma omp parallel for schedule(static) if (m * n > 65536)
    for (size_t row = 0; row < m; row += ROWS_AT_ONCE) {
        const size_t rows = smaller(m - row, ROWS_AT_ONCE);
        const float *from = x + row * ldx;
        uint32_t *to = out + (row >> precision) * width;
        if (width == NQM_STRIP)
            pack_rows(precision, NQM_STRIP, rows, n, units, from, ldx, to);
        else
            pack_rows(precision, NQM_PANEL, rows, n, units, from, ldx, to);
    }
}
