/* SPDX-License-Identifier: MIT
 *
 * Bias, LayerNorm (Ba, Kiros and Hinton 2016, arXiv:1607.06450; eps 1e-5), GELU and inverted dropout of a hidden layer,
 * row by row while a row is in the first cache, and their gradients. Rows are independent; sums over rows run down
 * fixed strips of columns in the order of the rows: no result depends on the number of threads.
 */
#include "net/layers.h"

#include "kernel/kernel.h"

#include <math.h>
#include <string.h>

enum {
    LANES = 16,          /* partial sums of a row; fixed, so that every instruction set adds in the same order */
    STRIP = 64,          /* columns that one thread sums down at a time */
    MIN_PARALLEL = 16384 /* numbers; below, waking a thread costs more than it saves */
};

static const float layernorm_eps = 1e-5f;

/* ---- sums along a row -------------------------------------------------------------------------------------------- */

static double add_lanes(const float *lane) {
    double sum = 0;
    for (size_t j = 0; j < LANES; ++j)
        sum += (double)lane[j];
    return sum;
}

static double row_mean(size_t n, const float *x) {
    float lane[LANES] = {0};
    size_t i = 0;
    for (; i + LANES <= n; i += LANES)
#pragma omp simd
        for (size_t j = 0; j < LANES; ++j)
            lane[j] += x[i + j];
    for (size_t j = 0; i < n; ++i, ++j)
        lane[j] += x[i];
    return add_lanes(lane) / (double)n;
}

static double row_variance(size_t n, const float *x, float mean) {
    float lane[LANES] = {0};
    size_t i = 0;
    for (; i + LANES <= n; i += LANES)
#pragma omp simd
        for (size_t j = 0; j < LANES; ++j)
            lane[j] += (x[i + j] - mean) * (x[i + j] - mean);
    for (size_t j = 0; i < n; ++i, ++j)
        lane[j] += (x[i] - mean) * (x[i] - mean);
    return add_lanes(lane) / (double)n;
}

static double row_mean_product(size_t n, const float *x, const float *y) {
    float lane[LANES] = {0};
    size_t i = 0;
    for (; i + LANES <= n; i += LANES)
#pragma omp simd
        for (size_t j = 0; j < LANES; ++j)
            lane[j] += x[i + j] * y[i + j];
    for (size_t j = 0; i < n; ++i, ++j)
        lane[j] += x[i] * y[i];
    return add_lanes(lane) / (double)n;
}

/* ---- dropout ----------------------------------------------------------------------------------------------------- */

/* Multiply y and slope by `scale` where the mask (n) keeps, by 0 elsewhere. */
static void apply_mask(size_t n, const uint8_t *keep, float scale, float *y, float *slope) {
#pragma omp simd
    for (size_t i = 0; i < n; ++i) {
        float factor = keep[i] ? scale : 0.0f;
        y[i] *= factor;
        slope[i] *= factor;
    }
}

/* The same by hashes: element i of row r is dropped when its 16 bits of hash r ceil(n/4) + i/4 are below p. */
static void apply_hashed_mask(const nqm_hidden *h, size_t row, const nqm_dropout *dropout, float *y, float *slope) {
    enum { HASHES = 16, ELEMENTS = 4 * HASHES };
    uint64_t key = nqm_hash_u64(dropout->seed, dropout->step * NQM_NET_MAX_LAYERS + h->index);
    uint64_t counter = row * ((h->n + 3) / 4);
    long threshold = lrint(dropout->p * 65536.0);
    for (size_t first = 0; first < h->n; first += ELEMENTS, counter += HASHES) {
        uint64_t hashes[HASHES];
        uint16_t bits[ELEMENTS];
        uint8_t keep[ELEMENTS];
        for (size_t i = 0; i < HASHES; ++i)
            hashes[i] = nqm_hash_u64(key, counter + i);
        memcpy(bits, hashes, sizeof bits);
#pragma omp simd
        for (size_t i = 0; i < ELEMENTS; ++i)
            keep[i] = bits[i] >= threshold;
        size_t n = h->n - first < ELEMENTS ? h->n - first : ELEMENTS;
        apply_mask(n, keep, (float)(1.0 / (1.0 - dropout->p)), y + first, slope + first);
    }
}

static void drop(const nqm_hidden *h, size_t row, const nqm_dropout *dropout, float *y, float *slope) {
    const uint8_t *given = dropout->given[h->index];
    if (given)
        apply_mask(h->n, given + row * h->n, (float)(1.0 / (1.0 - dropout->p)), y, slope);
    else
        apply_hashed_mask(h, row, dropout, y, slope);
}

