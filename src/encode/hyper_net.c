/* SPDX-License-Identifier: MIT
 *
 * Forward and backward pass of the hypernetwork. It is invariant to the order of a set's samples (deep sets: Zaheer et al.
 * 2017, arXiv:1703.06114): all samples pass the same layers, whose outputs are pooled by mean and maximum.
 */
#include "encode/hyper.h"

#include <math.h>
#include <string.h>

/* ---- memory ------------------------------------------------------------------------------------------------------ */

nqm_status nqm_hyper_create(const nqm_hyper_shape *shape, nqm_hyper *hyper_ret, nqm_error *err) {
    *hyper_ret = (nqm_hyper){0};
    size_t n_in = NQM_HYPER_FEATURES;
    for (size_t l = 0; l < NQM_HYPER_N_LAYERS; ++l) {
        n_in = l == NQM_HYPER_POOLED ? 2 * n_in + 1 : n_in; /* the pooled vector */
        hyper_ret->layer[l] = (nqm_hyper_layer){.n_in = n_in, .n_out = shape->n_out[l]};
        hyper_ret->n += (n_in + 1) * shape->n_out[l];
        n_in = shape->n_out[l];
    }
    float *next = hyper_ret->block = nqm_alloc(hyper_ret->n, sizeof *next);
    if (!next)
        return nqm_fail_nomem(err, hyper_ret->n * sizeof *next);
    for (size_t l = 0; l < NQM_HYPER_N_LAYERS; ++l) {
        nqm_hyper_layer *layer = &hyper_ret->layer[l];
        layer->w = next;
        layer->b = next + layer->n_in * layer->n_out;
        next = layer->b + layer->n_out;
    }
    return NQM_OK;
}

void nqm_hyper_init(nqm_hyper *hyper, const float *mean, uint64_t seed) {
    const double last_layer_scale = 0.05;
    for (size_t l = 0; l < NQM_HYPER_N_LAYERS; ++l) {
        const nqm_hyper_layer *layer = &hyper->layer[l];
        bool is_last = l + 1 == NQM_HYPER_N_LAYERS;
        double deviation = sqrt(2.0 / (double)layer->n_in) * (is_last ? last_layer_scale : 1);
        nqm_rng rng = nqm_rng_make(seed, l);
        for (size_t i = 0; i < layer->n_in * layer->n_out; ++i)
            layer->w[i] = (float)(deviation * nqm_rng_normal(&rng));
        if (is_last)
            memcpy(layer->b, mean, layer->n_out * sizeof *mean);
        else
            memset(layer->b, 0, layer->n_out * sizeof *layer->b);
    }
}

nqm_status nqm_hyper_pass_create(const nqm_hyper *hyper, size_t n_sets, size_t n_samples, nqm_hyper_pass *pass_ret,
                                 nqm_error *err) {
    enum { N = NQM_HYPER_N_LAYERS };
    const nqm_hyper_layer *layer = hyper->layer;
    nqm_hyper_pass *p = pass_ret;
    size_t n_rows = n_sets * n_samples, widest = 0;
    nqm_array arrays[6 + 2 * N] = {
        {&p->input, n_rows, NQM_HYPER_FEATURES * sizeof(float)},
        {&p->pooled, n_sets, layer[NQM_HYPER_POOLED].n_in * sizeof(float)},
        {&p->largest, n_sets, layer[NQM_HYPER_POOLED - 1].n_out * sizeof(size_t)},
    };
    *p = (nqm_hyper_pass){.n_sets = n_sets, .n_samples = n_samples};
    for (size_t l = 0; l < N; ++l) {
        size_t rows = l < NQM_HYPER_POOLED ? n_rows : n_sets;
        widest = nqm_larger(widest, rows * (nqm_row_stride(layer[l].n_in) + nqm_row_stride(layer[l].n_out)));
        arrays[6 + l] = (nqm_array){&p->y[l], rows * layer[l].n_out, sizeof(float)};
        arrays[6 + N + l] = (nqm_array){&p->slope[l], rows * layer[l].n_out, sizeof(float)};
    }
    for (size_t i = 0; i < 3; ++i)
        arrays[3 + i] = (nqm_array){i < 2 ? &p->spare[i] : &p->padded, widest, sizeof(float)};
    nqm_status status = nqm_alloc_arrays(5 + 2 * N, arrays, err); /* no slope in the last layer */
    for (size_t l = 0; l < N && status == NQM_OK; ++l) {
        status = nqm_panels_create(NQM_PRECISION_F32, layer[l].n_in, layer[l].n_out, &p->forward[l], err);
        if (status == NQM_OK)
            status = nqm_panels_create(NQM_PRECISION_F32, layer[l].n_out, layer[l].n_in, &p->backward[l], err);
    }
    return status;
}

