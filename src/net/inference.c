/* SPDX-License-Identifier: MIT
 *
 * Creation of networks for inference and of their workspaces.
 */
#include "net/inference.h"
#include "net/inference_state.h"

#include <omp.h>

/* ---- network ----------------------------------------------------------------------------------------------------- */

typedef struct range {
    size_t first, n;
} range;

/* Add a segment for those inputs; w (n_out, n) are their weights, packed now or later. */
static nqm_status add_segment(nqm_inference_layer *layer, nqm_weights w, range inputs, nqm_precision precision,
                              bool later, nqm_error *err) {
    nqm_segment *s = &layer->segment[layer->n_segments++];
    nqm_status status = nqm_panels_create(precision, inputs.n, layer->n_out, &s->panels, err);
    if (status != NQM_OK)
        return status;
    s->first = inputs.first;
    s->word = layer->n_words;
    if (precision != NQM_PRECISION_F32)
        layer->n_words += s->panels.words;
    if (later)
        s->weights = w;
    else
        nqm_panels_pack(&s->panels, w);
    return NQM_OK;
}

/* W_ref ref + W_test test = (W_ref + W_test) ref + W_test (test - ref). The right side rounds the difference at its own,
 * small, scale, so that a test which hardly differs from its reference keeps its score. */
static nqm_status add_sum_of_groups(nqm_inference_layer *layer, nqm_weights w, size_t n, nqm_precision precision,
                                    nqm_error *err) {
    float *sum = nqm_alloc(layer->n_out + 2, n * sizeof *sum); /* and two rows that are converted */
    if (!sum)
        return nqm_fail_nomem(err, layer->n_out * n * sizeof *sum);
    float *converted = sum + layer->n_out * n;
    for (size_t j = 0; j < layer->n_out; ++j) {
        const float *a = nqm_weights_row(nqm_weights_at(w, j, 0), n, converted);
        const float *b = nqm_weights_row(nqm_weights_at(w, j, n), n, converted + n);
        for (size_t i = 0; i < n; ++i)
            sum[j * n + i] = a[i] + b[i];
    }
    nqm_status status = add_segment(layer, (nqm_weights){sum, NULL, n}, (range){0, n}, precision, false, err);
    layer->differences = true;
    nqm_free(sum);
    return status;
}

static nqm_status add_first_segments(nqm_inference_layer *layer, const nqm_params *params,
                                     const nqm_input_groups *inputs, nqm_precision precision, nqm_error *err) {
    const size_t n_in = params->shape.sizes[0];
    const nqm_weights w = {params->layer[0].w, params->layer[0].half, n_in};
    const bool later = precision == NQM_PRECISION_F32;
    range next = {0};
    nqm_status status = NQM_OK;
    for (size_t i = 0; status == NQM_OK && i < inputs->n_groups; ++i, next.first += next.n) {
        next.n = inputs->width;
        if (i == 0 && inputs->test_itself && !later)
            status = add_sum_of_groups(layer, w, next.n, precision, err);
        else
            status = add_segment(layer, nqm_weights_at(w, 0, next.first), next, precision, later, err);
    }
    next.n = inputs->n_scalars;
    if (status == NQM_OK && next.n)
        status = add_segment(layer, nqm_weights_at(w, 0, next.first), next, NQM_PRECISION_F32, later, err);
    return status;
}

