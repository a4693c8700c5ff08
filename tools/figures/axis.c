/* SPDX-License-Identifier: MIT
 *
 * Axes: round ends, ticks at multiples of 1, 2 or 5 times a power of ten, and their labels.
 */
#include "figures/sheet.h"

#include <math.h>
#include <stdlib.h>

/* Tolerance, so that rounding errors do not drop a tick at the end of an axis. */
static const double slack = 1e-9;

/* The largest of 1, 2, 5 times a power of ten that is at most `value`, or the smallest that is at least it. */
static double round_number(double value, bool up) {
    static const double digits[] = {1, 2, 5, 10};
    double power = pow(10, floor(log10(value) + slack)), digit = value / power;
    size_t i = 0;
    while (i < 3 && digits[i] < digit * (1 - slack))
        ++i;
    if (!up && i > 0 && digits[i] > digit * (1 + slack))
        --i;
    return digits[i] * power;
}

double nqm_tick_step(double length, size_t n_most) {
    return round_number(length / (double)n_most, true);
}

nqm_axis nqm_axis_make(const char *label, nqm_scale scale) {
    return (nqm_axis){.label = label, .scale = scale, .min = (double)INFINITY, .max = -(double)INFINITY};
}

/* Bounds of the magnitudes on an axis: rounded ends must not overflow or become 0. A tick may be beyond the values. */
static const double largest_value = 1e300, largest_tick = 1e302;

static bool has_position(const nqm_axis *axis, double value, double largest) {
    return fabs(value) <= largest && (axis->scale == NQM_LINEAR || value >= (axis->scale == NQM_LOG ? 1 / largest : 0));
}

void nqm_axis_include(nqm_axis *axis, size_t n, const double *values) {
    for (size_t i = 0; i < n; ++i)
        if (has_position(axis, values[i], largest_value)) {
            axis->min = fmin(axis->min, values[i]);
            axis->max = fmax(axis->max, values[i]);
        }
}

/* Give an empty range, or one of a single value, two different ends. */
static void widen(nqm_axis *axis) {
    if (axis->min > axis->max)
        *axis = (nqm_axis){.label = axis->label, .scale = axis->scale, .step = axis->step, .min = 1, .max = 1};
    const double least = 1 / largest_value;
    if (axis->max - axis->min > fmax(1e-12 * fmax(fabs(axis->min), fabs(axis->max)), least))
        return;
    double half = axis->scale != NQM_LOG && fabs(axis->min) <= least ? 1 : 0.5 * fabs(axis->min);
    axis->max += half;
    axis->min = axis->scale == NQM_SQRT ? fmax(axis->min - half, 0) : axis->min - half;
}

static double step_of(const nqm_axis *axis, size_t n_most) {
    return axis->step > 0 ? axis->step : nqm_tick_step(axis->max - axis->min, n_most);
}

void nqm_axis_round(nqm_axis *axis, size_t n_most) {
    widen(axis);
    if (axis->scale == NQM_LOG) {
        axis->min = round_number(axis->min, false);
        axis->max = round_number(axis->max, true);
        return;
    }
    double step = step_of(axis, n_most);
    axis->min = step * floor(axis->min / step + slack);
    axis->max = step * ceil(axis->max / step - slack);
}

static double scaled(const nqm_axis *axis, double value) {
    return axis->scale == NQM_LOG ? log10(value) : axis->scale == NQM_SQRT ? sqrt(value) : value;
}

static double unscaled(const nqm_axis *axis, double place) {
    return axis->scale == NQM_LOG ? fmin(fmax(pow(10, place), 1 / largest_tick), largest_tick) : place;
}

void nqm_axis_pad(nqm_axis *axis, double low, double high) {
    const double first = scaled(axis, axis->min), last = scaled(axis, axis->max);
    const double room = 0.04 * (last - first); /* more than the radius of a marker on an axis of 90 pixels */
    if (low > high)
        return;
    if (scaled(axis, low) - room < first)
        axis->min = unscaled(axis, scaled(axis, low) - room);
    if (scaled(axis, high) + room > last)
        axis->max = unscaled(axis, scaled(axis, high) + room);
}

