/* SPDX-License-Identifier: MIT
 *
 * The optimiser of the metric's network: Adam (src/kernel/adam.c) with learning rates of its own for the first layer.
 */
#include "kernel/kernel.h"
#include "net/net.h"

/* One learning rate for the numbers [from, to) of the block. */
typedef struct segment {
    size_t from, to;
    double lr;
} segment;

nqm_status nqm_adam_create(const nqm_net_shape *shape, nqm_adam *adam_ret, nqm_error *err) {
    *adam_ret = (nqm_adam){0};
    nqm_status status = nqm_params_create(shape, &adam_ret->m, err);
    if (status == NQM_OK)
        status = nqm_params_create(shape, &adam_ret->v, err);
    if (status != NQM_OK)
        nqm_adam_free(adam_ret);
    return status;
}

void nqm_adam_free(nqm_adam *adam) {
    nqm_params_free(&adam->m);
    nqm_params_free(&adam->v);
    *adam = (nqm_adam){0};
}

static void step_segment(nqm_adam *adam, nqm_params *params, const nqm_params *grads, const segment *part,
                         double weight_decay) {
    const nqm_adam_rate rate = {.lr = part->lr, .weight_decay = weight_decay, .step = adam->step};
    enum { CHUNK = 16384 };
#pragma omp parallel for schedule(static) if (part->to - part->from > CHUNK)
    for (size_t i = part->from; i < part->to; i += CHUNK) {
        size_t n = part->to - i < CHUNK ? part->to - i : CHUNK;
        nqm_adam_update(n, &rate, grads->block + i, adam->m.block + i, adam->v.block + i, params->block + i);
    }
}

void nqm_adam_step(nqm_adam *adam, nqm_params *params, const nqm_params *grads, double lr_first, double lr_deeper,
                   double weight_decay, bool freeze_first_layernorm) {
    const nqm_net_shape *shape = &params->shape;
    size_t width = shape->sizes[1];
    size_t linear = width * (shape->sizes[0] + 1);
    size_t norm = freeze_first_layernorm && shape->n_layers > 1 ? 2 * width : 0;
    segment first = {0, linear, lr_first}, deeper = {linear + norm, params->n, lr_deeper};
    adam->step++;
    step_segment(adam, params, grads, &first, weight_decay);
    step_segment(adam, params, grads, &deeper, weight_decay);
}
