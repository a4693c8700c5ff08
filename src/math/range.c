/* SPDX-License-Identifier: MIT
 *
 * Checks that all values of an array are finite and at least a limit; vectorised, because it checks whole files.
 */
#include "math/math.h"

#include <float.h>

static bool is_within(float value, float least) {
    return value >= least && value <= FLT_MAX; /* false for NaN */
}

bool nqm_all_within(size_t n, const float *value, float least) {
    enum { LANES = 16 }; /* a constant number of inner iterations lets the compiler vectorise the loop */
    uint32_t bad[LANES] = {0}, any = 0;
    size_t i = 0;
    for (; i + LANES <= n; i += LANES)
        for (size_t k = 0; k < LANES; ++k)
            bad[k] |= (uint32_t) !(value[i + k] >= least) | (uint32_t) !(value[i + k] <= FLT_MAX);
    for (; i < n; ++i)
        any |= !is_within(value[i], least);
    for (size_t k = 0; k < LANES; ++k)
        any |= bad[k];
    return any == 0;
}

size_t nqm_first_outside(size_t n, const float *value, float least) {
    size_t i = 0;
    while (i < n && is_within(value[i], least))
        ++i;
    return i;
}

size_t nqm_last_not_above(const double *value, size_t n, double x) {
    size_t low = 0, high = n;
    while (high - low > 1) {
        size_t middle = low + (high - low) / 2;
        if (value[middle] <= x)
            low = middle;
        else
            high = middle;
    }
    return low;
}
