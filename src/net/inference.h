/* SPDX-License-Identifier: MIT
 *
 * inference.h - the forward pass of a trained network, as scoring needs it: weights packed once for the products of
 * kernel/panel.h, in float, then many batches of rows.
 *
 * The first inputs of a row depend on the reference BRDF only. Their partial product with the weights of layer 1 is computed
 * once for consecutive rows with the same reference, and the last one is kept for the next call. Every sum is taken in the
 * same order for any batch size and any number of threads: equal inputs give equal bits.
 */
#ifndef NQM_SRC_NET_INFERENCE_H
#define NQM_SRC_NET_INFERENCE_H

#include "net/net.h"

/** A network prepared for inference; may be used by several threads at once. */
typedef struct nqm_inference_net nqm_inference_net;

/** Prepare `params` for rows whose first n_ref inputs (1 or more, not all) are the reference. `params` is borrowed and must
 *  outlive the network: biases, LayerNorm and the output layer are used in place, and weights are packed only at the second call
 *  of nqm_inference_run(). NQM_ERR_NOMEM. */
NQM_MUST_CHECK nqm_status nqm_inference_net_create(const nqm_params *params, size_t n_ref, nqm_inference_net **net_ret,
                                                   nqm_error *err);
void nqm_inference_net_free(nqm_inference_net *net);

/** The activations of a batch. Belongs to one thread at a time; a call works on all of OpenMP's threads. */
typedef struct nqm_inference_work nqm_inference_work;

/** A workspace for at most max_batch rows; the network is borrowed. NQM_ERR_ARG when max_batch is not 1..16777216;
 *  NQM_ERR_NOMEM. */
NQM_MUST_CHECK nqm_status nqm_inference_work_create(const nqm_inference_net *net, size_t max_batch,
                                                    nqm_inference_work **work_ret, nqm_error *err);
void nqm_inference_work_free(nqm_inference_work *work);

/**
 * One forward pass. Allocates nothing.
 *
 * @param n    rows, 0..max_batch
 * @param x    (n, inputs) with ldx floats from row to row; nqm_row_stride(inputs) is fastest
 * @param z    (n, outputs) receives the output layer's values before the sigmoid
 */
void nqm_inference_run(nqm_inference_work *work, size_t n, const float *x, size_t ldx, float *z);

#endif
