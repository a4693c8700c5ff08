/* SPDX-License-Identifier: MIT
 *
 * The first value of an array that is out of a range, by whole vectors, because it checks whole files; and a binary search.
 */
#include "math/math.h"

#include <float.h>

static bool is_outside(float value, float least) {
    return !(value >= least && value <= FLT_MAX); /* true for NaN */
}

size_t nqm_first_outside(size_t n, const float *value, float least) {
    enum { LANES = 16 }; /* a constant number of inner iterations lets the compiler vectorise the loop */
    size_t i = 0;
    for (uint32_t any = 0; i + LANES <= n; i += LANES) {
        for (size_t k = 0; k < LANES; ++k)
            any |= (uint32_t) !(value[i + k] >= least) | (uint32_t) !(value[i + k] <= FLT_MAX);
        if (any)
            break;
    }
    while (i < n && !is_outside(value[i], least))
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
