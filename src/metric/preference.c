/* SPDX-License-Identifier: MIT
 *
 * Probability of preference for a JOD difference (Perez-Ortiz and Mantiuk 2017, arXiv:1712.03686, section 2).
 */
#include <math.h>
#include <nqm/metric.h>

double nqm_jod_preference(double jod, double other_jod) {
    const double z75 = 0.6744897501960817; /* Phi(z75) = 0.75 */
    return 0.5 * erfc(-z75 * (jod - other_jod) / sqrt(2));
}
