/* SPDX-License-Identifier: MIT
 *
 * input_gradient.h - the outputs of a trained network and their gradient by its inputs, in float. Scores alone are faster with
 * net/inference.h.
 */
#ifndef NQM_SRC_NET_INPUT_GRADIENT_H
#define NQM_SRC_NET_INPUT_GRADIENT_H

#include "net/net.h"

/** A network with its weights packed for both directions, and the activations of a batch. Belongs to one thread at a
 *  time; a call works on all of OpenMP's threads. */
typedef struct nqm_gradient_net nqm_gradient_net;

/** For at most max_batch rows. `params` is borrowed and must outlive the network. The first n_ref inputs, at least 1
 *  and not all, are the reference's: the gradient by them is not computed, and successive calls with one row and the
 *  same reference compute their contribution to the first layer once. NQM_ERR_NOMEM. */
NQM_MUST_CHECK nqm_status nqm_gradient_net_create(const nqm_params *params, size_t n_ref, size_t max_batch,
                                                  nqm_gradient_net **net_ret, nqm_error *err);
void nqm_gradient_net_free(nqm_gradient_net *net);

/** z (n, outputs) = the output layer's values, before the sigmoid, of x (n, inputs), nqm_row_stride(inputs) floats from row to
 *  row. */
void nqm_gradient_forward(nqm_gradient_net *net, size_t n, const float *x, float *z);
/** dx, shaped like x of the call before: the gradient of sum dz z by x; that by the reference is undefined. dz: (n, outputs). */
void nqm_gradient_backward(nqm_gradient_net *net, size_t n, const float *dz, float *dx);

#endif
