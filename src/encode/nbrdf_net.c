/* SPDX-License-Identifier: MIT
 *
 * Forward and backward pass of an NBRDF over blocks of directions that fit into the L1 cache. Arrays are (neuron,
 * direction). Products are summed in tiles of fixed shape, so that the result does not depend on the vector width of the
 * processor; the block is compiled for three widths.
 */
#include "encode/encode.h"

#include "math/exp_log.h"
#include "math/math.h"

#include <math.h>

enum { N_IN = 6, N_HIDDEN = 21, N_OUT = 3, BLOCK = 64, LANES = 8 };
enum { TILE = 3, STRIPS = 2 }; /* every layer's width is a multiple of TILE */

/* Offsets of each layer's weights and biases. */
enum {
    W1 = 0,
    B1 = W1 + N_IN * N_HIDDEN,
    W2 = B1 + N_HIDDEN,
    B2 = W2 + N_HIDDEN * N_HIDDEN,
    W3 = B2 + N_HIDDEN,
    B3 = W3 + N_HIDDEN * N_OUT
};
_Static_assert(B3 + N_OUT == NQM_NBRDF_WEIGHTS, "the weights of three layers");

typedef float lanes __attribute__((vector_size(LANES * sizeof(float))));
#define INLINED static inline __attribute__((always_inline))

typedef float row[BLOCK]; /* one value for each direction of the block */

/* Activations of one block. Lanes after its n directions are computed with weight 0. */
typedef struct block {
    row input[N_IN], first[N_HIDDEN], second[N_HIDDEN], out[N_OUT];
    row d_out[N_OUT], d_second[N_HIDDEN], d_first[N_HIDDEN]; /* derivatives of the loss */
    row weight, scale, goal[N_OUT];                          /* scale: 1 / (3 n of the batch), or 0 */
    row error;                                               /* summed over channels */
} block;

INLINED lanes load(const float *x) {
    lanes v;
    memcpy(&v, x, sizeof v);
    return v;
}

/* Weights of a layer, or of its transpose: w[k stride_in + j stride_out]. */
typedef struct matrix {
    const float *w;
    size_t stride_in, stride_out;
} matrix;

/* y[j] = b[j] + sum over k of m(k, j) x[k]; b may be NULL. */
INLINED void product(size_t n_in, size_t n_out, matrix m, const float *b, const row *x, row *y) {
    for (size_t j = 0; j < n_out; j += TILE)
        for (size_t l = 0; l < BLOCK; l += STRIPS * LANES) {
            lanes sum[TILE][STRIPS];
            for (size_t t = 0; t < TILE; ++t)
                for (size_t s = 0; s < STRIPS; ++s)
                    sum[t][s] = (lanes){0} + (b ? b[j + t] : 0);
            for (size_t k = 0; k < n_in; ++k)
                for (size_t t = 0; t < TILE; ++t)
                    for (size_t s = 0; s < STRIPS; ++s)
                        sum[t][s] += m.w[k * m.stride_in + (j + t) * m.stride_out] * load(&x[k][l + s * LANES]);
            for (size_t t = 0; t < TILE; ++t)
                for (size_t s = 0; s < STRIPS; ++s)
                    memcpy(&y[j + t][l + s * LANES], &sum[t][s], sizeof(lanes));
        }
}

INLINED float sum_lanes(lanes v) {
    float part[LANES];
    memcpy(part, &v, sizeof part);
    for (size_t half = LANES / 2; half; half /= 2)
        for (size_t m = 0; m < half; ++m)
            part[m] += part[m + half];
    return part[0];
}

/* dw (n_in, n_out) += x d^T, db += d, both summed over the block. */
INLINED void weight_gradient(size_t n_in, size_t n_out, const row *x, const row *d, float *dw, float *db) {
    for (size_t k = 0; k < n_in; k += TILE)
        for (size_t j = 0; j < n_out; j += TILE) {
            lanes sum[TILE][TILE] = {0};
            for (size_t l = 0; l < BLOCK; l += LANES)
                for (size_t s = 0; s < TILE; ++s)
                    for (size_t t = 0; t < TILE; ++t)
                        sum[s][t] += load(&x[k + s][l]) * load(&d[j + t][l]);
            for (size_t s = 0; s < TILE; ++s)
                for (size_t t = 0; t < TILE; ++t)
                    dw[(k + s) * n_out + j + t] += sum_lanes(sum[s][t]);
        }
    for (size_t j = 0; j < n_out; ++j) {
        lanes sum = {0};
        for (size_t l = 0; l < BLOCK; l += LANES)
            sum += load(&d[j][l]);
        db[j] += sum_lanes(sum);
    }
}

INLINED void relu(row *x) {
    for (size_t j = 0; j < N_HIDDEN; ++j)
        for (size_t l = 0; l < BLOCK; ++l)
            x[j][l] = x[j][l] > 0 ? x[j][l] : 0;
}

/* d = 0 where the ReLU gave 0. */
INLINED void relu_gradient(const row *x, row *d) {
    for (size_t j = 0; j < N_HIDDEN; ++j)
        for (size_t l = 0; l < BLOCK; ++l)
            d[j][l] = x[j][l] > 0 ? d[j][l] : 0;
}