static nqm_status add_layers(nqm_inference_net *net, const nqm_params *params, const nqm_input_groups *inputs,
                             nqm_precision precision, nqm_error *err) {
    const nqm_net_shape *shape = &params->shape;
    nqm_status status = NQM_OK;
    net->is_packed = precision != NQM_PRECISION_F32;
    net->n_layers = shape->n_layers - 1;
    net->n_outputs = shape->sizes[shape->n_layers];
    net->output = params->layer[net->n_layers].w;
    net->output_bias = params->layer[net->n_layers].b;
    for (size_t l = 0; status == NQM_OK && l < net->n_layers; ++l) {
        const nqm_layer *from = &params->layer[l];
        const size_t n_in = shape->sizes[l];
        nqm_inference_layer *layer = &net->layer[l];
        *layer = (nqm_inference_layer){
            .n_out = shape->sizes[l + 1], .bias = from->b, .gamma = from->gamma, .beta = from->beta};
        status = l == 0 ? add_first_segments(layer, params, inputs, precision, err)
                        : add_segment(layer, (nqm_weights){from->w, from->half, n_in}, (range){0, n_in}, precision,
                                      !net->is_packed, err);
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
    if (status == NQM_OK)
        *net_ret = net;
    else
        nqm_inference_net_free(net);
    return status;
}

void nqm_inference_net_free(nqm_inference_net *net) {
    if (!net)
        return;
    for (size_t l = 0; l < net->n_layers; ++l)
        for (size_t s = 0; s < net->layer[l].n_segments; ++s)
            nqm_panels_free(&net->layer[l].segment[s].panels);
    nqm_free(net);
}

/* ---- workspace --------------------------------------------------------------------------------------------------- */

static nqm_inference_work measure(const nqm_inference_net *net, size_t max_batch) {
    nqm_inference_work w = {.net = net, .max_batch = max_batch, .n_threads = (size_t)omp_get_max_threads()};
    size_t widest = 0, n_words = 0;
    for (size_t l = 0; l < net->n_layers; ++l) {
        const nqm_inference_layer *layer = &net->layer[l];
        widest = nqm_larger(widest, layer->n_out);
        n_words = nqm_larger(n_words, layer->n_words);
        for (size_t s = 0; s < layer->n_segments; ++s) {
            const nqm_panels *panels = &layer->segment[s].panels;
            w.n_products += panels->k * layer->n_out;
            if (nqm_has_weights(layer->segment[s].weights))
                w.panel_size = nqm_larger(w.panel_size, panels->k * NQM_PANEL);
        }
    }
    w.stride = nqm_row_stride(widest);
    w.rounded_stride = n_words ? nqm_row_stride(n_words) : 0;
    w.ref_stride = nqm_row_stride(net->layer[0].segment[0].panels.words);
    return w;
}

nqm_status nqm_inference_work_create(const nqm_inference_net *net, size_t max_batch, nqm_inference_work **work_ret,
                                     nqm_error *err) {
    *work_ret = NULL;
    if (max_batch < 1 || max_batch > (size_t)1 << 24)
        return nqm_fail(err, NQM_ERR_ARG, -1, "network: batch of %zu is out of range (1..16777216)", max_batch);
    const nqm_inference_layer *first = &net->layer[0];
    const size_t n = max_batch, n_ref = first->segment[0].panels.k;
    nqm_inference_work *work, w = measure(net, max_batch);
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&work, 1, sizeof w}, {&w.y[0], n, w.stride * sizeof *w.y[0]},
                   {&w.y[1], n, w.stride * sizeof *w.y[1]}, {&w.rounded, n, w.rounded_stride * sizeof *w.rounded},
                   {&w.scale, n, NQM_MAX_SEGMENTS * sizeof *w.scale},
                   {&w.difference, first->differences ? n : 0, n_ref * sizeof *w.difference},
                   {&w.panel, w.n_threads, w.panel_size * sizeof *w.panel}, {&w.ref_of, n, sizeof *w.ref_of},
                   {&w.ref_row, n, sizeof *w.ref_row}, {&w.ref, n, w.ref_stride * sizeof *w.ref},
                   {&w.ref_scale, n, sizeof *w.ref_scale}, {&w.partial, n + 1, w.stride * sizeof *w.partial},
                   {&w.kept_ref, n_ref, sizeof *w.kept_ref}),
        err);
    if (status == NQM_OK) {
        *work = w;
        *work_ret = work;
    }
    return status;
}

void nqm_inference_work_free(nqm_inference_work *work) {
    nqm_free(work);
}
