/* SPDX-License-Identifier: MIT
 *
 * Axes of drawings: rounded limits, ticks and their labels on linear, logarithmic and square-root scales, positions of
 * values.
 */
#include "figures/sheet.h"
#include "support/check.h"

#include <float.h>
#include <math.h>
#include <string.h>

static nqm_axis held(nqm_scale scale, double a, double b, size_t n_most) {
    nqm_axis axis = nqm_axis_make("x", scale);
    nqm_axis_include(&axis, 2, (double[]){a, b});
    nqm_axis_round(&axis, n_most);
    return axis;
}

/* The non-empty tick labels joined by blanks ("0 2 4 6"); ticks must increase and be within the axis. */
static const char *labels(const nqm_axis *axis, size_t n_most) {
    static char text[512];
    nqm_tick_mark ticks[NQM_MAX_TICKS];
    size_t n = nqm_axis_ticks(axis, n_most, ticks), at = 0;
    text[0] = 0;
    for (size_t i = 0; i < n; ++i) {
        double place = nqm_axis_place(axis, ticks[i].value);
        assert_true(place > -1e-6 && place < 1 + 1e-6);
        assert_true(i == 0 || ticks[i].value > ticks[i - 1].value);
        if (ticks[i].label[0])
            at += (size_t)snprintf(text + at, sizeof text - at, "%s%s", at ? " " : "", ticks[i].label);
    }
    return text;
}

#define MINUS "\xe2\x88\x92"

TEST(linear) {
    nqm_axis axis = held(NQM_LINEAR, 0.3, 9.1, 6);
    assert_string_equal(labels(&axis, 6), "0 2 4 6 8 10");
    axis = held(NQM_LINEAR, -0.17, 0.52, 8);
    assert_string_equal(labels(&axis, 8), MINUS "0.2 " MINUS "0.1 0 0.1 0.2 0.3 0.4 0.5 0.6");
    axis = held(NQM_LINEAR, 1234567, 1234569, 5); /* far from zero */
    assert_string_equal(labels(&axis, 5), "1234567 1234567.5 1234568 1234568.5 1234569");
    axis = held(NQM_LINEAR, 3, 3, 5); /* one value */
    assert_true(axis.min < 3 && axis.max > 3);
    axis = held(NQM_LINEAR, (double)NAN, (double)INFINITY, 5); /* no finite value */
    assert_true(axis.min < axis.max && isfinite(axis.min) && isfinite(axis.max));
    axis = (nqm_axis){.max = 90, .step = 15};
    assert_string_equal(labels(&axis, 3), "0 15 30 45 60 75 90");
    for (double top = 1e-7; top < 1e9; top *= 3.7) { /* 3 to 8 ticks, exact at the upper end */
        nqm_tick_mark ticks[NQM_MAX_TICKS];
        axis = held(NQM_LINEAR, 0, top, 6);
        size_t n = nqm_axis_ticks(&axis, 6, ticks);
        assert_true(n >= 3 && n <= 8);
        assert_near(ticks[n - 1].value / axis.max, 1, 1e-9);
    }
}

