/* SPDX-License-Identifier: MIT
 *
 * The log-cosh loss of the sigmoid-bounded prediction (paper, section 3.2), in a form that neither overflows for large
 * differences nor rounds small ones to 0.
 */
#include "net/net.h"

#include <math.h>

double nqm_sigmoid(double z) {
    if (z >= 0)
        return 1.0 / (1.0 + exp(-z));
    double e = exp(z);
    return e / (1.0 + e);
}

double nqm_logcosh_loss(size_t batch, const float *z, const float *target, double lo, double hi, float *dz) {
    const double ln2 = 0.69314718055994531;
    double sum = 0;
    for (size_t i = 0; i < batch; ++i) {
        double s = nqm_sigmoid((double)z[i]);
        double d = lo + (hi - lo) * s - (double)target[i];
        sum += fabs(d) + log1p(exp(-2.0 * fabs(d))) - ln2;
        if (dz)
            dz[i] = (float)(tanh(d) * (hi - lo) * s * (1.0 - s) / (double)batch);
    }
    return sum / (double)batch;
}
