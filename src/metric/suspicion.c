/* SPDX-License-Identifier: MIT
 *
 * Suspicions about a bad score: values of another scale, or with the cosine, are often a fault of a file. The ratio of
 * the test to its reference is then about the same at all directions, or is a cosine.
 */
#include "metric/metric.h"

#include "math/math.h"
#include <math.h>

/* Medians and quartiles of this many directions say as much as those of all. Most pairs are cleared by the few. */
enum { FEW = 64, MANY = 1024 };

/* Median and interquartile range of log(test / ref) less `sign` log(cos(theta_o)), in green, at n directions, as far as
 * both are above 0; NaN where fewer than four are. */
static void log_ratio(const nqm_directions *d, const float *ref, const float *test, size_t n, double sign,
                      double range[2]) {
    double ratio[MANY];
    size_t m = 0;
    for (size_t i = 0; i < n; ++i) {
        const size_t at = 3 * (i * d->n / n);
        if (ref[at + 1] > 0 && test[at + 1] > 0)
            ratio[m++] = log((double)test[at + 1] / (double)ref[at + 1]) - (sign != 0 ? sign * log(d->wo[at + 2]) : 0);
    }
    m = m < 4 ? 0 : m;
    range[0] = nqm_quantile(m, ratio, 0.5);
    range[1] = nqm_quantile(m, ratio, 0.75) - nqm_quantile(m, ratio, 0.25);
}

/* slack (>= 1): how much weaker evidence may be. */
static bool suspect(const nqm_directions *d, const float *ref, const float *test, size_t n, double slack,
                    nqm_score_result *result) {
    double plain[2], with_cosine[2];
    log_ratio(d, ref, test, n, 0, plain);
    const bool is_pi = fabs(fabs(plain[0]) - log(NQM_PI)) < 0.01 * slack && plain[1] < 0.02 * slack;
    const bool is_scaled = is_pi || (fabs(plain[0]) > log(100) / slack && plain[1] < 3 * slack);
    if (is_scaled)
        result->suspect_scale = exp(plain[0]);
    for (int sign = -1; sign <= 1; sign += 2) {
        log_ratio(d, ref, test, n, sign, with_cosine);
        if (fabs(with_cosine[0]) < log(1.3) * slack && with_cosine[1] < 0.2 * slack * plain[1])
            result->suspect_cosine = sign;
    }
    return is_scaled || result->suspect_cosine != 0;
}

void nqm_suspect(const nqm_directions *directions, const float *ref, const float *test, nqm_score_result *result) {
    nqm_score_result unused = {.suspect_cosine = 0};
    const size_t n = directions->n;
    if (n <= FEW || suspect(directions, ref, test, FEW, 2, &unused))
        suspect(directions, ref, test, nqm_smaller(n, MANY), 1, result);
}
