/* SPDX-License-Identifier: MIT
 *
 * The kernels as plain loops in double, each result rounded once. They define the results: every other table is tested
 * against this one.
 */
#include "kernel/kernel.h"

#include <math.h>
#include <string.h>

/* ---- products ---------------------------------------------------------------------------------------------------- */

/* word_*: the sum of the products of the factors in two words. */
static double word_f32(uint32_t a, uint32_t b) {
    float x, y;
    memcpy(&x, &a, sizeof x);
    memcpy(&y, &b, sizeof y);
    return (double)x * (double)y;
}

static double word_bf16(uint32_t a, uint32_t b) {
    return word_f32(a << 16, b << 16) + word_f32(a & 0xffff0000u, b & 0xffff0000u);
}

typedef double (*word_product)(uint32_t a, uint32_t b);

static double sum_words(size_t words, const uint32_t *a, size_t a_step, const uint32_t *b, size_t b_step,
                        word_product product) {
    double sum = 0;
    for (size_t u = 0; u < words; ++u)
        sum += product(a[u * a_step], b[u * b_step]);
    return sum;
}

static void multiply(const nqm_product *p, word_product product) {
    for (size_t i = 0; i < p->m; ++i)
        for (size_t j = 0; j < p->n_panels * NQM_PANEL; ++j) {
            const uint32_t *a = (const uint32_t *)p->a + i * p->lda;
            const uint32_t *b = (const uint32_t *)p->b + j / NQM_PANEL * p->panel_step + j % NQM_PANEL;
            float *c = p->c + i * p->ldc + j;
            *c = (float)((p->add ? (double)*c : 0) + sum_words(p->words, a, 1, b, NQM_PANEL, product));
        }
}

static void product_f32(const nqm_product *p) {
    multiply(p, word_f32);
}

static void product_bf16(const nqm_product *p) {
    multiply(p, word_bf16);
}

static void strided_product(const nqm_strided_product *p) {
    for (size_t i = 0; i < p->m; ++i)
        for (size_t j = 0; j < NQM_PANEL; ++j) {
            float *c = p->c + i * p->ldc + j;
            double sum = p->add ? (double)*c : 0;
            for (size_t u = 0; u < p->k; ++u)
                sum += (double)p->a[i * p->lda + u * p->step] * (double)p->b[u * p->ldb + j];
            *c = (float)sum;
        }
}

static void gradient(const nqm_tile_gradient *g, word_product product) {
    const uint32_t *right = g->right;
    for (size_t i = 0; i < g->n_strips * NQM_STRIP; ++i) {
        const uint32_t *left = (const uint32_t *)g->left + i / NQM_STRIP * g->step + i % NQM_STRIP;
        for (size_t j = 0; j < NQM_PANEL; ++j)
            g->c[i * NQM_PANEL + j] = (float)sum_words(g->words, left, NQM_STRIP, right + j, NQM_PANEL, product);
    }
}

static void gradient_f32(const nqm_tile_gradient *g) {
    gradient(g, word_f32);
}

static void gradient_bf16(const nqm_tile_gradient *g) {
    gradient(g, word_bf16);
}

/* ---- rows -------------------------------------------------------------------------------------------------------- */

static float dot(size_t n, const float *x, const float *y) {
    double sum = 0;
    for (size_t i = 0; i < n; ++i)
        sum += (double)x[i] * (double)y[i];
    return (float)sum;
}

static double distribution(double x) {
    return 0.5 * erfc(-x / sqrt(2));
}

static double gelu_slope(double x) {
    return distribution(x) + x * exp(-0.5 * x * x) * 0.39894228040143268; /* 1 / sqrt(2 pi) */
}

static void gelu(size_t n, const float *x, float *y, float *slope) {
    for (size_t i = 0; i < n; ++i) {
        double at = (double)x[i];
        if (slope)
            slope[i] = (float)gelu_slope(at);
        y[i] = (float)(at * distribution(at));
    }
}

static void round_row(size_t n, const float *x, uint32_t *words) {
    for (size_t i = 0; i < n; i += 2)
        words[i / 2] = nqm_bf16_bits(x[i]) | (i + 1 < n ? nqm_bf16_bits(x[i + 1]) : 0) << 16;
}

