/* SPDX-License-Identifier: MIT
 *
 * The curve from Delta-E ITP to JOD: Kavoosighafi et al. 2025, eq. 1,
 *     JOD = 10 (1 - 1 / (1 + exp(b1 (-(max(dE, 0)^b3) - b2)))).
 */
#include "math/math.h"

#include <math.h>

/* Least squares on the authors' 180 human scores; the paper prints them rounded to (-14.11, -0.47, -0.21). */
const nqm_jod_curve nqm_jod_curve_published = {-14.11196939758611, -0.47364347065458806, -0.21479944748134167};

double nqm_jod_from_delta_e(const nqm_jod_curve *curve, double delta_e) {
    if (delta_e <= 0) /* 0 to a negative power: the limit of the formula, without an infinity on the way */
        return 10;
    double z = curve->b1 * (-pow(delta_e, curve->b3) - curve->b2);
    return 10 / (1 + exp(-z)); /* 1 - 1/(1 + e^z), without cancellation */
}
