/* SPDX-License-Identifier: MIT
 *
 * Tile registers in plain C.
 */
#include "support/amx_emulated.h"
#include "kernel/multiply_add.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

enum { TILES = 8, ROWS = 16, WORDS = 16 };

typedef struct configuration {
    uint8_t palette, start_row, reserved[14];
    uint16_t row_bytes[16];
    uint8_t rows[16];
} configuration;

static _Thread_local configuration configured;
static _Thread_local uint32_t tiles[TILES][ROWS][WORDS];

static void require(bool condition, const char *what) {
    if (condition)
        return;
    fprintf(stderr, "tile registers: %s\n", what);
    abort();
}

void amx_configure(const void *from) {
    static const configuration initial;
    configuration c;
    memcpy(&c, from, sizeof c);
    require(c.palette <= 1, "no such palette");
    if (c.palette == 0)
        c = initial;
    require(c.start_row == 0 && memcmp(c.reserved, initial.reserved, sizeof c.reserved) == 0, "reserved bytes");
    for (size_t t = 0; t < 16; ++t) {
        require(t < TILES || (c.rows[t] == 0 && c.row_bytes[t] == 0), "no such register");
        require(c.rows[t] <= ROWS && c.row_bytes[t] <= 4 * WORDS, "too large");
        require((c.rows[t] == 0) == (c.row_bytes[t] == 0), "rows without bytes, or bytes without rows");
    }
    configured = c;
    memset(tiles, 0, sizeof tiles);
}

void amx_configuration(void *to) {
    memcpy(to, &configured, sizeof configured);
}

/* The words of a row of a register that may be used. */
static size_t words_of(size_t t) {
    require(t < TILES && configured.palette == 1 && configured.rows[t] > 0, "not configured");
    require(configured.row_bytes[t] % 4 == 0, "not whole words");
    return configured.row_bytes[t] / 4u;
}

void amx_zero(size_t t) {
    (void)words_of(t);
    memset(tiles[t], 0, sizeof tiles[t]);
}

void amx_load(size_t t, const void *from, size_t step) {
    const size_t words = words_of(t);
    memset(tiles[t], 0, sizeof tiles[t]);
    for (size_t i = 0; i < configured.rows[t]; ++i)
        memcpy(tiles[t][i], (const char *)from + i * step, words * sizeof(uint32_t));
}

void amx_store(size_t t, void *to, size_t step) {
    const size_t words = words_of(t);
    for (size_t i = 0; i < configured.rows[t]; ++i)
        memcpy((char *)to + i * step, tiles[t][i], words * sizeof(uint32_t));
}

/* The words of a row of c; c (rows, words) += a (rows, depth) b (depth, words). */
static size_t check_product(size_t c, size_t a, size_t b) {
    const size_t words = words_of(c), depth = words_of(a);
    require(words_of(b) == words && configured.rows[b] == depth && configured.rows[a] == configured.rows[c],
            "shapes of the factors differ");
    require(c != a && c != b && a != b, "the same register twice");
    return words;
}

/* ---- bfloat16: operations round to nearest even, and denormal operands and results are 0 -------------------------- */

static float without_denormals(float x) {
    return fabsf(x) < FLT_MIN ? copysignf(0, x) : x;
}

/* The lower (half = 0) or upper bfloat16 of a word. */
static float operand(uint32_t word, int half) {
    const uint32_t bits = half ? word & 0xffff0000u : word << 16;
    float x;
    memcpy(&x, &bits, sizeof x);
    return without_denormals(x);
}

static float add(float x, float y) { /* denormal sums of floats are exact */
    return without_denormals(without_denormals(x) + without_denormals(y));
}

static float multiply_add(float a, float b, float sum) {
    const float result = nqm_multiply_add(a, b, sum);
    if (!(fabsf(result) <= FLT_MIN))
        return result;
    /* Denormal is what lies below FLT_MIN when rounded to 24 bits, of however small a number; doubles are exact enough. */
    return fabs((double)a * (double)b + (double)sum) < 0x1.ffffffp-127 ? copysignf(0, result) : result;
}

/* Products of lower and of upper halves are summed apart, then added to each other and to c. */
void amx_bf16(size_t c, size_t a, size_t b) {
    const size_t words = check_product(c, a, b), depth = words_of(a);
    float right[2][ROWS][WORDS];
    for (size_t i = 0; i < 2 * ROWS * WORDS; ++i)
        right[i % 2][i / 2 / WORDS][i / 2 % WORDS] = operand(tiles[b][i / 2 / WORDS][i / 2 % WORDS], i % 2);
    for (size_t i = 0; i < configured.rows[c]; ++i) {
        float sum[2][WORDS] = {{0}}, kept[WORDS];
        for (size_t k = 0; k < depth; ++k)
            for (int half = 0; half < 2; ++half) {
                const float left = operand(tiles[a][i][k], half);
                for (size_t j = 0; j < words; ++j)
                    sum[half][j] = multiply_add(left, right[half][k][j], sum[half][j]);
            }
        memcpy(kept, tiles[c][i], sizeof kept);
        for (size_t j = 0; j < words; ++j)
            kept[j] = add(kept[j], add(sum[0][j], sum[1][j]));
        memcpy(tiles[c][i], kept, words * sizeof *kept);
    }
}

/* ---- bytes: integers modulo 2^32 ---------------------------------------------------------------------------------- */

void amx_int8(size_t c, size_t a, size_t b) {
    const size_t words = check_product(c, a, b), depth = words_of(a);
    for (size_t i = 0; i < configured.rows[c]; ++i)
        for (size_t k = 0; k < depth; ++k)
            for (size_t j = 0; j < words; ++j)
                for (int shift = 0; shift < 32; shift += 8)
                    tiles[c][i][j] += (uint32_t)((int32_t)(uint8_t)(tiles[a][i][k] >> shift) *
                                                 (int32_t)(int8_t)(uint8_t)(tiles[b][k][j] >> shift));
}
