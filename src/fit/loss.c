/* SPDX-License-Identifier: MIT
 *
 * The losses between BRDF values: their table, which continues that of the metrics; a loss and its derivatives.
 */
#include "fit/fit.h"

#include <math.h>

/* The entries of NQM_VALUE_METRICS in the order of nqm_fit_loss: first the losses of the paths in corpora. */
#define LOSSES(X)                                                                                                      \
    X("log", "log(1 + f)", NQM_VALUE_LOG, false, 2)                                                                    \
    X("log-cos", "log(1 + c f)", NQM_VALUE_LOG, true, 2)                                                               \
    X("cube-root", "\xe2\x88\x9b f", NQM_VALUE_CUBE_ROOT, false, 2)                                                    \
    X("linear", "f", NQM_VALUE_LINEAR, false, 2)                                                                       \
    NQM_VALUE_METRICS(X)

const nqm_value_difference nqm_fit_losses[] = {LOSSES(NQM_VALUE_ROW)};
const char *const nqm_fit_loss_words[] = {LOSSES(NQM_VALUE_NAME) NULL};

_Static_assert(sizeof nqm_fit_losses / sizeof *nqm_fit_losses == NQM_FIT_N_LOSSES, "one row per loss");

double nqm_fit_transform(nqm_fit_loss loss, double weight, double f) {
    return nqm_value_on_curve(nqm_fit_losses[loss].curve, weight * f);
}

double nqm_fit_transform_slope(nqm_fit_loss loss, double weight, double f) {
    return weight * nqm_value_slope(nqm_fit_losses[loss].curve, weight * f);
}

double nqm_fit_loss_value(const nqm_fit_target *target, const double *rgb, double *gradient) {
    size_t n = 3 * target->n;
    bool squares = nqm_fit_losses[target->loss].power == 2;
    double sum = 0;
    for (size_t i = 0; i < n; ++i) {
        double weight = target->weight[i / 3];
        double r = nqm_fit_transform(target->loss, weight, rgb[i]) - target->goal[i];
        double length = sqrt(r * r + target->rounding * target->rounding);
        sum += squares ? r * r : length - target->rounding;
        if (gradient)
            gradient[i] = (squares      ? r
                           : length > 0 ? r / length
                                        : 0) *
                          nqm_fit_transform_slope(target->loss, weight, rgb[i]) / (double)n;
    }
    double value = squares ? sqrt(sum / (double)n) : sum / (double)n;
    for (size_t i = 0; gradient && squares && i < n; ++i)
        gradient[i] = value > 0 ? gradient[i] / value : 0;
    return value;
}
