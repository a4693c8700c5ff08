/* SPDX-License-Identifier: MIT
 *
 * The curves of values.h, and their derivatives.
 */
#include "math/values.h"

#include <math.h>

double nqm_value_on_curve(nqm_value_curve curve, double x) {
    switch (curve) {
    case NQM_VALUE_CUBE_ROOT:
        return cbrt(x);
    case NQM_VALUE_LOG:
        return log1p(x);
    case NQM_VALUE_LOG_DARK:
        return log(x + NQM_DARK);
    case NQM_VALUE_LINEAR:
        break;
    }
    return x;
}

double nqm_value_slope(nqm_value_curve curve, double x) {
    switch (curve) {
    case NQM_VALUE_CUBE_ROOT: {
        const double root = cbrt(fmax(x, NQM_CUBE_ROOT_FLOOR));
        return 1 / (3 * root * root);
    }
    case NQM_VALUE_LOG:
        return 1 / (1 + x);
    case NQM_VALUE_LOG_DARK:
        return 1 / (x + NQM_DARK);
    case NQM_VALUE_LINEAR:
        break;
    }
    return 1;
}
