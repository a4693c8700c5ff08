/* SPDX-License-Identifier: MIT
 *
 * rows.h - GELU, Adam and the rows of hidden layers for one instruction set: loops that a compiler vectorises, included
 * by each file isa_*.c. Nothing is contracted or reordered, partial sums of a row are ROW_SUMS whatever the width of a
 * register: every instruction set gives the same bits.
 *
 * GELU (Hendrycks and Gimpel 2016, arXiv:1606.08415): one exponential serves the function and its slope. e = exp(-x^2/2)
 * is the density phi up to a constant, and Abramowitz and Stegun 7.1.26 (1964, after Hastings 1955) gives
 * erfc(u) = (a1 t + .. + a5 t^5) exp(-u^2), t = 1/(1 + p u), with an error below 1.5e-7, where u = |x|/sqrt(2) makes
 * exp(-u^2) that same e.
 */
#include "kernel/exp_log.h"
#include "kernel/kernel.h"
#include "kernel/rounding.h"
#include "kernel/transform.h"

#include <math.h>
#include <string.h>

/* ---- GELU -------------------------------------------------------------------------------------------------------- */

/* exp(x) for x <= 0; below -80 it is 0: products with smaller numbers are denormal, which takes three times as long. */
static inline float exp_negative(float x) {
    float e = nqm_exp_core(x < -80.0f ? -80.0f : x);
    return x < -80.0f ? 0.0f : e;
}

typedef struct normal {
    float distribution, density; /* Phi(x), phi(x) */
} normal;

static inline normal normal_at(float x) {
    const float p = 0.3275911f * 0.70710678f;
    float e = exp_negative(-0.5f * x * x);
    float t = 1.0f / (1.0f + p * fabsf(x));
    float poly = 1.061405429f;
    poly = poly * t - 1.453152027f;
    poly = poly * t + 1.421413741f;
    poly = poly * t - 0.284496736f;
    poly = poly * t + 0.254829592f;
    float upper_tail = 0.5f * poly * t * e; /* 1 - Phi(|x|) */
    return (normal){x > 0.0f ? 1.0f - upper_tail : upper_tail, 0.398942280f * e};
}

/* n values: at best a multiple of a register. */
static inline void gelu_stretch(size_t n, const float *x, float *y, float *slope) {
    if (!slope) {
#pragma omp simd
        for (size_t i = 0; i < n; ++i)
            y[i] = x[i] * normal_at(x[i]).distribution;
        return;
    }
#pragma omp simd
    for (size_t i = 0; i < n; ++i) {
        normal at = normal_at(x[i]);
        slope[i] = at.distribution + x[i] * at.density;
        y[i] = x[i] * at.distribution;
    }
}

/* The last few are filled up to whole registers: one by one they would take as long as hundreds. */
static void gelu(size_t n, const float *x, float *y, float *slope) {
    enum { STRETCH = 16 };
    const size_t whole = n / STRETCH * STRETCH, left = n - whole;
    gelu_stretch(whole, x, y, slope);
    if (left == 0)
        return;
    float last_x[STRETCH] = {0}, last_y[STRETCH], last_slope[STRETCH];
    memcpy(last_x, x + whole, left * sizeof *x);
    gelu_stretch(STRETCH, last_x, last_y, slope ? last_slope : NULL);
    memcpy(y + whole, last_y, left * sizeof *y);
    if (slope)
        memcpy(slope + whole, last_slope, left * sizeof *slope);
}

/* ---- scaled copies of samples ------------------------------------------------------------------------------------ */

/* With c = cbrt(f_r) and k = 1 + k1: log(k c + 1) = t + log(1 + k1 c / (c + 1)) and c / (c + 1) = 1 - exp(-t). The
 * argument's magnitude is below 0.018, so that four terms of the logarithm's series leave less than 4e-10. */
static void scale_log(size_t n, float k1, const float *t, float *scaled) {
#pragma omp simd
    for (size_t i = 0; i < n; ++i) {
        float a = k1 * (1.0f - exp_negative(-t[i]));
        scaled[i] = t[i] + a * (1.0f - a * (0.5f - a * (1.0f / 3.0f - a * 0.25f)));
    }
}

/* ---- Adam -------------------------------------------------------------------------------------------------------- */

/* Kingma and Ba 2015, arXiv:1412.6980, as torch.optim.Adam does it: L2 weight decay is added to the gradient, and both
 * moments are corrected for their start at zero. */
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

/* ---- sums along a row -------------------------------------------------------------------------------------------- */

enum { ROW_SUMS = 16 }; /* partial sums of a row */

static inline double add_sums(const float *sum) {
    double total = 0;
    for (size_t j = 0; j < ROW_SUMS; ++j)
        total += (double)sum[j];
    return total;
}