void nqm_hyper_pass_free(nqm_hyper_pass *pass) {
    for (size_t l = 0; l < NQM_HYPER_N_LAYERS; ++l) {
        nqm_panels_free(&pass->forward[l]);
        nqm_panels_free(&pass->backward[l]);
    }
    nqm_free(pass->input); /* the block of all arrays */
    *pass = (nqm_hyper_pass){0};
}

/* ---- forward ----------------------------------------------------------------------------------------------------- */

/* y (rows, b->n) = x (rows, b->k) B. */
static void multiply(const nqm_panels *b, size_t rows, const float *x, float *padded, float *y) {
    const size_t stride = nqm_row_stride(b->n);
    nqm_multiply(b, rows, x, b->k, false, padded, stride);
    for (size_t i = 0; i < rows; ++i)
        memcpy(y + i * b->n, padded + i * stride, b->n * sizeof *y);
}

/* y (rows, n_out) = x (rows, n_in) W + b; with GELU and its slope unless slope is NULL. */
static void layer_forward(const nqm_hyper_layer *layer, nqm_hyper_pass *pass, size_t l, size_t rows, const float *x) {
    const size_t n_out = layer->n_out;
    nqm_panels *w = &pass->forward[l];
    float *y = pass->y[l];
    for (size_t i = 0; i < layer->n_in; ++i)
        nqm_columns_copy(n_out, layer->w + i * n_out, NQM_PANEL, w->stride * NQM_PANEL,
                         (float *)w->data + i * NQM_PANEL);
    multiply(w, rows, x, pass->padded, y);
    for (size_t i = 0; i < rows; ++i)
        for (size_t j = 0; j < n_out; ++j)
            y[i * n_out + j] += layer->b[j];
    if (pass->slope[l])
        nqm_gelu(rows * n_out, y, y, pass->slope[l]);
}

static float round_to(float value, float step) {
    return step > 0 ? step * roundf(value / step) : value;
}

/* Mean and maximum of each channel over the samples of each set, then the logarithm of the number of samples, so that the
 * network can give a small set less weight. */
static void pool(const nqm_hyper *hyper, nqm_hyper_pass *pass) {
    enum { USUAL_COUNT = 200 };
    size_t n = hyper->layer[NQM_HYPER_POOLED - 1].n_out, n_samples = pass->n_samples;
    for (size_t set = 0; set < pass->n_sets; ++set) {
        const float *y = pass->y[NQM_HYPER_POOLED - 1] + set * n_samples * n;
        float *mean = pass->pooled + set * (2 * n + 1), *top = mean + n;
        size_t *largest = pass->largest + set * n;
        for (size_t j = 0; j < n; ++j) {
            double sum = 0;
            size_t best = 0;
            for (size_t i = 0; i < n_samples; ++i) {
                sum += (double)y[i * n + j];
                best = y[i * n + j] > y[best * n + j] ? i : best;
            }
            mean[j] = round_to((float)(sum / (double)n_samples), hyper->step);
            top[j] = round_to(y[best * n + j], hyper->step);
            largest[j] = best;
        }
        mean[2 * n] = (float)log((double)n_samples / USUAL_COUNT);
    }
}

const float *nqm_hyper_forward(const nqm_hyper *hyper, nqm_hyper_pass *pass) {
    const float *x = pass->input;
    size_t rows = pass->n_sets * pass->n_samples;
    for (size_t l = 0; l < NQM_HYPER_N_LAYERS; ++l) {
        if (l == NQM_HYPER_POOLED) {
            pool(hyper, pass);
            x = pass->pooled;
            rows = pass->n_sets;
        }
        layer_forward(&hyper->layer[l], pass, l, rows, x);
        x = pass->y[l];
    }
    return x;
}

/* ---- backward ---------------------------------------------------------------------------------------------------- */

