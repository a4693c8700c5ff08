/* SPDX-License-Identifier: MIT
 *
 * The forward pass of a network that keeps what the backward pass needs, and the backward pass to its inputs, without gradients
 * of weights.
 */
#include "net/input_gradient.h"
#include "kernel/panel.h"

#include <string.h>

typedef struct layer {
    size_t in, out;
    nqm_panels forward, backward; /* W^T and W */
} layer;

/* Rows of max_batch. */
struct nqm_gradient_net {
    const nqm_params *params;
    size_t n_ref, n_hidden;
    layer layer[NQM_NET_MAX_LAYERS];
    size_t n, stride; /* rows of the call; floats from row to row of y and dy */
    float *xhat[NQM_NET_MAX_LAYERS], *slope[NQM_NET_MAX_LAYERS], *rstd[NQM_NET_MAX_LAYERS];
    float *y, *dy;    /* outputs of a layer, and the gradient by them */
    float *discarded; /* (max_batch, stride) receives gradients by bias, gamma and beta */
    bool has_ref;     /* the following are those of the last call with one row */
    float *ref;       /* (n_ref) inputs */
    float *partial;   /* (stride) their contribution to the product of layer 0 */
};

/* ---- creation ---------------------------------------------------------------------------------------------------- */

static nqm_status pack(nqm_gradient_net *net, size_t l, nqm_error *err) {
    layer *to = &net->layer[l];
    nqm_status status = nqm_panels_create(NQM_PRECISION_F32, to->in, to->out, &to->forward, err);
    if (status == NQM_OK)
        status = nqm_panels_create(NQM_PRECISION_F32, to->out, to->in, &to->backward, err);
    if (status != NQM_OK)
        return status;
    nqm_panels_pack(&to->forward, (nqm_weights){net->params->layer[l].w, net->params->layer[l].half, to->in});
    nqm_panels_transpose(&to->forward, &to->backward);
    return NQM_OK;
}

nqm_status nqm_gradient_net_create(const nqm_params *params, size_t n_ref, size_t max_batch, nqm_gradient_net **net_ret,
                                   nqm_error *err) {
    nqm_gradient_net *net, made = {.params = params, .n_ref = n_ref, .n_hidden = params->shape.n_layers - 1};
    float *kept;
    size_t widest = 0;
    *net_ret = NULL;
    for (size_t l = 0; l < made.n_hidden; ++l) {
        made.layer[l] = (layer){.in = params->shape.sizes[l], .out = params->shape.sizes[l + 1]};
        widest = nqm_larger(widest, made.layer[l].out);
    }
    made.stride = nqm_row_stride(widest);
    const size_t row = made.stride * sizeof *kept, n_rows = made.n_hidden * max_batch;
    nqm_status status =
        nqm_alloc_arrays(NQM_ARRAYS({&net, 1, sizeof *net}, {&made.y, max_batch, row}, {&made.dy, max_batch, row},
                                    {&made.discarded, max_batch, row}, {&made.ref, n_ref, sizeof *made.ref},
                                    {&made.partial, 1, row}, {&kept, n_rows, 2 * row + sizeof *kept}),
                         err);
    if (status != NQM_OK)
        return status;
    for (size_t l = 0; l < made.n_hidden; ++l) {
        made.xhat[l] = kept + 2 * l * max_batch * made.stride;
        made.slope[l] = made.xhat[l] + max_batch * made.stride;
        made.rstd[l] = kept + 2 * n_rows * made.stride + l * max_batch;
    }
    *net = made;
    for (size_t l = 0; status == NQM_OK && l < net->n_hidden; ++l)
        status = pack(net, l, err);
    if (status == NQM_OK)
        *net_ret = net;
    else
        nqm_gradient_net_free(net);
    return status;
}

void nqm_gradient_net_free(nqm_gradient_net *net) {
    for (size_t l = 0; net && l < net->n_hidden; ++l) {
        nqm_panels_free(&net->layer[l].forward);
        nqm_panels_free(&net->layer[l].backward);
    }
    nqm_free(net);
}

/* ---- passes ------------------------------------------------------------------------------------------------------ */

/* Hidden layer l of all rows. */
static void hidden_forward(nqm_gradient_net *w, size_t l) {
    const nqm_layer *p = &w->params->layer[l];
#pragma omp parallel for schedule(static) if (w->n * w->layer[l].out >= NQM_MIN_PARALLEL)
    for (size_t i = 0; i < w->n; ++i)
        nqm_kernels_get()->hidden_row(&(nqm_hidden_row){.n = w->layer[l].out,
                                                        .bias = p->b,
                                                        .gamma = p->gamma,
                                                        .beta = p->beta,
                                                        .x = w->xhat[l] + i * w->stride,
                                                        .y = w->y + i * w->stride,
                                                        .slope = w->slope[l] + i * w->stride,
                                                        .rstd = w->rstd[l] + i});
}

