/* SPDX-License-Identifier: MIT
 *
 * nbrdf_net.h - training of the network of an NBRDF (6-21-21-3, src/brdf/formats/nbrdf.c): inputs, loss and gradient over a batch
 * of directions. Used by the fit of one network and by the hypernetwork, which predicts such networks.
 */
#ifndef NQM_SRC_ENCODE_NBRDF_NET_H
#define NQM_SRC_ENCODE_NBRDF_NET_H

#include "brdf/brdf.h"

/** A batch of directions; the innermost dimension of all arrays is the direction. */
typedef struct nqm_nbrdf_batch {
    size_t n;
    const float *input;  /* (6, n) unit half vector with phi_h = 0, unit difference vector */
    const float *weight; /* (n) c = cos(theta_i), in [0, 1] */
    const float *goal;   /* (3, n) log(1 + c f_r) of the reference */
} nqm_nbrdf_batch;

/** Inputs and cosine weight of n half-vector coordinates hd (n, 3): input (6, n), weight (n). */
void nqm_nbrdf_inputs(size_t n, const double *hd, float *input, float *weight);
/** The same, and the goal (3, n) of values rgb (n, 3): the arrays of a batch. */
void nqm_nbrdf_fill(size_t n, const double *hd, const double *rgb, float *input, float *weight, float *goal);

/**
 * Mean over directions and channels of |log(1 + c f_r) - goal| (Sztrajman et al. 2021, section 3.1), f_r = exp(x) - 1 of
 * the network's output x. A negative f_r is not clamped, so that gradient descent can raise it; evaluation clamps it to 0.
 * Safe to call from several threads; the same bits on every machine.
 *
 * @param weights   (NQM_NBRDF_WEIGHTS)
 * @param gradient  (NQM_NBRDF_WEIGHTS) receives (overwrites) the gradient of the loss; NULL: loss only
 */
double nqm_nbrdf_loss(const float *weights, const nqm_nbrdf_batch *batch, float *gradient);

#endif
