/* SPDX-License-Identifier: MIT
 *
 * trainer.h - training of the network of net.h (paper, section 3.2): forward pass, backward pass, Adam. A step updates each
 * tile of weights as soon as its gradient is summed, so that gradients are never stored. Weights and moments stay in panels
 * (kernel/panel.h) from the first step to the last.
 *
 * In NQM_PRECISION_BF16 the factors of all products are rounded to bfloat16; weights, sums, LayerNorm, GELU, loss and Adam
 * stay in float. The same calls give the same bits for any number of threads.
 *
 * One step on a batch:
 *
 *   for each row i:         fill in nqm_trainer_input(t, i); after each pair of rows, nqm_trainer_inputs_done()
 *   nqm_trainer_forward()   gives z
 *   nqm_logcosh_loss()      of net.h, gives d loss / d z
 *   nqm_trainer_step()      updates the parameters
 */
#ifndef NQM_SRC_NET_TRAINER_H
#define NQM_SRC_NET_TRAINER_H

#include "kernel/kernel.h"
#include "net/net.h"

/** Belongs to one thread at a time; a call works on all of OpenMP's threads. */
typedef struct nqm_trainer nqm_trainer;

typedef struct nqm_trainer_options {
    nqm_precision precision; /**< NQM_PRECISION_F32 or _BF16 */
    size_t max_batch;        /**< 1 .. 2^24 */
} nqm_trainer_options;

/** All weights and moments are 0. NQM_ERR_ARG, NQM_ERR_NOMEM. */
NQM_MUST_CHECK nqm_status nqm_trainer_create(const nqm_net_shape *shape, const nqm_trainer_options *options,
                                             nqm_trainer **trainer_ret, nqm_error *err);
void nqm_trainer_free(nqm_trainer *trainer);

/** Copy parameters and the state of Adam into the trainer; adam NULL: the state before the first step. */
void nqm_trainer_load(nqm_trainer *trainer, const nqm_params *params, const nqm_adam *adam);
/** Copy them back; adam may be NULL. */
void nqm_trainer_store(const nqm_trainer *trainer, nqm_params *params, nqm_adam *adam);
/** Steps taken so far. */
uint64_t nqm_trainer_steps(const nqm_trainer *trainer);

/** (sizes[0]) receives row i of the next batch's input. */
float *nqm_trainer_input(nqm_trainer *trainer, size_t i);
/** Rows [first, first + n) of the input are complete; call it for all rows before nqm_trainer_forward(). first is even;
 *  n is 2, or 1 for the last row of an odd number. Any thread. */
void nqm_trainer_inputs_done(nqm_trainer *trainer, size_t first, size_t n);
/** z (batch, outputs) receives the output layer's values before the sigmoid. dropout NULL: none. */
void nqm_trainer_forward(nqm_trainer *trainer, size_t batch, const nqm_dropout *dropout, float *z);

/** Set the dropout mask of row `row` of hidden layer `layer`, n wide. */
void nqm_dropout_of_row(const nqm_dropout *dropout, size_t layer, size_t row, size_t n, nqm_hidden_row *r);

/** The rates of a step of Adam with L2 weight decay in the gradient (Kingma and Ba 2014; torch.optim.Adam): beta 0.9 and
 *  0.999, eps 1e-8. */
typedef struct nqm_step_rates {
    double lr_first;  /**< learning rate of layer 0's weights and bias */
    double lr_deeper; /**< learning rate of everything else, including layer 0's LayerNorm */
    double weight_decay;
    bool freeze_first_layernorm;
} nqm_step_rates;
/** One step for a loss with d loss / d z = dz (batch, outputs). Call it once after each nqm_trainer_forward(): it overwrites the
 *  activations. */
void nqm_trainer_step(nqm_trainer *trainer, size_t batch, const float *dz, const nqm_step_rates *rates);

#endif