/* Receives tiles of the gradient of the weights of a layer. */
static void store_tiles(void *user, size_t strip, size_t n_strips, size_t panel, const float *tiles) {
    const nqm_hyper_layer *gradient = user;
    const size_t first = strip * NQM_STRIP, column = panel * NQM_PANEL;
    const size_t n_rows = nqm_smaller(n_strips * NQM_STRIP, gradient->n_in - first);
    for (size_t i = 0; i < n_rows; ++i)
        memcpy(gradient->w + (first + i) * gradient->n_out + column, tiles + i * NQM_PANEL,
               nqm_smaller(NQM_PANEL, gradient->n_out - column) * sizeof *tiles);
}

/* x (rows, n) in groups of `width` columns. */
static nqm_columns columns_of(size_t rows, size_t n, size_t width, const float *x, float *groups) {
    for (size_t i = 0; i < rows; ++i)
        nqm_columns_copy(n, x + i * n, width, rows * width, groups + i * width);
    return (nqm_columns){.data = groups, .step = rows * width};
}

/* dz (rows, n_out): gradient with respect to x W + b. Writes the gradients with respect to W and b. */
static void layer_backward(size_t rows, const float *x, const float *dz, float *padded, nqm_hyper_layer *gradient) {
    const size_t n_in = gradient->n_in, n_out = gradient->n_out;
    nqm_gradient_run(&(nqm_gradient){.precision = NQM_PRECISION_F32,
                                     .m = rows,
                                     .k = n_in,
                                     .n = n_out,
                                     .x = columns_of(rows, n_in, NQM_STRIP, x, padded),
                                     .z = columns_of(rows, n_out, NQM_PANEL, dz, padded + rows * nqm_row_stride(n_in)),
                                     .sink = store_tiles,
                                     .user = gradient});
    memset(gradient->b, 0, n_out * sizeof(float));
    for (size_t i = 0; i < rows; ++i)
        for (size_t j = 0; j < n_out; ++j)
            gradient->b[j] += dz[i * n_out + j];
}

/* Gradient with respect to the outputs dy (n_sets n_samples, n) of the last sample layer, from that of the pooled vector. */
static void pool_backward(const nqm_hyper *hyper, const nqm_hyper_pass *pass, const float *d_pooled, float *dy) {
    size_t n = hyper->layer[NQM_HYPER_POOLED - 1].n_out, n_samples = pass->n_samples;
    float per_sample = 1 / (float)n_samples;
    for (size_t set = 0; set < pass->n_sets; ++set) {
        const float *d_mean = d_pooled + set * (2 * n + 1), *d_top = d_mean + n;
        float *rows = dy + set * n_samples * n;
        for (size_t i = 0; i < n_samples; ++i)
            for (size_t j = 0; j < n; ++j)
                rows[i * n + j] = per_sample * d_mean[j];
        for (size_t j = 0; j < n; ++j)
            rows[pass->largest[set * n + j] * n + j] += d_top[j];
    }
}

void nqm_hyper_backward(const nqm_hyper *hyper, nqm_hyper_pass *pass, const float *d_out, nqm_hyper *gradient) {
    const float *dz = d_out;
    size_t rows = pass->n_sets;
    for (size_t l = NQM_HYPER_N_LAYERS; l-- > 0;) {
        const float *x = l == 0 ? pass->input : l == NQM_HYPER_POOLED ? pass->pooled : pass->y[l - 1];
        float *dx = pass->spare[l % 2];
        layer_backward(rows, x, dz, pass->padded, &gradient->layer[l]);
        if (l == 0)
            break;
        nqm_panels_pack(&pass->backward[l], (nqm_weights){hyper->layer[l].w, NULL, hyper->layer[l].n_out});
        multiply(&pass->backward[l], rows, dz, pass->padded, dx);
        if (l == NQM_HYPER_POOLED) {
            float *dy = pass->spare[(l + 1) % 2]; /* dz is no longer needed */
            rows *= pass->n_samples;
            pool_backward(hyper, pass, dx, dy);
            dx = dy;
        }
        float *slope = pass->slope[l - 1];
        for (size_t i = 0; i < rows * hyper->layer[l - 1].n_out; ++i)
            slope[i] *= dx[i];
        dz = slope;
    }
}
