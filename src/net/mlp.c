/* SPDX-License-Identifier: MIT
 *
 * Forward and backward pass of the paper's MLP (section 3.2). A training work holds, for each hidden layer, the output,
 * the normalised values and the slope of what follows them: 3 batch x width numbers. The way back reuses them as it
 * goes, so that a forward pass serves one backward pass.
 */
#include "kernel/kernel.h"
#include "net/layers.h"
#include "net/net.h"

struct nqm_net_work {
    nqm_net_shape shape;
    size_t max_batch;
    float *block;
    nqm_hidden hidden[NQM_NET_MAX_LAYERS]; /* buffers; `layer` is set when a pass begins */
};

/* Numbers of work memory: in training 3 buffers and a row of rstd a layer; in inference two buffers that take turns. */
static size_t work_size(const nqm_net_shape *shape, size_t batch, bool for_training, size_t *widest_ret) {
    size_t sum = 0, widest = 0;
    for (size_t l = 0; l + 1 < shape->n_layers; ++l) {
        size_t n = shape->sizes[l + 1];
        sum += 3 * n + 1;
        widest = n > widest ? n : widest;
    }
    *widest_ret = widest;
    return batch * (for_training ? sum : 2 * widest);
}

static float *take(float **next, size_t n) {
    float *block = *next;
    *next += n;
    return block;
}

nqm_status nqm_net_work_create(const nqm_net_shape *shape, size_t max_batch, bool for_training, nqm_net_work **work_ret,
                               nqm_error *err) {
    *work_ret = NULL;
    if (max_batch < 1 || max_batch > (size_t)1 << 24)
        return nqm_fail(err, NQM_ERR_ARG, -1, "network: batch of %zu is out of range (1..16777216)", max_batch);
    size_t widest, n = work_size(shape, max_batch, for_training, &widest);
    nqm_net_work *work = nqm_alloc(1, sizeof *work);
    float *block = nqm_alloc(n, sizeof *block);
    if (!work || !block) {
        nqm_free(work);
        nqm_free(block);
        return nqm_fail_nomem(err, n * sizeof *block);
    }
    *work = (nqm_net_work){.shape = *shape, .max_batch = max_batch, .block = block};
    float *next = block;
    for (size_t l = 0; l + 1 < shape->n_layers; ++l) {
        nqm_hidden *h = &work->hidden[l];
        *h = (nqm_hidden){.index = l, .n = shape->sizes[l + 1]};
        if (for_training) {
            h->y = take(&next, max_batch * h->n);
            h->xhat = take(&next, max_batch * h->n);
            h->slope = take(&next, max_batch * h->n);
            h->rstd = take(&next, max_batch);
        } else {
            h->y = block + l % 2 * max_batch * widest;
        }
    }
    *work_ret = work;
    return NQM_OK;
}

void nqm_net_work_free(nqm_net_work *work) {
    if (work)
        nqm_free(work->block);
    nqm_free(work);
}

/* C (batch, out) = x (batch, in) w^T. */
static void multiply_forward(size_t batch, size_t in, size_t out, const float *x, const float *w, float *c) {
    nqm_gemm g = {.m = batch, .n = out, .k = in, .alpha = 1, .trans_b = true};
    g.a = x, g.lda = in;
    g.b = w, g.ldb = in;
    g.c = c, g.ldc = out;
    nqm_kernels_get()->gemm(&g);
}

/* dw (out, in) = dz^T x. */
static void multiply_weight_gradient(size_t batch, size_t in, size_t out, const float *dz, const float *x, float *dw) {
    nqm_gemm g = {.m = out, .n = in, .k = batch, .alpha = 1, .trans_a = true};
    g.a = dz, g.lda = out;
    g.b = x, g.ldb = in;
    g.c = dw, g.ldc = in;
    nqm_kernels_get()->gemm(&g);
}

/* dx (batch, in) = dz w. */
static void multiply_backward(size_t batch, size_t in, size_t out, const float *dz, const float *w, float *dx) {
    nqm_gemm g = {.m = batch, .n = in, .k = out, .alpha = 1};
    g.a = dz, g.lda = out;
    g.b = w, g.ldb = in;
    g.c = dx, g.ldc = in;
    nqm_kernels_get()->gemm(&g);
}

void nqm_net_forward(const nqm_params *params, nqm_net_work *work, size_t batch, const float *x,
                     const nqm_dropout *dropout, float *z) {
    const nqm_net_shape *shape = &params->shape;
    size_t last = shape->n_layers - 1;
    for (size_t l = 0; l < last; ++l) {
        nqm_hidden *h = &work->hidden[l];
        h->layer = &params->layer[l];
        multiply_forward(batch, shape->sizes[l], h->n, x, h->layer->w, h->xhat ? h->xhat : h->y);
        nqm_hidden_forward(h, batch, dropout);
        x = h->y;
    }
    multiply_forward(batch, shape->sizes[last], 1, x, params->layer[last].w, z);
    for (size_t i = 0; i < batch; ++i)
        z[i] += params->layer[last].b[0];
}

void nqm_net_backward(const nqm_params *params, nqm_net_work *work, size_t batch, const float *x, const float *dz,
                      nqm_params *grads, float *dx) {
    const nqm_net_shape *shape = &params->shape;
    size_t last = shape->n_layers - 1;
    nqm_column_sums(batch, 1, dz, grads->layer[last].b);
    for (size_t l = last + 1; l-- > 0;) {
        size_t in = shape->sizes[l], out = shape->sizes[l + 1];
        nqm_hidden *below = l > 0 ? &work->hidden[l - 1] : NULL;
        multiply_weight_gradient(batch, in, out, dz, below ? below->y : x, grads->layer[l].w);
        float *dx_l = below ? below->y : dx; /* the layer's input has served: its gradient takes its place */
        if (!dx_l)
            return;
        multiply_backward(batch, in, out, dz, params->layer[l].w, dx_l);
        if (below)
            nqm_hidden_backward(below, batch, dx_l, &grads->layer[l - 1]);
        dz = dx_l;
    }
}
