/* SPDX-License-Identifier: MIT
 *
 * The interval around a predicted JOD: interpolated linearly in a table of the model file, and widened for pairs that
 * differ from the training pairs, or whose features say that errors are larger. train/interval_fit.c computes the table and the
 * widening.
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
    size_t row = 0;
    while (row + 2 < n && table[3 * (row + 1)] <= jod)
        ++row;
    return row;
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

void nqm_spread_features(const nqm_model *model, double jod, double log_estimate, double ref_peak, double *features) {
    static const double usual = 0.1; /* difference on the logit scale: about the median error */
    static const double peak =
        8; /* log of the peak relative to the mean: GGX with alpha 0.02 on a diffuse base has 9 */
    features[NQM_SPREAD_DISAGREEMENT] = 0;
    features[NQM_SPREAD_PEAK] = fmax(0, ref_peak - peak) / 10; /* 0 for NaN */
    if (model->transport && isfinite(log_estimate)) {
        const double estimated = nqm_curve_jod(&model->curve, exp(log_estimate));
        features[NQM_SPREAD_DISAGREEMENT] = log1p(fabs(nqm_interval_y(jod) - nqm_interval_y(estimated)) / usual);
    }
}

bool nqm_model_has_spread(const nqm_model *model) {
    bool has = false;
    for (size_t k = 0; k < NQM_SPREAD_FEATURES; ++k)
        has = has || model->spread_growth[k] > 0;
    for (size_t k = 0; k < NQM_INTERVAL_KNOTS; ++k)
        has = has || model->interval_floor[k] > 0;
    return has;
}

double nqm_model_spread(const nqm_model *model, const double *features) {
    double sum = 0;
    for (size_t k = 0; k < NQM_SPREAD_FEATURES; ++k)
        sum += model->spread_growth[k] * features[k];
    return sum;
}

/* ---- least width ------------------------------------------------------------------------------------------------- */

double nqm_interval_knot(size_t k) {
    return nqm_interval_y(jod_top) * (2 * (double)k / (NQM_INTERVAL_KNOTS - 1) - 1);
}

/* Interpolate the least half-width. */
static double floor_at(const nqm_model *model, double y) {
    const double at = (NQM_INTERVAL_KNOTS - 1) * (y / nqm_interval_y(jod_top) + 1) / 2;
    const double k = fmin(NQM_INTERVAL_KNOTS - 2, fmax(0, floor(at))), t = fmin(1, fmax(0, at - k));
    const double *row = model->interval_floor + (size_t)k;
    return (1 - t) * row[0] + t * row[1];
}

/* ---- of a model -------------------------------------------------------------------------------------------------- */

void nqm_model_interval(const nqm_model *model, double jod, double novelty, double spread, double *low_ret,
                        double *high_ret) {
    *low_ret = *high_ret = NAN;
    if (!model->interval || !isfinite(jod))
        return;
    nqm_interval_at(model->n_interval, model->interval, jod, low_ret, high_ret);
    if (model->n_novelty)
        spread += model->novelty_growth * (isnan(novelty) ? 1 : novelty);
    if (spread > 0)
        nqm_interval_widen(exp(spread), jod, low_ret, high_ret);
    const double y = nqm_interval_y(jod), least = floor_at(model, y);
    if (least > 0) {
        *low_ret = fmin(*low_ret, nqm_interval_jod(y - least));
        *high_ret = fmax(*high_ret, nqm_interval_jod(y + least));
    }
}
