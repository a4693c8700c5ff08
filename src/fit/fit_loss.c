/* SPDX-License-Identifier: MIT
 *
 * The losses between BRDF values: one table of names, scales and powers; the scales and their derivatives.
 */
#include "fit/fit.h"

#include <math.h>

/* X(word, curve, weighted by c, power) in the order of nqm_fit_loss. */
#define LOSSES(X)                                                                                                      \
    X("log", NQM_FIT_CURVE_LOG, false, 2)                                                                              \
    X("log-cos", NQM_FIT_CURVE_LOG, true, 2)                                                                           \
    X("cube-root", NQM_FIT_CURVE_CUBE_ROOT, false, 2)                                                                  \
    X("linear", NQM_FIT_CURVE_LINEAR, false, 2)                                                                        \
    X("rmse", NQM_FIT_CURVE_LINEAR, false, 2)                                                                          \
    X("mae", NQM_FIT_CURVE_LINEAR, false, 1)                                                                           \
    X("rms_crwe", NQM_FIT_CURVE_CUBE_ROOT, true, 2)                                                                    \
    X("ma_crwe", NQM_FIT_CURVE_CUBE_ROOT, true, 1)                                                                     \
    X("rms_loge", NQM_FIT_CURVE_LOG, false, 2)                                                                         \
    X("ma_loge", NQM_FIT_CURVE_LOG, false, 1)                                                                          \
    X("rms_logwe", NQM_FIT_CURVE_LOG, true, 2)                                                                         \
    X("ma_logwe", NQM_FIT_CURVE_LOG, true, 1)                                                                          \
    X("log_diff", NQM_FIT_CURVE_LOG_OFFSET, false, 1)

#define ENTRY(word, curve, weighted, power) {curve, weighted, power},
const nqm_fit_loss_entry nqm_fit_losses[] = {LOSSES(ENTRY)};
#define WORD(word, curve, weighted, power) word,
const char *const nqm_fit_loss_words[] = {LOSSES(WORD) NULL};

_Static_assert(sizeof nqm_fit_losses / sizeof *nqm_fit_losses == NQM_FIT_N_LOSSES, "one row per loss");

static const double log_offset = 0.003, min_root = 1e-6; /* the derivative of cbrt() is infinite at 0 */

double nqm_fit_transform(nqm_fit_loss loss, double weight, double f) {
    switch (nqm_fit_losses[loss].curve) {
    case NQM_FIT_CURVE_LOG:
        return log1p(weight * f);
    case NQM_FIT_CURVE_CUBE_ROOT:
        return cbrt(weight * f);
    case NQM_FIT_CURVE_LOG_OFFSET:
        return log(weight * f + log_offset);
    case NQM_FIT_CURVE_LINEAR:
        break;
    }
    return weight * f;
}

double nqm_fit_transform_slope(nqm_fit_loss loss, double weight, double f) {
    switch (nqm_fit_losses[loss].curve) {
    case NQM_FIT_CURVE_LOG:
        return weight / (1 + weight * f);
    case NQM_FIT_CURVE_CUBE_ROOT: {
        double root = cbrt(fmax(weight * f, min_root));
        return weight / (3 * root * root);
    }
    case NQM_FIT_CURVE_LOG_OFFSET:
        return weight / (weight * f + log_offset);
    case NQM_FIT_CURVE_LINEAR:
        break;
    }
    return weight;
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
