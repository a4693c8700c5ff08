/* SPDX-License-Identifier: MIT
 *
 * The interval around a predicted JOD: interpolated linearly in a table of the model file, and widened for pairs that
 * differ from the training pairs. train/interval_fit.c computes the table and the widening.
 */
#include "model/model.h"

#include <math.h>

const char *nqm_interval_table_fault(size_t n, const double *table) {
    if (n < 2)
        return "has fewer than two rows";
    for (size_t i = 0; i < n; ++i) {
        const double *row = table + 3 * i;
        if (!(row[1] <= row[0] && row[0] <= row[2]))
            return "has an interval that does not contain its prediction";
        if (i && !(row[0] > row[-3] && row[1] >= row[-2] && row[2] >= row[-1]))
            return "does not rise";
    }
    return NULL;
}

/* Index of the last row, other than the final one, whose JOD is at most `jod`; 0 if there is none. */
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
    *low_ret = fmin(jod, a[1] + t * (b[1] - a[1])); /* include `jod` despite rounding, and outside the table */
    *high_ret = fmax(jod, a[2] + t * (b[2] - a[2]));
}

/* ---- widening ---------------------------------------------------------------------------------------------------- */

static const double jod_top = 10;
static const double softening = 1e-3; /* JOD; keeps the logit finite at 0 and 10 */

double nqm_interval_y(double jod) {
    double inside = fmin(jod_top, fmax(0, jod));
    return log((inside + softening) / (jod_top - inside + softening));
}

double nqm_interval_jod(double y) {
    double odds = exp(-y);
    double jod = (jod_top + softening - softening * odds) / (1 + odds);
    return odds < INFINITY ? fmin(jod_top, fmax(0, jod)) : 0;
}

void nqm_interval_widen(double times, double jod, double *low, double *high) {
    double y = nqm_interval_y(jod);
    *low = fmin(*low, nqm_interval_jod(y - times * (y - nqm_interval_y(*low))));
    *high = fmax(*high, nqm_interval_jod(y + times * (nqm_interval_y(*high) - y)));
}

void nqm_model_interval(const nqm_model *model, double jod, double novelty, double *low_ret, double *high_ret) {
    *low_ret = *high_ret = NAN;
    if (!model->interval || !isfinite(jod))
        return;
    nqm_interval_at(model->n_interval, model->interval, jod, low_ret, high_ret);
    if (model->n_novelty && model->novelty_growth > 0)
        nqm_interval_widen(exp(model->novelty_growth * (isnan(novelty) ? 1 : novelty)), jod, low_ret, high_ret);
}
