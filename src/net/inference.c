/* SPDX-License-Identifier: MIT
 *
 * Creation of networks for inference and of their workspaces.
 */
#include "net/inference.h"
#include "net/inference_state.h"

#include <omp.h>

/* ---- network ----------------------------------------------------------------------------------------------------- */

/* Empty panels for n of the inputs, from input `first` on; w (n_out, inputs): their weights. */
static nqm_status add_weights(nqm_packed_weights *to, nqm_weights w, size_t first, size_t n, size_t n_out,
                              nqm_error *err) {
    to->weights = nqm_weights_at(w, 0, first);
    return nqm_panels_create(NQM_PRECISION_F32, n, n_out, &to->panels, err);
}

static nqm_status add_layers(nqm_inference_net *net, const nqm_params *params, size_t n_ref, nqm_error *err) {
    const nqm_net_shape *shape = &params->shape;
    nqm_status status = NQM_OK;
    net->n_layers = shape->n_layers - 1;
    net->n_outputs = shape->sizes[shape->n_layers];
    net->output = params->layer[net->n_layers].w;
    net->output_bias = params->layer[net->n_layers].b;
    for (size_t l = 0; status == NQM_OK && l < net->n_layers; ++l) {
        const nqm_layer *from = &params->layer[l];
        const size_t n_in = shape->sizes[l], n_out = shape->sizes[l + 1], first = l == 0 ? n_ref : 0;
        const nqm_weights w = {from->w, from->half, n_in};
        net->layer[l] =
            (nqm_inference_layer){.n_out = n_out, .bias = from->b, .gamma = from->gamma, .beta = from->beta};
        if (l == 0)
            status = add_weights(&net->ref, w, 0, n_ref, n_out, err);
        if (status == NQM_OK)
            status = add_weights(&net->layer[l].w, w, first, n_in - first, n_out, err);
    }
    return status;
}

nqm_status nqm_inference_net_create(const nqm_params *params, size_t n_ref, nqm_inference_net **net_ret,
                                    nqm_error *err) {
    *net_ret = NULL;
    nqm_inference_net *net = nqm_alloc(1, sizeof *net);
    if (!net)
        return nqm_fail_nomem(err, sizeof *net);
    nqm_status status = add_layers(net, params, n_ref, err);
    if (status == NQM_OK)
        *net_ret = net;
    else
        nqm_inference_net_free(net);
    return status;
}

void nqm_inference_net_free(nqm_inference_net *net) {
    if (!net)
        return;
    nqm_panels_free(&net->ref.panels);
    for (size_t l = 0; l < net->n_layers; ++l)
        nqm_panels_free(&net->layer[l].w.panels);
    nqm_free(net);
}

/* ---- workspace --------------------------------------------------------------------------------------------------- */

static nqm_inference_work measure(const nqm_inference_net *net) {
    const size_t n_ref = net->ref.panels.k;
    nqm_inference_work w = {.net = net,
                            .n_threads = (size_t)omp_get_max_threads(),
                            .n_products = n_ref * net->layer[0].n_out,
                            .panel_size = n_ref * NQM_PANEL,
                            .ref_stride = nqm_row_stride(n_ref)};
    size_t widest = 0;
    for (size_t l = 0; l < net->n_layers; ++l) {
        const nqm_panels *panels = &net->layer[l].w.panels;
        widest = nqm_larger(widest, panels->n);
        w.n_products += panels->k * panels->n;
        w.panel_size = nqm_larger(w.panel_size, panels->k * NQM_PANEL);
    }
    w.stride = nqm_row_stride(widest);
    return w;
}

nqm_status nqm_inference_work_create(const nqm_inference_net *net, size_t max_batch, nqm_inference_work **work_ret,
                                     nqm_error *err) {
    *work_ret = NULL;
    if (max_batch < 1 || max_batch > (size_t)1 << 24)
        return nqm_fail(err, NQM_ERR_ARG, -1, "network: batch of %zu is out of range (1..16777216)", max_batch);
    const size_t n = max_batch;
    nqm_inference_work *work, w = measure(net);
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&work, 1, sizeof w}, {&w.y[0], n, w.stride * sizeof *w.y[0]},
                   {&w.y[1], n, w.stride * sizeof *w.y[1]}, {&w.panel, w.n_threads, w.panel_size * sizeof *w.panel},
                   {&w.ref_of, n, sizeof *w.ref_of}, {&w.ref_row, n, sizeof *w.ref_row},
                   {&w.ref, n, w.ref_stride * sizeof *w.ref}, {&w.partial, n + 1, w.stride * sizeof *w.partial},
                   {&w.kept_ref, net->ref.panels.k, sizeof *w.kept_ref}),
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
