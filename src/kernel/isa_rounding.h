/* SPDX-License-Identifier: MIT
 *
 * isa_rounding.h - rows of floats to bfloat16 and to bytes, and sums of products of bytes back to float, for one instruction set:
 * loops that compilers vectorise, included by isa_rows.h. Every instruction set gives the same bits.
 */
#include "kernel/kernel.h"
#include "kernel/multiply_add.h"

#include <string.h>

static void round_row(size_t n, const float *x, uint32_t *words) {
#pragma omp simd
    for (size_t i = 0; i < n / 2; ++i)
        words[i] = nqm_bf16_bits(x[2 * i]) | nqm_bf16_bits(x[2 * i + 1]) << 16;
    if (n % 2)
        words[n / 2] = nqm_bf16_bits(x[n - 1]);
}

static void round_pair(size_t n, const float *even, const float *odd, size_t width, size_t step, uint32_t *words) {
    for (size_t first = 0; first < n; first += width, words += step) {
        const size_t n_here = n - first < width ? n - first : width;
#pragma omp simd
        for (size_t i = 0; i < n_here; ++i)
            words[i] = nqm_bf16_bits(even[first + i]) | nqm_bf16_bits(odd[first + i]) << 16;
        memset(words + n_here, 0, (width - n_here) * sizeof *words);
    }
}

static void round_tile(const float *x, uint32_t *words) {
    for (size_t i = 0; i < NQM_STRIP / 2; ++i, x += 2 * NQM_PANEL)
        round_pair(NQM_PANEL, x, x + NQM_PANEL, NQM_PANEL, 0, words + i * NQM_PANEL);
}

/* The range of the bytes includes 0, which is exact. */
static nqm_byte_scale quantise_row(size_t n, const float *x, uint32_t *words) {
    const float round_magic = 0x1.8p23f; /* adding it leaves the nearest integer in the low bits */
    const int32_t most = 0x4b400000 + 255;
    unsigned char *bytes = (unsigned char *)words;
    float low = 0, high = 0;
#pragma omp simd reduction(min : low) reduction(max : high)
    for (size_t i = 0; i < n; ++i) {
        low = x[i] < low ? x[i] : low;
        high = x[i] > high ? x[i] : high;
    }
    const nqm_byte_scale by = nqm_byte_scale_of(low, high);
    const float per_scale = 1 / by.scale, zero = (float)by.zero;
#pragma omp simd
    for (size_t i = 0; i < n; ++i) {
        float shifted = x[i] * per_scale + zero + round_magic;
        int32_t bits;
        memcpy(&bits, &shifted, sizeof bits);
        bytes[i] = (unsigned char)(bits < most ? bits : most);
    }
    memset(bytes + n, 0, -n & 3); /* fill the last word */
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
