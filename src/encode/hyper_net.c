/* SPDX-License-Identifier: MIT
 *
 * Forward pass of the hypernetwork. It is invariant to the order of a set's samples (deep sets: Zaheer et al.
 * 2017, arXiv:1703.06114): all samples pass the same layers, whose outputs are pooled by mean and maximum.
 */
#include "encode/encode.h"
#include "kernel/panel.h"

#include <math.h>
#include <string.h>

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

/* y (rows, nqm_row_stride(n_out)) = x (rows, n_in) W + b, ldx floats from row to row; with GELU unless is_last. */
static nqm_status layer_forward(const nqm_hyper_layer *layer, bool is_last, size_t rows, const float *x, size_t ldx,
                                float *y, nqm_error *err) {
    const size_t n_out = layer->n_out, stride = nqm_row_stride(n_out);
    nqm_panels w;
    nqm_status status = nqm_panels_create(NQM_PRECISION_F32, layer->n_in, n_out, &w, err);
    if (status != NQM_OK)
        return status;
    for (size_t i = 0; i < layer->n_in; ++i)
        nqm_columns_copy(n_out, layer->w + i * n_out, NQM_PANEL, w.stride * NQM_PANEL, (float *)w.data + i * NQM_PANEL);
    nqm_multiply(&w, rows, x, ldx, false, y, stride);
    nqm_panels_free(&w);
    for (size_t i = 0; i < rows; ++i) {
        float *row = y + i * stride;
        for (size_t j = 0; j < n_out; ++j)
            row[j] += layer->b[j];
        if (!is_last)
            nqm_gelu(n_out, row, row, NULL);
    }
    return NQM_OK;
}

static float round_to(float value, float step) {
    return step > 0 ? step * roundf(value / step) : value;
}

/* Mean and maximum of each of the n columns of y (n_samples, nqm_row_stride(n)), then the logarithm of the number of
 * samples, so that the network can give a small set less weight: pooled (2 n + 1). */
static void pool(size_t n, size_t n_samples, const float *y, float step, float *pooled) {
    enum { USUAL_COUNT = 200 };
    const size_t stride = nqm_row_stride(n);
    for (size_t j = 0; j < n; ++j) {
        double sum = 0;
        float top = y[j];
        for (size_t i = 0; i < n_samples; ++i) {
            sum += (double)y[i * stride + j];
            top = y[i * stride + j] > top ? y[i * stride + j] : top;
        }
        pooled[j] = round_to((float)(sum / (double)n_samples), step);
        pooled[n + j] = round_to(top, step);
    }
    pooled[2 * n] = (float)log((double)n_samples / USUAL_COUNT);
}

nqm_status nqm_hyper_forward(const nqm_hyper *hyper, size_t n_samples, const float *x, float step, float *weights,
                             nqm_error *err) {
    const nqm_hyper_layer *layer = hyper->layer;
    const size_t n_pooled = layer[NQM_HYPER_POOLED].n_in;
    size_t rows = n_samples, ldx = NQM_HYPER_FEATURES, widest = 0;
    float *y[2], *pooled;
    for (size_t l = 0; l < NQM_HYPER_N_LAYERS; ++l)
        widest = nqm_larger(widest, nqm_row_stride(layer[l].n_out));
    nqm_status status =
        nqm_alloc_arrays(NQM_ARRAYS({&y[0], rows, widest * sizeof(float)}, {&y[1], rows, widest * sizeof(float)},
                                    {&pooled, n_pooled, sizeof(float)}),
                         err);
    if (status != NQM_OK)
        return status;
    for (size_t l = 0; status == NQM_OK && l < NQM_HYPER_N_LAYERS; ++l) {
        if (l == NQM_HYPER_POOLED) {
            pool(layer[l - 1].n_out, n_samples, x, step, pooled);
            x = pooled;
            ldx = n_pooled;
            rows = 1;
        }
        status = layer_forward(&layer[l], l + 1 == NQM_HYPER_N_LAYERS, rows, x, ldx, y[l % 2], err);
        x = y[l % 2];
        ldx = nqm_row_stride(layer[l].n_out);
    }
    if (status == NQM_OK)
        memcpy(weights, x, layer[NQM_HYPER_N_LAYERS - 1].n_out * sizeof *weights);
    nqm_free(y[0]);
    return status;
}
