/* SPDX-License-Identifier: MIT
 *
 * isa_rows.h - Adam, rounding and the rows of hidden layers for one instruction set: loops that compilers vectorise,
 * included by each file isa_*.c after isa_products.h. Every instruction set gives the same bits: multiply-adds are
 * fused by name only (nqm_multiply_add()), nothing is reordered, and a row always has GROUP partial sums, whatever the
 * vector width.
 */
#include "kernel/gelu.h"
#include "kernel/kernel.h"

#include <math.h>
#include <string.h>

/* ---- Adam -------------------------------------------------------------------------------------------------------- */

/* Kingma and Ba 2015, arXiv:1412.6980, as in torch.optim.Adam: L2 weight decay is added to the gradient, and both moments
 * are corrected for their start at zero. */
static void adam(size_t n, const nqm_adam_rate *rate, const float *grad, float *m, float *v, float *param) {
    const float keep1 = (float)NQM_ADAM_BETA1, add1 = (float)(1 - NQM_ADAM_BETA1);
    const float keep2 = (float)NQM_ADAM_BETA2, add2 = (float)(1 - NQM_ADAM_BETA2);
    const float small = (float)NQM_ADAM_EPSILON, decay = (float)rate->weight_decay;
    const float step_size = (float)rate->step_size, scale = (float)rate->v_scale;
#pragma omp simd
    for (size_t i = 0; i < n; ++i) {
        float g = grad[i] + decay * param[i];
        m[i] = keep1 * m[i] + add1 * g;
        v[i] = keep2 * v[i] + add2 * (g * g);
        param[i] -= step_size * m[i] / (sqrtf(v[i]) * scale + small);
    }
}

/* ---- rounding to bfloat16 ------------------------------------------------------------------------------------------ */

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

/* ---- rows in groups ---------------------------------------------------------------------------------------------- */

/* A row has GROUP partial sums: element i is added to sum i % GROUP. */
enum { GROUP = 32, GROUP_VECTORS = GROUP / LANES };

/* The last GROUP elements of a row; a shorter row is copied to the end of `filled` after zeros. */
static inline const float *last_group(size_t n, const float *x, float *filled) {
    if (n >= GROUP)
        return x + n - GROUP;
    memset(filled, 0, GROUP * sizeof *filled);
    memcpy(filled + GROUP - n, x, n * sizeof *filled);
    return filled;
}

static inline void store_last_group(size_t n, const float *group, float *x) {
    if (n >= GROUP)
        memcpy(x + n - GROUP, group, GROUP * sizeof *x);
    else
        memcpy(x, group + GROUP - n, n * sizeof *x);
}

/* Mask for the last, partial group of n % GROUP elements: in_last_group + n % GROUP is 1 for these and 0 before. */
static const float in_last_group[2 * GROUP] = {[GROUP] = 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1,
                                               1,           1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};

/* The sum of all partial sums, by halves. */
static inline float add_sums(vector_f *sum) {
    UNROLL for (size_t n = GROUP_VECTORS / 2; n > 0; n /= 2) UNROLL for (size_t v = 0; v < n; ++v) sum[v] += sum[v + n];
    float half[LANES];
    memcpy(half, sum, sizeof half);
    UNROLL for (size_t n = LANES / 2; n > 0; n /= 2) UNROLL for (size_t j = 0; j < n; ++j) half[j] += half[j + n];
    return half[0];
}

/* What a sum over rows x and y adds for a = x[i], b = y[i]. */
typedef enum row_term { TERM_SUM, TERM_SQUARE, TERM_FIRST, TERM_PRODUCT } row_term;

/* sum += TERM for the GROUP elements from x and y on; `term` is a constant where this is inlined. */
INLINE void add_group(row_term term, const float *x, const float *y, float c, vector_f *sum) {
    UNROLL for (size_t v = 0; v < GROUP_VECTORS; ++v) {
        const vector_f a = *(const vector_f *)(x + v * LANES), b = *(const vector_f *)(y + v * LANES);
        if (term == TERM_SUM)
            sum[v] += a + b;
        else if (term == TERM_SQUARE)
            sum[v] += (a + b - c) * (a + b - c);
        else if (term == TERM_FIRST)
            sum[v] += a;
        else
            sum[v] += a * b;
    }
}

INLINE float row_sum(row_term term, size_t n, const float *x, const float *y, float c) {
    vector_f sum[GROUP_VECTORS] = {{0}}, last[GROUP_VECTORS] = {{0}};
    float filled_x[GROUP], filled_y[GROUP];
    for (size_t i = 0; i + GROUP <= n; i += GROUP)
        add_group(term, x + i, y + i, c, sum);
    add_group(term, last_group(n, x, filled_x), last_group(n, y, filled_y), c, last);
    UNROLL for (size_t v = 0; v < GROUP_VECTORS; ++v) sum[v] +=
        last[v] * *(const vector_f *)(in_last_group + n % GROUP + v * LANES);
    return add_sums(sum);
}

static float dot(size_t n, const float *x, const float *y) {
    return row_sum(TERM_PRODUCT, n, x, y, 0);
}

/* ---- dropout ----------------------------------------------------------------------------------------------------- */

/* Multiply y and slope by `scale` where the mask (n) keeps, by 0 elsewhere. */
static inline void apply_mask(size_t n, const uint8_t *keep, float scale, float *y, float *slope) {
#pragma omp simd
    for (size_t i = 0; i < n; ++i) {
        float factor = keep[i] ? scale : 0.0f;
        y[i] *= factor;
        slope[i] *= factor;
    }
}

