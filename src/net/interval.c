/* SPDX-License-Identifier: MIT
 *
 * The interval around a predicted JOD: a table in the model file, read by linear interpolation. train/interval_fit.c
 * makes it.
 */
#include "net/net.h"

#include <math.h>

const char *nqm_interval_table_fault(size_t n, const double *table) {
    if (n < 2)
        return "has fewer than two rows";
    for (size_t i = 0; i < n; ++i) {
        const double *row = table + 3 * i;
        if (!(row[1] <= row[0] && row[0] <= row[2]))
            return "has an interval that does not hold its prediction";
        if (i && !(row[0] > row[-3] && row[1] >= row[-2] && row[2] >= row[-1]))
            return "does not rise";
    }
    return NULL;
}

/* The last row at or below `jod`, but not the very last. */
static size_t find_row(size_t n, const double *table, double jod) {
    size_t low = 0, high = n - 1;
    while (high - low > 1) {
        size_t middle = (low + high) / 2;
        if (table[3 * middle] <= jod)
            low = middle;
        else
            high = middle;
    }
    return low;
}

void nqm_interval_at(size_t n, const double *table, double jod, double *low_ret, double *high_ret) {
    const double *a = table + 3 * find_row(n, table, jod), *b = a + 3;
    double t = fmin(1, fmax(0, (jod - a[0]) / (b[0] - a[0])));
    *low_ret = fmin(jod, a[1] + t * (b[1] - a[1])); /* rounding, and predictions beyond the ends of the table */
    *high_ret = fmax(jod, a[2] + t * (b[2] - a[2]));
}

void nqm_model_interval(const nqm_model *model, double jod, double *low_ret, double *high_ret) {
    *low_ret = *high_ret = NAN;
    if (model->interval && isfinite(jod))
        nqm_interval_at(model->n_interval, model->interval, jod, low_ret, high_ret);
}
