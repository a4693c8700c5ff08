/* SPDX-License-Identifier: MIT
 *
 * inference_state.h - what inference.c creates and inference_run.c runs: a packed network and a workspace.
 */
#ifndef NQM_SRC_NET_INFERENCE_STATE_H
#define NQM_SRC_NET_INFERENCE_STATE_H

#include "kernel/panel.h"
#include "net/inference.h"

#include <stdatomic.h>

enum { NQM_MAX_SEGMENTS = NQM_MAX_INPUT_GROUPS + 1 };

/** Consecutive inputs of a layer that share a precision and a scale. A layer's product is the sum over its segments. */
typedef struct nqm_segment {
    size_t first;        /**< index of its first input */
    size_t word;         /**< rounded segments: offset of its inputs in a row of rounded inputs, 32-bit words */
    nqm_panels panels;   /**< (inputs, outputs) */
    nqm_weights weights; /**< f32: (outputs, inputs) from which panels are packed, borrowed; else empty */
} nqm_segment;

/** A hidden layer: product, LayerNorm, GELU. */
typedef struct nqm_inference_layer {
    size_t n_out, n_segments;
    bool differences; /**< segment 1 multiplies its inputs minus those of segment 0 */
    nqm_segment segment[NQM_MAX_SEGMENTS];
    size_t n_words;                   /**< 32-bit words of a row of all rounded segments */
    const float *bias, *gamma, *beta; /**< (n_out) borrowed */
} nqm_inference_layer;

struct nqm_inference_net {
    size_t n_layers; /**< hidden layers, at least one */
    nqm_inference_layer layer[NQM_NET_MAX_LAYERS];
    size_t n_outputs;
    const float *output, *output_bias; /**< (n_outputs, n_out of the last hidden layer), (n_outputs): borrowed */
    bool _Atomic has_run, is_packed;   /**< is_packed: the panels of floats are filled */
};

/** Rows of max_batch; strides in floats or 32-bit words. Views into the block that begins with this struct. */
struct nqm_inference_work {
    const nqm_inference_net *net;
    size_t max_batch, n_threads; /**< at most, of a call */
    size_t n_products;           /**< multiply-adds of a row */
    size_t stride, rounded_stride,
        ref_stride;        /**< floats per row of layers' outputs, of rounded inputs, of references */
    float *y[2];           /**< (max_batch, stride) outputs of even and of odd layers */
    uint32_t *rounded;     /**< (max_batch, rounded_stride) the rounded inputs of a layer */
    nqm_byte_scale *scale; /**< (NQM_MAX_SEGMENTS, max_batch) NQM_PRECISION_INT8: scales of the rounded inputs */
    float *difference;     /**< (max_batch, reference inputs) if layer 0 takes differences */
    float *panel;          /**< (threads, panel_size) a panel packed for immediate use */
    size_t panel_size;
    bool is_packed;         /**< this call reads the network's panels of floats, not `panel` */
    size_t n_rows;          /**< rows of this call */
    size_t _Atomic n_taken; /**< rows taken by threads that compute all layers of their rows */
    /* References of this call, 1..n_refs; 0 is the last one of the call before. */
    size_t n_refs;
    size_t *ref_of;            /**< (max_batch) a row's reference */
    size_t *ref_row;           /**< (max_batch) the first row of reference 1 + i */
    uint32_t *ref;             /**< (max_batch, ref_stride) inputs of reference 1 + i in the precision of segment 0 */
    nqm_byte_scale *ref_scale; /**< (max_batch) */
    float *partial;            /**< (1 + max_batch, stride) partial products of the references */
    float *kept_ref;           /**< (reference inputs) of reference 0 */
    const nqm_kernels
        *kept_kernels; /**< the kernels that computed its partial product; NULL: there is no reference 0 */
};

#endif
