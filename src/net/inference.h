/* SPDX-License-Identifier: MIT
 *
 * inference.h - the network as scoring needs it: weights packed once for the products of kernel/panel.h, in one
 * precision, and rows of inputs through all layers. Weights that stay floats are packed when that begins to pay: the
 * first few calls use them as they lie.
 *
 * The first layer is a sum over groups of its inputs. What the reference contributes is computed once for neighbouring
 * rows with the same reference, and kept for the next call. Every number is summed in the same order however rows are
 * grouped and on however many threads: the same input gives the same bits.
 */
#ifndef NQM_SRC_NET_INFERENCE_H
#define NQM_SRC_NET_INFERENCE_H

#include "net/net.h"

enum { NQM_MAX_INPUT_GROUPS = 3 };

/** The inputs of a network in their order: groups of samples of a like range, the first of which belongs to the
 *  reference, then scalar features. */
typedef struct nqm_input_groups {
    size_t n_groups, width[NQM_MAX_INPUT_GROUPS];
    size_t n_scalars; /**< never rounded: few, and of wide range */
    bool test_itself; /**< the second group holds the test, not how it differs from the reference */
} nqm_input_groups;

/** A network, packed or soon to be; may be used by several threads at once. */
typedef struct nqm_inference_net nqm_inference_net;

/** Make room for `params`, which are lent: biases and LayerNorm are used in place, as are weights until they are packed.
 *  What is rounded is packed at once, on all threads. NQM_ERR_NOMEM. */
NQM_MUST_CHECK nqm_status nqm_inference_net_create(const nqm_params *params, const nqm_input_groups *inputs,
                                                   nqm_precision precision, nqm_inference_net **net_ret,
                                                   nqm_error *err);
void nqm_inference_net_free(nqm_inference_net *net);

/** Memory for rows on their way through a network, which is lent. Belongs to one thread at a time. */
typedef struct nqm_inference_work nqm_inference_work;

/** NQM_ERR_ARG when max_batch is not 1..16777216; NQM_ERR_NOMEM. */
NQM_MUST_CHECK nqm_status nqm_inference_work_create(const nqm_inference_net *net, size_t max_batch,
                                                    nqm_inference_work **work_ret, nqm_error *err);
void nqm_inference_work_free(nqm_inference_work *work);

/**
 * z (n), n <= max_batch: the last layer's output before the sigmoid. Allocates nothing.
 *
 * @param x  (n, inputs) ldx numbers from row to row; best nqm_row_stride(inputs)
 */
void nqm_inference_run(nqm_inference_work *work, size_t n, const float *x, size_t ldx, float *z);

#endif