TEST(logarithmic) {
    nqm_axis axis = held(NQM_LOG, 0.0013, 870, 6);
    assert_near(axis.min, 0.001, 1e-12);
    assert_near(axis.max, 1000, 1e-9);
    assert_string_equal(labels(&axis, 6), "0.001 0.01 0.1 1 10 100 1000");
    nqm_tick_mark ticks[NQM_MAX_TICKS];
    assert_int_equal(nqm_axis_ticks(&axis, 6, ticks), 6 * 9 + 1);
    axis = held(NQM_LOG, 0.013, 0.41, 6); /* few decades: labels at 1, 2 and 5 */
    assert_string_equal(labels(&axis, 6), "0.01 0.02 0.05 0.1 0.2 0.5");
    axis = held(NQM_LOG, 2e-6, 3e5, 4); /* many decades: labels at every third power */
    assert_string_equal(labels(&axis, 4), "10^{" MINUS "3} 10^{0} 10^{3}");
    axis = (nqm_axis){.scale = NQM_LOG, .min = 1.1, .max = 1.4}; /* within a decade: like a linear axis */
    assert_string_equal(labels(&axis, 4), "1.1 1.2 1.3 1.4");
    axis = held(NQM_LOG, 0, -1, 5); /* no positive value */
    assert_true(axis.min > 0 && axis.min < axis.max);
    assert_near(nqm_axis_place(&(nqm_axis){.scale = NQM_LOG, .min = 0.01, .max = 100}, 1), 0.5, 1e-12);
    assert_true(isnan(nqm_axis_place(&axis, 0)));
    for (double bottom = 1e-12; bottom < 1e12; bottom *= 7.3)
        for (double factor = 1.5; factor < 1e18; factor *= 9.1) {
            axis = held(NQM_LOG, bottom, bottom * factor, 6);
            const char *text = labels(&axis, 6);
            assert_true(axis.min <= bottom * (1 + 1e-9) && axis.max >= bottom * factor * (1 - 1e-9));
            size_t n = 0;
            for (; *text; ++text)
                n += *text == ' ';
            assert_true(n >= 1 && n <= 9);
        }
}

TEST(square_root) {
    nqm_axis axis = {.scale = NQM_SQRT, .min = 0, .max = 90};
    assert_string_equal(labels(&axis, 5), "0 1 2 5 10 20 30 45 60 75 90");
    assert_near(nqm_axis_place(&axis, 22.5), 0.5, 1e-12);
    assert_true(isnan(nqm_axis_place(&axis, -1)));
}

/* The ends of an axis are finite and its ticks few, whatever numbers a file has. */
TEST(largest_and_smallest) {
    static const double numbers[] = {-DBL_MAX, -1e300, 5e-324, DBL_MIN, 1e-300, 1, 1e300, DBL_MAX};
    enum { N = sizeof numbers / sizeof *numbers };
    for (int scale = NQM_LINEAR; scale <= NQM_SQRT; ++scale)
        for (size_t i = 0; i < N * N; ++i) {
            nqm_axis axis = held((nqm_scale)scale, numbers[i / N], numbers[i % N], 6);
            assert_true(isfinite(axis.max - axis.min) && axis.min < axis.max);
            assert_true(scale != NQM_LOG || axis.min > 0);
            labels(&axis, 6);
        }
    const nqm_axis axis = {.max = 1};
    assert_true(isnan(nqm_axis_place(&axis, DBL_MAX)));
}

TEST(padded) {
    nqm_axis axis = held(NQM_LINEAR, 0, 10, 10);
    nqm_axis_pad(&axis, 0.2, 10);
    assert_near(axis.min, -0.2, 1e-12);
    assert_near(axis.max, 10.4, 1e-12);
    axis.step = 2; /* ticks remain where they were */
    assert_string_equal(labels(&axis, 10), "0 2 4 6 8 10");
    axis = held(NQM_LINEAR, 0, 10, 10); /* points clear of the ends, and no points */
    nqm_axis_pad(&axis, 4, 9.5);
    nqm_axis_pad(&axis, (double)INFINITY, -(double)INFINITY);
    assert_true(axis.min == 0 && axis.max == 10);
    axis = held(NQM_LOG, 0.01, 100, 6);
    nqm_axis_pad(&axis, 0.01, 5);
    assert_near(log10(axis.min), -2.16, 1e-12);
    assert_near(axis.max, 100, 1e-12);
    axis = held(NQM_LOG, 1e-300, 1e300, 6);
    nqm_axis_pad(&axis, 1e-300, 1e300);
    assert_true(nqm_axis_place(&axis, 1e-300) > 0 && nqm_axis_place(&axis, 1e300) < 1);
}
