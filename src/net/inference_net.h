/* SPDX-License-Identifier: MIT
 *
 * inference_net.h - the inside of a packed network, for the files that make and run it.
 */
#ifndef NQM_SRC_NET_INFERENCE_NET_H
#define NQM_SRC_NET_INFERENCE_NET_H

#include "kernel/panel.h"
#include "net/inference.h"

enum { NQM_MAX_SEGMENTS = NQM_MAX_INPUT_GROUPS + 1 };

/** The weights of some neighbouring inputs of a layer. */
typedef struct nqm_segment {
    size_t from;      /**< the first input */
    size_t at;        /**< where its rows begin among the rounded rows of the layer, units; rows of float: unused */
    nqm_panels panel; /**< (inputs, outputs) */
} nqm_segment;

/** A layer: the sum over its segments, and what follows. */
typedef struct nqm_inference_layer {
    size_t n_out, n_segments;
    bool differences; /**< the second segment wants its inputs less those of the first */
    nqm_segment segment[NQM_MAX_SEGMENTS];
    size_t rounded;            /**< units of a row of all segments that are not float */
    const float *bias;         /**< (n_out) */
    const float *gamma, *beta; /**< (n_out); NULL in the last layer */
} nqm_inference_layer;

struct nqm_inference_net {
    size_t n_layers;
    nqm_inference_layer layer[NQM_NET_MAX_LAYERS];
};

#endif
