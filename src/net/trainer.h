/* SPDX-License-Identifier: MIT
 *
 * trainer.h - the network of net.h in training (paper, section 3.2): forward pass, gradients, and steps of Adam that are
 * taken tile by tile while the gradients come into being, so that these are never stored. Weights and moments stay packed
 * for the kernels from the first step to the last.
 *
 * In NQM_PRECISION_BF16 the factors of all products are rounded to bfloat16; weights, sums, LayerNorm, GELU, loss and Adam
 * stay in float. The same calls give the same bits for any number of threads.
 */
#ifndef NQM_SRC_NET_TRAINER_H
#define NQM_SRC_NET_TRAINER_H

#include "kernel/kernel.h"
#include "net/net.h"

/** Belongs to one thread at a time, works on all of them: as many, at most, as OpenMP had when it was made. */
typedef struct nqm_trainer nqm_trainer;

typedef struct nqm_trainer_options {
    nqm_precision precision; /**< NQM_PRECISION_F32 or _BF16 */
    size_t max_batch;        /**< 1 .. 2^24 */
    bool input_gradient;     /**< nqm_trainer_gradients() is to give the input's */
} nqm_trainer_options;

/** All weights and moments are 0. NQM_ERR_ARG, NQM_ERR_NOMEM. */
NQM_MUST_CHECK nqm_status nqm_trainer_create(const nqm_net_shape *shape, const nqm_trainer_options *options,
                                             nqm_trainer **trainer_ret, nqm_error *err);
void nqm_trainer_free(nqm_trainer *trainer);

/** Take weights, and Adam's state (NULL: that before the first step). */
void nqm_trainer_load(nqm_trainer *trainer, const nqm_params *params, const nqm_adam *adam);
/** Give them back; adam may be NULL. */
void nqm_trainer_store(const nqm_trainer *trainer, nqm_params *params, nqm_adam *adam);
/** Steps taken so far. */
uint64_t nqm_trainer_steps(const nqm_trainer *trainer);

/** Where row i of the inputs of the next batch belongs: (sizes[0]), for the calling thread until it asks for another pair of rows,
 *  2 k and 2 k + 1. */
float *nqm_trainer_input(nqm_trainer *trainer, size_t i);
/** Rows first and, where n is 2, first + 1 of the inputs are filled in; for all rows before nqm_trainer_forward(). first is even, n
 *  is 1 for the last of an odd number. Any thread, best the one that filled them. */
void nqm_trainer_inputs_done(nqm_trainer *trainer, size_t first, size_t n);
/** z (batch): the last layer's output before the sigmoid, for the inputs that were filled in. dropout NULL: none. */
void nqm_trainer_forward(nqm_trainer *trainer, size_t batch, const nqm_dropout *dropout, float *z);

/** Fill in the mask of row `row` of hidden layer `layer`, n wide. */
void nqm_dropout_of_row(const nqm_dropout *dropout, size_t layer, size_t row, size_t n, nqm_hidden_row *r);

/** How a step is taken: Adam with L2 in the gradient (Kingma and Ba 2014; torch.optim.Adam): beta 0.9, 0.999, eps 1e-8. */
typedef struct nqm_step_rates {
    double lr_first;  /**< of layer 0's weights and bias */
    double lr_deeper; /**< of everything else, also layer 0's LayerNorm */
    double weight_decay;
    bool freeze_first_layernorm;
} nqm_step_rates;
/** One step for a loss with d loss / d z = dz (batch), after nqm_trainer_forward() of the same batch: it uses that up. */
void nqm_trainer_step(nqm_trainer *trainer, size_t batch, const float *dz, const nqm_step_rates *rates);
/** The gradients of such a loss instead of a step. dx (batch, sizes[0]) receives the input's, or NULL. */
void nqm_trainer_gradients(nqm_trainer *trainer, size_t batch, const float *dz, nqm_params *grads, float *dx);

#endif