double nqm_axis_place(const nqm_axis *axis, double value) {
    if (!has_position(axis, value, largest_tick))
        return (double)NAN;
    double low = scaled(axis, axis->min);
    return (scaled(axis, value) - low) / (scaled(axis, axis->max) - low);
}

/* ---- labels ------------------------------------------------------------------------------------------------------ */

static void label_number(double value, char label[24]) {
    char number[32];
    nqm_format_double(number, sizeof number, nqm_round_digits(fabs(value), 9));
    snprintf(label, 24, "%s%.19s", value < 0 ? NQM_MINUS : "", number);
}

/* digit * 10^exponent */
static void label_power(int digit, int exponent, bool powers, char label[24]) {
    char factor[8] = "";
    if (digit > 1)
        snprintf(factor, sizeof factor, "%d\xc2\xb7", digit % 10);
    if (powers)
        snprintf(label, 24, "%s10^{%s%d}", factor, exponent < 0 ? NQM_MINUS : "", abs(exponent) % 1000);
    else
        label_number(digit * pow(10, exponent), label);
}

/* ---- ticks ------------------------------------------------------------------------------------------------------- */

static size_t add(nqm_tick_mark *ticks, size_t n, double value) {
    if (n < NQM_MAX_TICKS)
        ticks[n++] = (nqm_tick_mark){.value = value};
    return n;
}

static size_t linear_ticks(const nqm_axis *axis, size_t n_most, nqm_tick_mark *ticks) {
    double step = step_of(axis, n_most), first = ceil(axis->min / step - slack);
    size_t n = 0;
    for (double i = first; i * step <= axis->max + slack * step && n < NQM_MAX_TICKS; ++i) {
        n = add(ticks, n, i == 0 ? 0 : i * step); /* no negative zero */
        label_number(ticks[n - 1].value, ticks[n - 1].label);
    }
    return n;
}

/* Each decade has a tick. Every `stride`-th decade has a label or, if there are few, 1, 2 and 5 times each. */
static size_t log_ticks(const nqm_axis *axis, size_t n_most, nqm_tick_mark *ticks) {
    double low = log10(axis->min), high = log10(axis->max);
    int first = (int)floor(low + slack), last = (int)floor(high + slack);
    int stride = (int)ceil((high - low) / (double)n_most);
    stride = stride > 1 ? stride : 1;
    bool fine = high - low < 2.5, powers = first < -3 || last > 4;
    size_t n = 0;
    for (int e = first; e <= last; ++e)
        for (int digit = 1; digit < 10; ++digit) {
            double value = digit * pow(10, e);
            if (value < axis->min * (1 - slack) || value > axis->max * (1 + slack) || (digit > 1 && stride > 1))
                continue;
            n = add(ticks, n, value);
            nqm_tick_mark *tick = &ticks[n - 1];
            if ((digit == 1 && e % stride == 0) || (fine && (digit == 2 || digit == 5)))
                label_power(digit, e, powers, tick->label);
        }
    return n;
}

/* Degrees; labels are denser near 0, where the scale is wide. */
static size_t sqrt_ticks(const nqm_axis *axis, nqm_tick_mark *ticks) {
    static const double values[] = {0, 1, 2, 5, 10, 20, 30, 45, 60, 75, 90};
    size_t n = 0;
    for (size_t i = 0; i < sizeof values / sizeof *values; ++i)
        if (values[i] >= axis->min && values[i] <= axis->max * (1 + slack)) {
            n = add(ticks, n, values[i]);
            label_number(values[i], ticks[n - 1].label);
        }
    return n;
}

size_t nqm_axis_ticks(const nqm_axis *axis, size_t n_most, nqm_tick_mark ticks[NQM_MAX_TICKS]) {
    bool narrow = axis->scale == NQM_LOG && axis->max < 3 * axis->min; /* 1, 2 and 5 would leave one label or none */
    if (axis->scale == NQM_SQRT)
        return sqrt_ticks(axis, ticks);
    return axis->scale == NQM_LOG && !narrow ? log_ticks(axis, n_most, ticks) : linear_ticks(axis, n_most, ticks);
}