static void hidden_back(nqm_gradient_net *w, size_t l) {
#pragma omp parallel for schedule(static) if (w->n * w->layer[l].out >= NQM_MIN_PARALLEL)
    for (size_t i = 0; i < w->n; ++i) {
        float *discarded = w->discarded + i * w->stride;
        nqm_kernels_get()->hidden_row_back(&(nqm_hidden_row_back){.n = w->layer[l].out,
                                                                  .gamma = w->params->layer[l].gamma,
                                                                  .xhat = w->xhat[l] + i * w->stride,
                                                                  .slope = w->slope[l] + i * w->stride,
                                                                  .rstd = w->rstd[l][i],
                                                                  .dy = w->dy + i * w->stride,
                                                                  .dbias = discarded,
                                                                  .dgamma = discarded,
                                                                  .dbeta = discarded});
    }
}

/* Rows [first, first + n) of all panels of floats. */
static nqm_panels rows_of(nqm_panels panels, size_t first, size_t n) {
    panels.k = panels.words = n;
    panels.data += first * NQM_PANEL;
    return panels;
}

/* All panels from panel `first` on. */
static nqm_panels panels_from(nqm_panels panels, size_t first) {
    panels.n -= first * NQM_PANEL;
    panels.n_panels -= first;
    panels.data = nqm_panel_at(&panels, first);
    return panels;
}

/* The product of layer 0. A fit scores one pair at a time, always with the same reference, and reading weights takes
 * most of its time. */
static void multiply_inputs(nqm_gradient_net *w, size_t n, const float *x) {
    const layer *first = &w->layer[0];
    const size_t n_ref = w->n_ref, ldx = nqm_row_stride(first->in);
    const nqm_panels ref = rows_of(first->forward, 0, n_ref), rest = rows_of(first->forward, n_ref, first->in - n_ref);
    if (n > 1) {
        nqm_multiply(&ref, n, x, ldx, false, w->xhat[0], w->stride);
    } else {
        /* NOLINTNEXTLINE(bugprone-suspicious-memory-comparison): equal bits are meant */
        if (!w->has_ref || memcmp(w->ref, x, n_ref * sizeof *x) != 0)
            nqm_multiply(&ref, 1, x, ldx, false, w->partial, w->stride);
        w->has_ref = true;
        memcpy(w->ref, x, n_ref * sizeof *x);
        memcpy(w->xhat[0], w->partial, w->stride * sizeof *w->partial);
    }
    nqm_multiply(&rest, n, x + n_ref, ldx, true, w->xhat[0], w->stride);
}

void nqm_gradient_forward(nqm_gradient_net *w, size_t n, const float *x, float *z) {
    const nqm_layer *output = &w->params->layer[w->n_hidden];
    const size_t n_last = w->layer[w->n_hidden - 1].out, n_outputs = w->params->shape.sizes[w->n_hidden + 1];
    w->n = n;
    for (size_t l = 0; l < w->n_hidden; ++l) {
        if (l == 0)
            multiply_inputs(w, n, x);
        else
            nqm_multiply(&w->layer[l].forward, n, w->y, w->stride, false, w->xhat[l], w->stride);
        hidden_forward(w, l);
    }
    for (size_t i = 0; i < n * n_outputs; ++i) {
        const size_t o = i % n_outputs;
        z[i] = output->b[o] + nqm_kernels_get()->dot(n_last, w->y + i / n_outputs * w->stride, output->w + o * n_last);
    }
}

void nqm_gradient_backward(nqm_gradient_net *w, size_t n, const float *dz, float *dx) {
    const nqm_layer *output = &w->params->layer[w->n_hidden];
    const size_t n_last = w->layer[w->n_hidden - 1].out, n_outputs = w->params->shape.sizes[w->n_hidden + 1];
    for (size_t i = 0; i < n; ++i) {
        float *dy = memset(w->dy + i * w->stride, 0, n_last * sizeof *dy);
        for (size_t o = 0; o < n_outputs; ++o)
            for (size_t k = 0; k < n_last; ++k)
                dy[k] += dz[i * n_outputs + o] * output->w[o * n_last + k];
    }
    for (size_t l = w->n_hidden; l-- > 0;) {
        hidden_back(w, l);
        if (l == 0) {
            const size_t first = w->n_ref / NQM_PANEL; /* panels before hold columns of the reference only */
            const nqm_panels needed = panels_from(w->layer[0].backward, first);
            nqm_multiply(&needed, n, w->dy, w->stride, false, dx + first * NQM_PANEL, nqm_row_stride(w->layer[0].in));
        } else {
            float *below = w->y;
            nqm_multiply(&w->layer[l].backward, n, w->dy, w->stride, false, below, w->stride);
            w->y = w->dy;
            w->dy = below;
        }
    }
}
