/* SPDX-License-Identifier: MIT
 *
 * Scales: their upper end and their ticks.
 */
#include "figures/tone.h"

#include <math.h>
#include <stdlib.h>

double nqm_tick_step(double max, size_t n_most) {
    double power = pow(10, floor(log10(max / (double)n_most)));
    static const double factors[] = {1, 2, 5, 10};
    size_t i = 0;
    while (i < 3 && max / (factors[i] * power) > (double)n_most * (1 + 1e-9))
        ++i;
    return factors[i] * power;
}

static int compare(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

nqm_status nqm_map_scale(size_t n_maps, const double *const *maps, size_t n, double *end_ret, nqm_error *err) {
    size_t n_values = 0, room;
    double *values = nqm_mul_size(n_maps, n, &room) ? nqm_alloc(room, sizeof *values) : NULL;
    if (!values)
        return nqm_fail_nomem(err, n_maps * n * sizeof *values);
    for (size_t m = 0; m < n_maps; ++m)
        for (size_t i = 0; i < n; ++i)
            if (isfinite(maps[m][i]))
                values[n_values++] = maps[m][i];
    qsort(values, n_values, sizeof *values, compare);
    double most = n_values ? fmax(values[(size_t)(0.99 * (double)(n_values - 1))], 1) : 1;
    nqm_free(values);
    double step = nqm_tick_step(most, 5);
    *end_ret = step * ceil(most / step * (1 - 1e-9));
    return NQM_OK;
}
