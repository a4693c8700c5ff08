/* SPDX-License-Identifier: MIT
 *
 * What the training of a network needs besides its passes: the log-cosh loss of the sigmoid-bounded prediction (paper,
 * section 3.2), Adam's moments in the layout of the parameters, and the schedules of the learning rate.
 */
#include "math/math.h"
#include "net/net.h"

#include <math.h>

/* ---- loss -------------------------------------------------------------------------------------------------------- */

double nqm_sigmoid(double z) {
    if (z >= 0)
        return 1.0 / (1.0 + exp(-z));
    double e = exp(z);
    return e / (1.0 + e);
}

/* Written so that it neither overflows for large differences nor rounds small ones to 0. */
double nqm_logcosh_loss(size_t batch, size_t n_outputs, const nqm_output_bounds *bounds, const float *z,
                        const float *target, float *dz) {
    const double ln2 = 0.69314718055994531;
    double sum = 0;
    for (size_t i = 0; i < batch * n_outputs; ++i) {
        const nqm_output_bounds *b = &bounds[i % n_outputs];
        double s = nqm_sigmoid((double)z[i]);
        double d = b->lo + (b->hi - b->lo) * s - (double)target[i];
        sum += b->weight * (fabs(d) + log1p(exp(-2.0 * fabs(d))) - ln2);
        if (dz)
            dz[i] = (float)(b->weight * (tanh(d) * (b->hi - b->lo) * s * (1.0 - s) / (double)batch));
    }
    return sum / (double)batch;
}

/* ---- Adam -------------------------------------------------------------------------------------------------------- */

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

/* ---- schedules --------------------------------------------------------------------------------------------------- */

double nqm_plateau_step(nqm_plateau *plateau, double loss) {
    if (loss < plateau->best * (1.0 - 1e-4)) {
        plateau->best = loss;
        plateau->bad_epochs = 0;
        return 1.0;
    }
    if (++plateau->bad_epochs <= plateau->patience)
        return 1.0;
    plateau->bad_epochs = 0;
    return plateau->factor;
}

double nqm_plateau_rate(double lr, double factor) {
    double reduced = lr * factor;
    return lr - reduced > 1e-8 ? reduced : lr;
}

double nqm_cosine_factor(size_t done, size_t all) {
    return 0.5 * (1 + cos(NQM_PI * (double)done / (double)all));
}