/* ---- forward ----------------------------------------------------------------------------------------------------- */

/* x = (x + b - mean) rstd; returns rstd. */
static float normalise_row(size_t n, const float *b, float *x) {
#pragma omp simd
    for (size_t i = 0; i < n; ++i)
        x[i] += b[i];
    float mean = (float)row_mean(n, x);
    float rstd = (float)(1.0 / sqrt(row_variance(n, x, mean) + (double)layernorm_eps));
#pragma omp simd
    for (size_t i = 0; i < n; ++i)
        x[i] = (x[i] - mean) * rstd;
    return rstd;
}

static void forward_row(const nqm_hidden *h, size_t row, const nqm_dropout *dropout) {
    size_t n = h->n;
    const float *gamma = h->layer->gamma, *beta = h->layer->beta;
    float *y = h->y + row * n;
    float *x = h->xhat ? h->xhat + row * n : y;
    float *slope = h->slope ? h->slope + row * n : NULL;
    float rstd = normalise_row(n, h->layer->b, x);
#pragma omp simd
    for (size_t i = 0; i < n; ++i)
        y[i] = gamma[i] * x[i] + beta[i];
    nqm_gelu(n, y, y, slope);
    if (h->rstd)
        h->rstd[row] = rstd;
    if (dropout && dropout->p > 0)
        drop(h, row, dropout, y, slope);
}

void nqm_hidden_forward(const nqm_hidden *hidden, size_t batch, const nqm_dropout *dropout) {
#pragma omp parallel for schedule(static) if (batch * hidden->n >= MIN_PARALLEL)
    for (size_t row = 0; row < batch; ++row)
        forward_row(hidden, row, dropout);
}

/* ---- backward ---------------------------------------------------------------------------------------------------- */

/* slope becomes da = d loss / d (LayerNorm's output); dy becomes
 * d loss / d (LayerNorm's input) = rstd (g - mean(g) - xhat mean(g xhat)), g = gamma da. */
static void backward_row(const nqm_hidden *h, size_t row, float *dy) {
    size_t n = h->n;
    const float *gamma = h->layer->gamma, *xhat = h->xhat + row * n;
    float *da = h->slope + row * n;
    float *g = dy + row * n;
#pragma omp simd
    for (size_t i = 0; i < n; ++i) {
        da[i] *= g[i];
        g[i] = gamma[i] * da[i];
    }
    float mean = (float)row_mean(n, g);
    float along = (float)row_mean_product(n, g, xhat);
    float rstd = h->rstd[row];
#pragma omp simd
    for (size_t i = 0; i < n; ++i)
        g[i] = rstd * (g[i] - mean - xhat[i] * along);
}

/* Gradients of columns [from, from + width): b sums dz, beta sums da, gamma sums da xhat. */
static void sum_strip(const nqm_hidden *h, size_t batch, const float *dz, const nqm_layer *grad, size_t from) {
    double db[STRIP] = {0}, dbeta[STRIP] = {0}, dgamma[STRIP] = {0};
    size_t width = h->n - from < STRIP ? h->n - from : STRIP;
    for (size_t row = 0; row < batch; ++row) {
        size_t at = row * h->n + from;
#pragma omp simd
        for (size_t j = 0; j < width; ++j) {
            float da = h->slope[at + j];
            db[j] += (double)dz[at + j];
            dbeta[j] += (double)da;
            dgamma[j] += (double)(da * h->xhat[at + j]);
        }
    }
    for (size_t j = 0; j < width; ++j) {
        grad->b[from + j] = (float)db[j];
        grad->beta[from + j] = (float)dbeta[j];
        grad->gamma[from + j] = (float)dgamma[j];
    }
}

void nqm_hidden_backward(const nqm_hidden *hidden, size_t batch, float *dy, const nqm_layer *grad) {
#pragma omp parallel for schedule(static) if (batch * hidden->n >= MIN_PARALLEL)
    for (size_t row = 0; row < batch; ++row)
        backward_row(hidden, row, dy);
#pragma omp parallel for schedule(static) if (batch * hidden->n >= MIN_PARALLEL)
    for (size_t from = 0; from < hidden->n; from += STRIP)
        sum_strip(hidden, batch, dy, grad, from);
}

void nqm_column_sums(size_t rows, size_t columns, const float *x, float *sums) {
    for (size_t j = 0; j < columns; ++j) {
        double sum = 0;
        for (size_t i = 0; i < rows; ++i)
            sum += (double)x[i * columns + j];
        sums[j] = (float)sum;
    }
}
