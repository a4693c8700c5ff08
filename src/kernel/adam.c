/* SPDX-License-Identifier: MIT
 *
 * Adam (Kingma and Ba 2015, arXiv:1412.6980) as torch.optim.Adam does it: L2 weight decay is added to the gradient, and
 * both moments are corrected for their start at zero. One pass over memory; every number is independent of the others.
 */
#include "kernel/kernel.h"

#include <math.h>

void nqm_adam_update(size_t n, const nqm_adam_rate *rate, const float *grad, float *m, float *v, float *param) {
    const double beta1 = 0.9, beta2 = 0.999;
    const float keep1 = (float)beta1, keep2 = (float)beta2, add1 = (float)(1 - beta1), add2 = (float)(1 - beta2);
    const float small = 1e-8f, decay = (float)rate->weight_decay;
    const float step_size = (float)(rate->lr / (1 - pow(beta1, (double)rate->step)));
    const float scale = (float)(1 / sqrt(1 - pow(beta2, (double)rate->step)));
#pragma omp simd
    for (size_t i = 0; i < n; ++i) {
        float g = grad[i] + decay * param[i];
        m[i] = keep1 * m[i] + add1 * g;
        v[i] = keep2 * v[i] + add2 * (g * g);
        param[i] -= step_size * m[i] / (sqrtf(v[i]) * scale + small);
    }
}