/* Loss of one channel and its derivative with respect to the network's output x. x is clamped to 80, above which exp()
 * overflows; the derivative is that at the clamped value, not 0, so that gradient descent reduces x. */
INLINED void channel_loss(block *b, size_t c) {
#pragma omp simd
    for (size_t l = 0; l < BLOCK; ++l) {
        float x = b->out[c][l], weight = b->weight[l];
        x = x < -60.0f ? -60.0f : x;
        x = x > 80.0f ? 80.0f : x;
        float rise = weight * nqm_exp_core(x), inside = (1.0f - weight) + rise; /* 1 + c (exp(x) - 1) */
        float error = nqm_log_core(inside) - b->goal[c][l];
        float slope = rise / inside * b->scale[l];
        b->error[l] += fabsf(error) * b->scale[l];
        b->d_out[c][l] = error > 0 ? slope : error < 0 ? -slope : 0;
    }
}

/* Loss of the block, and its gradient added to `gradient` unless that is NULL. */
NQM_FOR_EACH_VECTOR_WIDTH static void run_block(const float *w, block *b, float *gradient) {
    product(N_IN, N_HIDDEN, (matrix){w + W1, N_HIDDEN, 1}, w + B1, b->input, b->first);
    relu(b->first);
    product(N_HIDDEN, N_HIDDEN, (matrix){w + W2, N_HIDDEN, 1}, w + B2, b->first, b->second);
    relu(b->second);
    product(N_HIDDEN, N_OUT, (matrix){w + W3, N_OUT, 1}, w + B3, b->second, b->out);
    for (size_t c = 0; c < N_OUT; ++c)
        channel_loss(b, c);
    if (!gradient)
        return;
    weight_gradient(N_HIDDEN, N_OUT, b->second, b->d_out, gradient + W3, gradient + B3);
    product(N_OUT, N_HIDDEN, (matrix){w + W3, 1, N_OUT}, NULL, b->d_out, b->d_second);
    relu_gradient(b->second, b->d_second);
    weight_gradient(N_HIDDEN, N_HIDDEN, b->first, b->d_second, gradient + W2, gradient + B2);
    product(N_HIDDEN, N_HIDDEN, (matrix){w + W2, 1, N_HIDDEN}, NULL, b->d_second, b->d_first);
    relu_gradient(b->first, b->d_first);
    weight_gradient(N_IN, N_HIDDEN, b->input, b->d_first, gradient + W1, gradient + B1);
}

/* Copy n floats and fill the rest of the block with zeros. */
static void fill(const float *from, size_t n, float *to) {
    memcpy(to, from, n * sizeof *to);
    memset(to + n, 0, (BLOCK - n) * sizeof *to);
}

double nqm_nbrdf_loss(const float *weights, const nqm_nbrdf_batch *batch, float *gradient) {
    block b;
    double loss = 0;
    float scale = 1 / (float)(N_OUT * batch->n);
    if (gradient)
        memset(gradient, 0, NQM_NBRDF_WEIGHTS * sizeof *gradient);
    for (size_t from = 0; from < batch->n; from += BLOCK) {
        size_t n = batch->n - from < BLOCK ? batch->n - from : BLOCK;
        for (size_t k = 0; k < N_IN; ++k)
            fill(batch->input + k * batch->n + from, n, b.input[k]);
        for (size_t c = 0; c < N_OUT; ++c)
            fill(batch->goal + c * batch->n + from, n, b.goal[c]);
        fill(batch->weight + from, n, b.weight);
        for (size_t l = 0; l < BLOCK; ++l)
            b.scale[l] = l < n ? scale : 0;
        memset(b.error, 0, sizeof b.error);
        run_block(weights, &b, gradient);
        for (size_t l = 0; l < n; ++l)
            loss += (double)b.error[l];
    }
    return loss;
}

void nqm_nbrdf_inputs(size_t n, const double *hd, float *input, float *weight) {
    for (size_t i = 0; i < n; ++i) {
        double wi[3], wo[3], difference[3];
        nqm_half_diff_to_pair(hd + 3 * i, wi, wo);
        nqm_spherical(hd[3 * i + 1], hd[3 * i + 2], difference);
        input[i] = (float)sin(hd[3 * i]);
        input[n + i] = 0;
        input[2 * n + i] = (float)cos(hd[3 * i]);
        for (size_t k = 0; k < 3; ++k)
            input[(3 + k) * n + i] = (float)difference[k];
        weight[i] = (float)fmin(fmax(wi[2], 0), 1);
    }
}

void nqm_nbrdf_fill(size_t n, const double *hd, const double *rgb, float *input, float *weight, float *goal) {
    nqm_nbrdf_inputs(n, hd, input, weight);
    for (size_t i = 0; i < n; ++i)
        for (size_t c = 0; c < 3; ++c)
            goal[c * n + i] = (float)log1p((double)weight[i] * rgb[3 * i + c]);
}