static double row_mean(size_t n, const float *x) {
    float sum[ROW_SUMS] = {0};
    size_t i = 0;
    for (; i + ROW_SUMS <= n; i += ROW_SUMS)
#pragma omp simd
        for (size_t j = 0; j < ROW_SUMS; ++j)
            sum[j] += x[i + j];
    for (size_t j = 0; i < n; ++i, ++j)
        sum[j] += x[i];
    return add_sums(sum) / (double)n;
}

static double row_variance(size_t n, const float *x, float mean) {
    float sum[ROW_SUMS] = {0};
    size_t i = 0;
    for (; i + ROW_SUMS <= n; i += ROW_SUMS)
#pragma omp simd
        for (size_t j = 0; j < ROW_SUMS; ++j)
            sum[j] += (x[i + j] - mean) * (x[i + j] - mean);
    for (size_t j = 0; i < n; ++i, ++j)
        sum[j] += (x[i] - mean) * (x[i] - mean);
    return add_sums(sum) / (double)n;
}

static double row_mean_product(size_t n, const float *x, const float *y) {
    float sum[ROW_SUMS] = {0};
    size_t i = 0;
    for (; i + ROW_SUMS <= n; i += ROW_SUMS)
#pragma omp simd
        for (size_t j = 0; j < ROW_SUMS; ++j)
            sum[j] += x[i + j] * y[i + j];
    for (size_t j = 0; i < n; ++i, ++j)
        sum[j] += x[i] * y[i];
    return add_sums(sum) / (double)n;
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
    const uint64_t key = nqm_hash_key(r->key);
    const long threshold = lrint(r->p * 65536.0);
    const float scale = (float)(1.0 / (1.0 - r->p));
    uint64_t counter = r->counter;
    for (size_t first = 0; first < r->n; first += ELEMENTS, counter += HASHES) {
        uint64_t hashes[HASHES];
        uint16_t bits[ELEMENTS];
        uint8_t keep[ELEMENTS];
#pragma omp simd
        for (size_t i = 0; i < HASHES; ++i)
            hashes[i] = nqm_hash_keyed(key, counter + i);
        memcpy(bits, hashes, sizeof bits);
#pragma omp simd
        for (size_t i = 0; i < ELEMENTS; ++i)
            keep[i] = bits[i] >= threshold;
        size_t n = r->n - first < ELEMENTS ? r->n - first : ELEMENTS;
        apply_mask(n, keep, scale, r->y + first, r->slope + first);
    }
}

/* ---- hidden layers: LayerNorm (Ba, Kiros and Hinton 2016, arXiv:1607.06450; eps 1e-5), GELU, inverted dropout ------ */

static void hidden_row(const nqm_hidden_row *r) {
    const size_t n = r->n;
    const float *bias = r->bias, *gamma = r->gamma, *beta = r->beta;
    float *x = r->x, *y = r->y;
#pragma omp simd
    for (size_t i = 0; i < n; ++i)
        x[i] += bias[i];
    const float mean = (float)row_mean(n, x);
    const float rstd = (float)(1.0 / sqrt(row_variance(n, x, mean) + (double)NQM_LAYERNORM_EPS));
#pragma omp simd
    for (size_t i = 0; i < n; ++i) {
        x[i] = (x[i] - mean) * rstd;
        y[i] = gamma[i] * x[i] + beta[i];
    }
    gelu(n, y, y, r->slope);
    if (r->rstd)
        *r->rstd = rstd;
    if (r->p > 0 && r->keep)
        apply_mask(n, r->keep, (float)(1.0 / (1.0 - r->p)), y, r->slope);
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
    const float mean = (float)row_mean(n, g), along = (float)row_mean_product(n, g, xhat);
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
        .gemm = nqm_gemm_onednn,                                                                                       \
        .product = {product_f32, product_bf16, product_int8},                                                          \
        .row_product = {row_product_f32, row_product_bf16, row_product_int8},                                          \
        .gradient = {gradient_f32, gradient_bf16, NULL},                                                               \
        .hidden_row = hidden_row,                                                                                      \
        .hidden_row_back = hidden_row_back,                                                                            \
        .gelu = gelu,                                                                                                  \
        .round_row = round_row,                                                                                        \
        .round_tile = round_tile,                                                                                      \
        .quantise_row = quantise_row,                                                                                  \
        .dequantise = dequantise,                                                                                      \
        .sample_log = sample_log,                                                                                      \
        .cube_root = cube_root,                                                                                        \
        .log_1p = log_1p,                                                                                              \
        .scale_log = scale_log,                                                                                        \
        .adam = adam,                                                                                                  \
    }
