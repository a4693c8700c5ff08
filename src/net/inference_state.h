/* SPDX-License-Identifier: MIT
 *
 * inference_state.h - what inference.c creates and inference_run.c runs: a packed network and a workspace.
 */
#ifndef NQM_SRC_NET_INFERENCE_STATE_H
#define NQM_SRC_NET_INFERENCE_STATE_H

#include "kernel/panel.h"
#include "net/inference.h"

#include <stdatomic.h>

/** Weights that inputs are multiplied with. */
typedef struct nqm_packed_weights {
    nqm_panels panels;   /**< (inputs, outputs) */
    nqm_weights weights; /**< (outputs, inputs) from which the panels are packed: borrowed */
} nqm_packed_weights;

/** A hidden layer: product, LayerNorm, GELU. */
typedef struct nqm_inference_layer {
    size_t n_out;
    nqm_packed_weights w;             /**< of all inputs; in layer 0, of those after the reference */
    const float *bias, *gamma, *beta; /**< (n_out) borrowed */
} nqm_inference_layer;

struct nqm_inference_net {
    size_t n_layers;        /**< hidden layers, at least one */
    nqm_packed_weights ref; /**< of the reference in layer 0 */
    nqm_inference_layer layer[NQM_NET_MAX_LAYERS];
    size_t n_outputs;
    const float *output, *output_bias; /**< (n_outputs, n_out of the last hidden layer), (n_outputs): borrowed */
    bool _Atomic has_run, is_packed;   /**< is_packed: the panels are filled */
};

/** Rows of max_batch. Views into the block that begins with this struct. */
struct nqm_inference_work {
    const nqm_inference_net *net;
    size_t n_threads;          /**< at most, of a call */
    size_t n_products;         /**< multiply-adds of a row */
    size_t stride, ref_stride; /**< floats per row of layers' outputs, of references */
    float *y[2];               /**< (max_batch, stride) outputs of even and of odd layers */
    float *panel;              /**< (threads, panel_size) a panel packed for immediate use */
    size_t panel_size;
    /* References of a call, numbered from 1; 0 is the last one of the call before. */
    size_t *ref_of;  /**< (max_batch) a row's reference */
    size_t *ref_row; /**< (max_batch) the first row of reference 1 + i */
    float *ref;      /**< (max_batch, ref_stride) inputs of reference 1 + i */
    float *partial;  /**< (1 + max_batch, stride) partial products of the references */
    float *kept_ref; /**< (reference inputs) of reference 0 */
    const nqm_kernels
        *kept_kernels; /**< the kernels that computed its partial product; NULL: there is no reference 0 */
};

#endif