static void round_pair(size_t n, const float *even, const float *odd, size_t width, size_t step, uint32_t *words) {
    for (size_t i = 0; i < (n + width - 1) / width * width; ++i)
        words[i / width * step + i % width] = i < n ? nqm_bf16_bits(even[i]) | nqm_bf16_bits(odd[i]) << 16 : 0;
}

static void round_tile(const float *x, uint32_t *words) {
    for (size_t i = 0; i < NQM_STRIP / 2; ++i, x += 2 * NQM_PANEL)
        round_pair(NQM_PANEL, x, x + NQM_PANEL, NQM_PANEL, 0, words + i * NQM_PANEL);
}

/* The factor of element i: 1 / (1 - p), or 0 if it is dropped. */
static double dropout_factor(const nqm_hidden_row *r, size_t i) {
    if (!(r->p > 0))
        return 1;
    uint64_t hash = nqm_hash_u64(r->key, r->counter + i / 4);
    bool keep = r->keep ? r->keep[i] : (long)(hash >> i % 4 * 16 & 0xffff) >= lrint(r->p * 65536.0);
    return keep ? 1 / (1 - r->p) : 0;
}

static void hidden_row(const nqm_hidden_row *r) {
    double mean = 0, variance = 0;
    for (size_t i = 0; i < r->n; ++i)
        mean += ((double)r->x[i] + (double)r->bias[i]) / (double)r->n;
    for (size_t i = 0; i < r->n; ++i) {
        double d = (double)r->x[i] + (double)r->bias[i] - mean;
        variance += d * d / (double)r->n;
    }
    double rstd = 1 / sqrt(variance + (double)NQM_LAYERNORM_EPS);
    for (size_t i = 0; i < r->n; ++i) {
        double xhat = ((double)r->x[i] + (double)r->bias[i] - mean) * rstd;
        double at = (double)r->gamma[i] * xhat + (double)r->beta[i];
        r->x[i] = (float)xhat;
        r->y[i] = (float)(at * distribution(at) * dropout_factor(r, i));
        if (r->slope)
            r->slope[i] = (float)(gelu_slope(at) * dropout_factor(r, i));
    }
    if (r->rstd)
        *r->rstd = (float)rstd;
}

static void hidden_row_back(const nqm_hidden_row_back *r) {
    double mean = 0, along = 0;
    for (size_t i = 0; i < r->n; ++i) {
        double da = (double)r->dy[i] * (double)r->slope[i];
        mean += (double)r->gamma[i] * da / (double)r->n;
        along += (double)r->gamma[i] * da * (double)r->xhat[i] / (double)r->n;
    }
    for (size_t i = 0; i < r->n; ++i) {
        double da = (double)r->dy[i] * (double)r->slope[i], xhat = (double)r->xhat[i];
        double dx = (double)r->rstd * ((double)r->gamma[i] * da - mean - xhat * along);
        r->dbeta[i] = (float)((double)r->dbeta[i] + da);
        r->dgamma[i] = (float)((double)r->dgamma[i] + da * xhat);
        r->dbias[i] = (float)((double)r->dbias[i] + dx);
        r->dy[i] = (float)dx;
    }
}

static void adam(size_t n, const nqm_adam_rate *rate, const float *grad, float *m, float *v, float *param) {
    for (size_t i = 0; i < n; ++i) {
        double g = (double)grad[i] + rate->weight_decay * (double)param[i];
        double m1 = NQM_ADAM_BETA1 * (double)m[i] + (1 - NQM_ADAM_BETA1) * g;
        double v1 = NQM_ADAM_BETA2 * (double)v[i] + (1 - NQM_ADAM_BETA2) * g * g;
        double step = rate->step_size * m1 / (sqrt(v1) * rate->v_scale + NQM_ADAM_EPSILON);
        m[i] = (float)m1;
        v[i] = (float)v1;
        param[i] = (float)((double)param[i] - step);
    }
}

const nqm_kernels nqm_kernels_scalar = {
    .name = "scalar",
    .product = {product_f32, product_bf16},
    .strided_product = strided_product,
    .gradient = {gradient_f32, gradient_bf16},
    .dot = dot,
    .hidden_row = hidden_row,
    .hidden_row_back = hidden_row_back,
    .gelu = gelu,
    .round_row = round_row,
    .round_pair = round_pair,
    .round_tile = round_tile,
    .adam = adam,
};
