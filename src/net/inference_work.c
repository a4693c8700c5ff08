/* SPDX-License-Identifier: MIT
 *
 * Memory for rows on their way through a packed network.
 */
#include "net/inference_work.h"

#include <omp.h>

static void measure(nqm_inference_work *work) {
    const nqm_inference_net *net = work->net;
    size_t widest = 0, rounded = 0;
    for (size_t l = 0; l < net->n_layers; ++l) {
        const nqm_inference_layer *layer = &net->layer[l];
        widest = nqm_larger(widest, layer->n_out);
        rounded = nqm_larger(rounded, layer->rounded);
        for (size_t s = 0; s < layer->n_segments; ++s) {
            work->n_multiplications += layer->segment[s].panel.k * layer->n_out;
        }
    }
    work->stride = nqm_row_stride(widest);
    work->rounded_stride = rounded ? nqm_row_stride(rounded) : 0;
    work->ref_stride = nqm_row_stride(net->layer[0].segment[0].panel.units);
}

nqm_status nqm_inference_work_create(const nqm_inference_net *net, size_t max_batch, nqm_inference_work **work_ret,
                                     nqm_error *err) {
    *work_ret = NULL;
    if (max_batch < 1 || max_batch > (size_t)1 << 24)
        return nqm_fail(err, NQM_ERR_ARG, -1, "network: batch of %zu is out of range (1..16777216)", max_batch);
    nqm_inference_work *w = nqm_alloc(1, sizeof *w);
    if (!w)
        return nqm_fail_nomem(err, sizeof *w);
    w->net = net;
    w->max_batch = max_batch;
    measure(w);
    w->n_slots = nqm_larger(max_batch, 1 + (size_t)omp_get_max_threads());
    w->y[0] = nqm_alloc(w->n_slots, w->stride * sizeof(float));
    w->y[1] = nqm_alloc(w->n_slots, w->stride * sizeof(float));
    w->rounded = nqm_alloc(w->n_slots, w->rounded_stride * sizeof *w->rounded);
    w->scale = nqm_alloc(w->n_slots, NQM_MAX_SEGMENTS * sizeof *w->scale);
    const bool differences = net->layer[0].differences;
    w->difference = nqm_alloc(differences ? w->n_slots : 0, net->layer[0].segment[0].panel.k * sizeof *w->difference);
    w->ref_of = nqm_alloc(max_batch, sizeof *w->ref_of);
    w->begins = nqm_alloc(max_batch, sizeof *w->begins);
    w->ref = nqm_alloc(max_batch, w->ref_stride * sizeof *w->ref);
    w->ref_scale = nqm_alloc(max_batch, sizeof *w->ref_scale);
    w->part = nqm_alloc(max_batch + 1, w->stride * sizeof *w->part);
    w->kept = nqm_alloc(net->layer[0].segment[0].panel.k, sizeof *w->kept);
    if (w->y[0] && w->y[1] && w->rounded && w->scale && w->difference && w->ref_of && w->begins && w->ref &&
        w->ref_scale && w->part && w->kept) {
        *work_ret = w;
        return NQM_OK;
    }
    const size_t per_row = (3 * w->stride + w->rounded_stride + w->ref_stride) * sizeof(float);
    nqm_inference_work_free(w);
    return nqm_fail_nomem(err, max_batch * per_row);
}

void nqm_inference_work_free(nqm_inference_work *work) {
    if (!work)
        return;
    void *blocks[] = {work->y[0],   work->y[1], work->rounded,   work->scale, work->difference, work->ref_of,
                      work->begins, work->ref,  work->ref_scale, work->part,  work->kept};
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; ++i)
        nqm_free(blocks[i]);
    nqm_free(work);
}