static void drop_by_hash(const nqm_hidden_row *r) {
    enum { HASHES = 16, ELEMENTS = 4 * HASHES };
    enum { order = NQM_BIG_ENDIAN ? 3 : 0 }; /* the lowest 16 bits of a hash come first */
    const long threshold = lrint(r->p * 65536.0);
    const float scale = (float)(1.0 / (1.0 - r->p));
    /* nqm_hash_u64() of consecutive counters */
    uint64_t unmixed = nqm_hash_key(r->key) + (r->counter + 1) * NQM_GOLDEN;
    for (size_t first = 0; first < r->n; first += ELEMENTS, unmixed += HASHES * NQM_GOLDEN) {
        uint64_t hashes[HASHES];
        uint16_t bits[ELEMENTS];
#pragma omp simd
        for (size_t i = 0; i < HASHES; ++i)
            hashes[i] = nqm_hash_mix(unmixed + i * NQM_GOLDEN);
        memcpy(bits, hashes, sizeof bits);
        const size_t n = r->n - first < ELEMENTS ? r->n - first : ELEMENTS;
        float *y = r->y + first, *slope = r->slope + first;
#pragma omp simd
        for (size_t i = 0; i < n; ++i) {
            float factor = (int32_t)bits[i ^ order] >= (int32_t)threshold ? scale : 0.0f;
            y[i] *= factor;
            slope[i] *= factor;
        }
    }
}

/* ---- hidden layers: LayerNorm (Ba, Kiros and Hinton 2016, arXiv:1607.06450; eps 1e-5), GELU, inverted dropout ------ */

/* n values, a multiple of the vector width. Two loops, since the chain of one would exceed the processor's reorder window. */
INLINE void activate(size_t n, const nqm_hidden_row *r, float mean, float rstd) {
    const float *bias = r->bias, *gamma = r->gamma, *beta = r->beta;
    float *x = r->x, *y = r->y;
#pragma omp simd
    for (size_t i = 0; i < n; ++i) {
        x[i] = (x[i] + bias[i] - mean) * rstd;
        y[i] = nqm_multiply_add(gamma[i], x[i], beta[i]);
    }
    gelu_stretch(n, y, y, r->slope);
}

/* A partial last group is computed as the last GROUP elements, before x is overwritten; elements that are computed twice get
 * the same bits. A scalar loop over up to 31 elements would take as long as hundreds. */
static void activate_row(const nqm_hidden_row *r, float mean, float rstd) {
    const size_t n = r->n;
    float filled[3][GROUP], x[GROUP], y[GROUP], slope[GROUP];
    const nqm_hidden_row last = {.bias = last_group(n, r->bias, filled[0]),
                                 .gamma = last_group(n, r->gamma, filled[1]),
                                 .beta = last_group(n, r->beta, filled[2]),
                                 .x = x,
                                 .y = y,
                                 .slope = r->slope ? slope : NULL};
    memcpy(x, last_group(n, r->x, y), sizeof x);
    activate(GROUP, &last, mean, rstd);
    activate(n - n % GROUP, r, mean, rstd);
    store_last_group(n, x, r->x);
    store_last_group(n, y, r->y);
    if (r->slope)
        store_last_group(n, slope, r->slope);
}

static void hidden_row(const nqm_hidden_row *r) {
    const float mean = row_sum(TERM_SUM, r->n, r->x, r->bias, 0) / (float)r->n;
    const float variance = row_sum(TERM_SQUARE, r->n, r->x, r->bias, mean) / (float)r->n;
    const float rstd = (float)(1.0 / sqrt((double)variance + (double)NQM_LAYERNORM_EPS));
    activate_row(r, mean, rstd);
    if (r->rstd)
        *r->rstd = rstd;
    if (r->p > 0 && r->keep)
        apply_mask(r->n, r->keep, (float)(1.0 / (1.0 - r->p)), r->y, r->slope);
    else if (r->p > 0)
        drop_by_hash(r);
}

/* With da = dy slope and g = gamma da: d(product) = rstd (g - mean(g) - xhat mean(g xhat)). */
static void hidden_row_back(const nqm_hidden_row_back *r) {
    const size_t n = r->n;
    const float *gamma = r->gamma, *xhat = r->xhat, *slope = r->slope;
    const float rstd = r->rstd;
    float *g = r->dy, *dbias = r->dbias, *dgamma = r->dgamma, *dbeta = r->dbeta;
#pragma omp simd
    for (size_t i = 0; i < n; ++i) {
        float da = g[i] * slope[i];
        dbeta[i] += da;
        dgamma[i] += da * xhat[i];
        g[i] = gamma[i] * da;
    }
    const float mean = row_sum(TERM_FIRST, n, g, g, 0) / (float)r->n;
    const float along = row_sum(TERM_PRODUCT, n, g, xhat, 0) / (float)r->n;
#pragma omp simd
    for (size_t i = 0; i < n; ++i) {
        g[i] = rstd * (g[i] - mean - xhat[i] * along);
        dbias[i] += g[i];
    }
}

/* The table of an instruction set. */
#define NQM_DEFINE_KERNELS(SUFFIX, NAME)                                                                               \
    const nqm_kernels nqm_kernels_##SUFFIX = {                                                                         \
        .name = (NAME),                                                                                                \
        .product = {product_f32, product_bf16},                                                                        \
        .strided_product = strided_product,                                                                            \
        .gradient = {gradient_f32, gradient_bf16},                                                                     \
        .hidden_row = hidden_row,                                                                                      \
        .dot = dot,                                                                                                    \
        .hidden_row_back = hidden_row_back,                                                                            \
        .gelu = gelu,                                                                                                  \
        .round_row = round_row,                                                                                        \
        .round_pair = round_pair,                                                                                      \
        .round_tile = round_tile,                                                                                      \
        .adam = adam,                                                                                                  \
    }
