/* SPDX-License-Identifier: MIT
 *
 * Packing a network for inference, at once or when it begins to pay.
 */
#include "net/inference.h"
#include "net/inference_net.h"

#include <pthread.h>

/* ---- layers ------------------------------------------------------------------------------------------------------ */

/* Some neighbouring inputs of a layer. */
typedef struct range {
    size_t from, n;
} range;

/* Those inputs become the layer's next segment; w (n_out, n), ldw numbers from row to row, are their weights. Those that
 * stay floats are not packed yet. */
static nqm_status add_segment(nqm_inference_layer *layer, const float *w, size_t ldw, range inputs,
                              nqm_precision precision, nqm_error *err) {
    nqm_segment *s = &layer->segment[layer->n_segments++];
    nqm_status status = nqm_panels_create(precision, inputs.n, layer->n_out, &s->panel, err);
    if (status != NQM_OK)
        return status;
    s->from = inputs.from;
    s->at = layer->rounded;
    if (precision == NQM_PRECISION_F32) {
        s->w = w;
        s->ldw = ldw;
    } else {
        layer->rounded += s->panel.units;
        nqm_panels_pack(&s->panel, w, ldw);
    }
    return NQM_OK;
}

/* W_ref ref + W_test test = (W_ref + W_test) ref + W_test (test - ref): a test that hardly differs from its reference is
 * told apart by numbers that are rounded at their own, small, scale. */
static nqm_status add_sum_of_groups(nqm_inference_layer *layer, const float *w, size_t ldw, size_t n,
                                    nqm_precision precision, nqm_error *err) {
    float *sum = nqm_alloc(layer->n_out, n * sizeof *sum);
    if (!sum)
        return nqm_fail_nomem(err, layer->n_out * n * sizeof *sum);
    for (size_t j = 0; j < layer->n_out; ++j)
        for (size_t i = 0; i < n; ++i)
            sum[j * n + i] = w[j * ldw + i] + w[j * ldw + n + i];
    nqm_status status = add_segment(layer, sum, n, (range){0, n}, precision, err);
    layer->differences = true;
    nqm_free(sum);
    return status;
}

static nqm_status add_first_layer(nqm_inference_layer *layer, const nqm_params *params, const nqm_input_groups *inputs,
                                  nqm_precision precision, nqm_error *err) {
    const size_t n_in = params->shape.sizes[0];
    const float *w = params->layer[0].w;
    range next = {0};
    nqm_status status = NQM_OK;
    for (size_t i = 0; status == NQM_OK && i < inputs->n_groups; ++i) {
        next.n = inputs->width[i];
        if (i == 0 && inputs->test_itself && precision != NQM_PRECISION_F32)
            status = add_sum_of_groups(layer, w, n_in, next.n, precision, err);
        else
            status = add_segment(layer, w + next.from, n_in, next, precision, err);
        next.from += next.n;
    }
    next.n = inputs->n_scalars;
    if (status == NQM_OK && next.n)
        status = add_segment(layer, w + next.from, n_in, next, NQM_PRECISION_F32, err);
    return status;
}

static nqm_status add_layers(nqm_inference_net *net, const nqm_params *params, const nqm_input_groups *inputs,
                             nqm_precision precision, nqm_error *err) {
    const nqm_net_shape *shape = &params->shape;
    nqm_status status = NQM_OK;
    net->n_layers = shape->n_layers - 1;
    net->output = params->layer[net->n_layers].w;
    net->output_bias = params->layer[net->n_layers].b;
    for (size_t l = 0; status == NQM_OK && l < net->n_layers; ++l) {
        const nqm_layer *from = &params->layer[l];
        net->layer[l] = (nqm_inference_layer){
            .n_out = shape->sizes[l + 1], .bias = from->b, .gamma = from->gamma, .beta = from->beta};
        if (l == 0)
            status = add_first_layer(&net->layer[l], params, inputs, precision, err);
        else
            status = add_segment(&net->layer[l], from->w, shape->sizes[l], (range){0, shape->sizes[l]}, precision, err);
    }
    return status;
}

nqm_status nqm_inference_net_create(const nqm_params *params, const nqm_input_groups *inputs, nqm_precision precision,
                                    nqm_inference_net **net_ret, nqm_error *err) {
    *net_ret = NULL;
    nqm_inference_net *net = nqm_alloc(1, sizeof *net);
    if (!net)
        return nqm_fail_nomem(err, sizeof *net);
    nqm_status status = add_layers(net, params, inputs, precision, err);
    if (status != NQM_OK) {
        nqm_inference_net_free(net);
        return status;
    }
    *net_ret = net;
    return NQM_OK;
}

void nqm_inference_net_free(nqm_inference_net *net) {
    if (!net)
        return;
    for (size_t l = 0; l < net->n_layers; ++l)
        for (size_t s = 0; s < net->layer[l].n_segments; ++s)
            nqm_panels_free(&net->layer[l].segment[s].panel);
    nqm_free(net);
}

/* ---- when it begins to pay --------------------------------------------------------------------------------------- */

static pthread_mutex_t packing = PTHREAD_MUTEX_INITIALIZER; /* held while any network is packed */

static void pack_floats(nqm_inference_net *net) {
    for (size_t l = 0; l < net->n_layers; ++l)
        for (size_t s = 0; s < net->layer[l].n_segments; ++s) {
            nqm_segment *segment = &net->layer[l].segment[s];
            if (segment->w)
                nqm_panels_pack(&segment->panel, segment->w, segment->ldw);
        }
}

bool nqm_inference_net_packed(const nqm_inference_net *net, const nqm_kernels *kernels, size_t n) {
    nqm_inference_net *own = (nqm_inference_net *)(uintptr_t)net; /* the owner's calls see no difference */
    if (atomic_load_explicit(&own->packed, memory_order_acquire))
        return true;
    const bool few = n <= NQM_ROWS_UNPACKED && kernels != &nqm_kernels_scalar; /* whose sums cannot be cut */
    if (few && atomic_fetch_add(&own->n_calls, 1) < NQM_CALLS_UNPACKED)
        return false;
    pthread_mutex_lock(&packing);
    if (!own->packed) { /* nobody packed it while we waited */
        pack_floats(own);
        atomic_store_explicit(&own->packed, true, memory_order_release);
    }
    pthread_mutex_unlock(&packing);
    return true;
}
