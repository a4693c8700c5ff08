/* SPDX-License-Identifier: MIT
 *
 * rounding.h - rows of factors as bfloat16 and as bytes, and sums of bytes back to float, for one instruction set: loops
 * that a compiler vectorises, included by rows.h. Every instruction set gives the same bits.
 */
#include "kernel/bf16.h"
#include "kernel/kernel.h"
#include "kernel/multiply_add.h"

#include <string.h>

#ifndef NQM_NATIVE_ROUNDING /* defined where the instruction set rounds by itself, and the file has these two of its own */
static void round_row(size_t n, const float *x, uint32_t *words) {
#pragma omp simd
    for (size_t i = 0; i < n / 2; ++i)
        words[i] = nqm_bf16_bits(x[2 * i]) | nqm_bf16_bits(x[2 * i + 1]) << 16;
    if (n % 2)
        words[n / 2] = nqm_bf16_bits(x[n - 1]);
}

static void round_pair(size_t n, const float *even, const float *odd, size_t width, size_t step, uint32_t *words) {
    for (size_t first = 0; first < n; first += width, words += step) {
        const size_t there = n - first < width ? n - first : width;
#pragma omp simd
        for (size_t i = 0; i < there; ++i)
            words[i] = nqm_bf16_bits(even[first + i]) | nqm_bf16_bits(odd[first + i]) << 16;
        memset(words + there, 0, (width - there) * sizeof *words);
    }
}

static void round_tile(const float *x, uint32_t *words) {
    for (size_t i = 0; i < NQM_STRIP / 2; ++i, x += 2 * NQM_PANEL)
        round_pair(NQM_PANEL, x, x + NQM_PANEL, NQM_PANEL, 0, words + i * NQM_PANEL);
}
#endif

/* x (n) as bytes. */
static inline void quantise(size_t n, const float *x, float per_unit, float zero, unsigned char *bytes) {
    const float round_magic = 0x1.8p23f; /* adding it leaves the nearest integer in the low bits */
    const int32_t most = 0x4b400000 + 255;
#pragma omp simd
    for (size_t i = 0; i < n; ++i) {
        float shifted = x[i] * per_unit + zero + round_magic;
        int32_t bits;
        memcpy(&bits, &shifted, sizeof bits);
        bytes[i] = (unsigned char)(bits < most ? bits : most);
    }
}

/* The range of the bytes is that of x and 0, so that 0 stands for itself. */
static nqm_byte_scale quantise_row(size_t n, const float *x, uint32_t *words) {
    enum { AT_ONCE = 64 };
    /* Two minima that do not wait for each other, of halves that overlap: none is left to be done one by one. */
    const size_t rounded = (n / 2 + 16) / 16 * 16, half = rounded < n ? rounded : n, other = n - half;
    float low = 0, high = 0, low2 = 0, high2 = 0;
#pragma omp simd reduction(min : low, low2) reduction(max : high, high2)
    for (size_t i = 0; i < half; ++i) {
        low = x[i] < low ? x[i] : low;
        high = x[i] > high ? x[i] : high;
        low2 = x[other + i] < low2 ? x[other + i] : low2;
        high2 = x[other + i] > high2 ? x[other + i] : high2;
    }
    const nqm_byte_scale by = nqm_byte_scale_of(low < low2 ? low : low2, high > high2 ? high : high2);
    const float per_unit = 1 / by.scale, zero = (float)by.zero;
    unsigned char *bytes = (unsigned char *)words;
    const size_t left = n % AT_ONCE;
    quantise(n - left, x, per_unit, zero, bytes);
    if (n > AT_ONCE) /* some of them again: one by one they would take as long as hundreds */
        quantise(AT_ONCE, x + n - AT_ONCE, per_unit, zero, bytes + n - AT_ONCE);
    else
        quantise(left, x + n - left, per_unit, zero, bytes + n - left);
    memset(bytes + n, 0, -n & 3); /* the panels hold zeros there */
    return by;
}

static void dequantise(size_t m, const nqm_byte_scale *rows, const nqm_byte_columns *columns, bool add,
                       const int32_t *sums, float *c, size_t ldc) {
    float scale[NQM_PANEL];
    int32_t sum[NQM_PANEL];
    memcpy(scale, columns->scale, sizeof scale);
    memcpy(sum, columns->sum, sizeof sum);
    for (size_t i = 0; i < m; ++i, sums += NQM_PANEL, c += ldc) {
        const float row_scale = rows[i].scale;
        const int32_t zero = rows[i].zero;
#pragma omp simd
        for (size_t j = 0; j < NQM_PANEL; ++j)
            c[j] = nqm_multiply_add(row_scale * scale[j], (float)(sums[j] - zero * sum[j]), add ? c[j] : 0.0f);
    }
}
