/* SPDX-License-Identifier: MIT
 *
 * The gradients of a training step: Adam's first moments after a step from moments of 0, which are (1 - beta1) times the gradients.
 * With a learning rate of 0 the step changes no parameter.
 */
#include "support/network_gradients.h"
#include "support/check.h"

void network_gradients(nqm_trainer *trainer, size_t batch, const float *dz, nqm_params *grads) {
    nqm_params params;
    nqm_adam before, after;
    assert_int_equal(nqm_params_create(&grads->shape, &params, NULL), NQM_OK);
    assert_int_equal(nqm_adam_create(&grads->shape, &before, NULL), NQM_OK);
    assert_int_equal(nqm_adam_create(&grads->shape, &after, NULL), NQM_OK);
    nqm_trainer_store(trainer, &params, &before);
    nqm_trainer_load(trainer, &params, NULL);
    nqm_trainer_step(trainer, batch, dz, &(nqm_step_rates){.lr_first = 0, .lr_deeper = 0});
    nqm_trainer_store(trainer, grads, &after);
    for (size_t i = 0; i < grads->n; ++i) {
        assert_true(grads->block[i] == params.block[i]);
        grads->block[i] = (float)((double)after.m.block[i] / (1 - NQM_ADAM_BETA1));
    }
    nqm_trainer_load(trainer, &params, &before);
    nqm_params_free(&params);
    nqm_adam_free(&before);
    nqm_adam_free(&after);
}
