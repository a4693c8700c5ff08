/* SPDX-License-Identifier: MIT
 *
 * inference_net.h - the inside of a packed network, for the files that make and run it.
 */
#ifndef NQM_SRC_NET_INFERENCE_NET_H
#define NQM_SRC_NET_INFERENCE_NET_H

#include "kernel/panel.h"
#include "net/inference.h"

#include <stdatomic.h>

enum { NQM_MAX_SEGMENTS = NQM_MAX_INPUT_GROUPS + 1 };

/** The weights of some neighbouring inputs of a layer. */
typedef struct nqm_segment {
    size_t from;      /**< the first input */
    size_t at;        /**< where its rows begin among the rounded rows of the layer, units; rows of float: unused */
    nqm_panels panel; /**< (inputs, outputs) */
    /* Floats only: what panels are filled from when that begins to pay, lent. */
    const float *w; /**< (outputs, inputs), ldw numbers from row to row */
    size_t ldw;
} nqm_segment;

/** A hidden layer: the sum over its segments, and what follows. */
typedef struct nqm_inference_layer {
    size_t n_out, n_segments;
    bool differences; /**< the second segment wants its inputs less those of the first */
    nqm_segment segment[NQM_MAX_SEGMENTS];
    size_t rounded;            /**< units of a row of all segments that are not float */
    const float *bias;         /**< (n_out) */
    const float *gamma, *beta; /**< (n_out) */
} nqm_inference_layer;

struct nqm_inference_net {
    size_t n_layers; /**< hidden ones, at least one */
    nqm_inference_layer layer[NQM_NET_MAX_LAYERS];
    const float *output;      /**< (n_out of the last layer) the weights of the output, lent */
    const float *output_bias; /**< (1) */
    /* To pack is to write as much memory as all weights take: a few calls are done sooner without. */
    bool _Atomic packed;      /**< the panels of floats are filled */
    unsigned _Atomic n_calls; /**< before that */
};

enum {
    NQM_CALLS_UNPACKED = 3, /* cost about as much as packing */
    NQM_ROWS_UNPACKED = 192 /* a block: for more, each would pack what it needs again */
};

/** Whether a call with n rows that comes now is to use the panels of floats, which are filled when that begins to pay;
 *  else it is to use weights as they lie. The same bits either way. Any thread. */
bool nqm_inference_net_packed(const nqm_inference_net *net, const nqm_kernels *kernels, size_t n);

#endif
