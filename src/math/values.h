/* SPDX-License-Identifier: MIT
 *
 * values.h - how values of f_r are compared: the curves on which differences are taken, and the table of scalar metrics, which
 * are also losses of fits.
 */
#ifndef NQM_SRC_MATH_VALUES_H
#define NQM_SRC_MATH_VALUES_H

#include "base/base.h"

/** 1/sr, added to f_r before logarithms: a hundredth of a white Lambert surface. */
#define NQM_DARK 0.003
/** Values below it count as this value in the derivative of the cube root, which is infinite at 0. */
#define NQM_CUBE_ROOT_FLOOR 1e-9

/** Functions of x = f_r or c f_r, x >= 0; c = cos(theta_i) cos(theta_o). */
typedef enum nqm_value_curve {
    NQM_VALUE_LINEAR,    /**< x */
    NQM_VALUE_CUBE_ROOT, /**< cbrt(x) */
    NQM_VALUE_LOG,       /**< log(1 + x) */
    NQM_VALUE_LOG_DARK   /**< log(x + NQM_DARK) */
} nqm_value_curve;

double nqm_value_on_curve(nqm_value_curve curve, double x);
/** Its derivative; of the cube root, that at NQM_CUBE_ROOT_FLOOR at least. */
double nqm_value_slope(nqm_value_curve curve, double x);

/** X(name, what is compared, curve, whether of c f_r, power) of each metric in the order of nqm_metric, with which nqm_fit_loss
 *  ends. power 2: root mean square, 1: mean absolute difference. */
#define NQM_VALUE_METRICS(X)                                                                                           \
    X("rmse", "f", NQM_VALUE_LINEAR, false, 2)                                                                         \
    X("mae", "f", NQM_VALUE_LINEAR, false, 1)                                                                          \
    X("rms_crwe", "\xe2\x88\x9b(c f)", NQM_VALUE_CUBE_ROOT, true, 2)                                                   \
    X("ma_crwe", "\xe2\x88\x9b(c f)", NQM_VALUE_CUBE_ROOT, true, 1)                                                    \
    X("rms_loge", "log(1 + f)", NQM_VALUE_LOG, false, 2)                                                               \
    X("ma_loge", "log(1 + f)", NQM_VALUE_LOG, false, 1)                                                                \
    X("rms_logwe", "log(1 + c f)", NQM_VALUE_LOG, true, 2)                                                             \
    X("ma_logwe", "log(1 + c f)", NQM_VALUE_LOG, true, 1)                                                              \
    X("log_diff", "log(f + 0.003)", NQM_VALUE_LOG_DARK, false, 1)

/** A row of such a table. */
typedef struct nqm_value_difference {
    const char *name, *of;
    nqm_value_curve curve;
    bool weighted; /**< of c f_r */
    int power;
} nqm_value_difference;
/** Makes a row, or its name, of an entry. */
#define NQM_VALUE_ROW(name_, of_, curve_, weighted_, power_)                                                           \
    {.name = (name_), .of = (of_), .curve = (curve_), .weighted = (weighted_), .power = (power_)},
#define NQM_VALUE_NAME(name, of, curve, weighted, power) name,

#endif
