/* SPDX-License-Identifier: MIT
 *
 * network_gradients.h - the gradients of a training step, which training itself never stores.
 */
#ifndef NQM_TESTS_NETWORK_GRADIENTS_H
#define NQM_TESTS_NETWORK_GRADIENTS_H

#include "net/trainer.h"

/** The gradients of a loss with d loss / d z = dz (batch, outputs), after nqm_trainer_forward(). The trainer keeps its parameters
 *  and moments. grads: of the trainer's shape. */
void network_gradients(nqm_trainer *trainer, size_t batch, const float *dz, nqm_params *grads);

#endif
