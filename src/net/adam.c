/* SPDX-License-Identifier: MIT
 *
 * Adam (Kingma and Ba 2015, arXiv:1412.6980) as torch.optim.Adam does it: L2 weight decay is added to the gradient, and
 * both moments are corrected for their start at zero. One pass over memory; every number is independent of the others.
 */
#include "net/net.h"

#include <math.h>

static const double beta1 = 0.9, beta2 = 0.999, eps = 1e-8;

/* One learning rate for the numbers [from, to) of the block. */
typedef struct segment {
    size_t from, to;
    double lr;
} segment;

/* The scalars of a step, in float as the numbers are. */
typedef struct step_scalars {
    float weight_decay, step_size, denominator_scale;
} step_scalars;

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

static void step_chunk(size_t n, const step_scalars *s, const float *grad, float *m, float *v, float *param) {
    const float keep1 = (float)beta1, keep2 = (float)beta2, add1 = (float)(1 - beta1), add2 = (float)(1 - beta2);
    const float small = (float)eps;
#pragma omp simd
    for (size_t i = 0; i < n; ++i) {
        float g = grad[i] + s->weight_decay * param[i];
        m[i] = keep1 * m[i] + add1 * g;
        v[i] = keep2 * v[i] + add2 * (g * g);
        param[i] -= s->step_size * m[i] / (sqrtf(v[i]) * s->denominator_scale + small);
    }
}

static void step_segment(nqm_adam *adam, nqm_params *params, const nqm_params *grads, const segment *part,
                         double weight_decay) {
    double correction1 = 1 - pow(beta1, (double)adam->step), correction2 = 1 - pow(beta2, (double)adam->step);
    step_scalars s = {.weight_decay = (float)weight_decay,
                      .step_size = (float)(part->lr / correction1),
                      .denominator_scale = (float)(1 / sqrt(correction2))};
    enum { CHUNK = 16384 };
#pragma omp parallel for schedule(static) if (part->to - part->from > CHUNK)
    for (size_t i = part->from; i < part->to; i += CHUNK) {
        size_t n = part->to - i < CHUNK ? part->to - i : CHUNK;
        step_chunk(n, &s, grads->block + i, adam->m.block + i, adam->v.block + i, params->block + i);
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
