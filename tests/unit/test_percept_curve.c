/* SPDX-License-Identifier: MIT
 *
 * The curve from Delta-E to JOD: published rows of the authors, the limits of the range.
 */
#include "math/math.h"
#include "percept/percept.h"
#include "support/check.h"

/* Rows of the authors' labels_balanced_train.csv. */
TEST(published_values) {
    static const double row[][2] = {{0.93687516450882, 9.99513102937972}, {5.58987140655518, 9.55506134368299},
                                    {11.0372467041016, 8.50837750985371}, {15.5752754211426, 7.57752093864825},
                                    {31.7718620300293, 5.07366621972763}, {61.5419578552246, 2.97479763271854}};
    for (size_t i = 0; i < sizeof row / sizeof *row; ++i)
        assert_near(nqm_curve_jod(&nqm_curve_published, row[i][0]), row[i][1], 1e-12);
}

TEST(ends_of_the_range) {
    const nqm_curve *curve = &nqm_curve_published;
    assert_true(nqm_curve_jod(curve, 0) == 10);
    assert_true(nqm_curve_jod(curve, -3) == 10);
    assert_true(nqm_curve_jod(curve, 1e-300) == 10);
    assert_true(nqm_curve_jod(curve, 1e300) >= 0);
    double last = 10;
    for (double delta_e = 0.01; delta_e < 1e4; delta_e *= 1.1) {
        double jod = nqm_curve_jod(curve, delta_e);
        assert_true(jod <= last && jod > 0);
        last = jod;
    }
    assert_true(last < 0.5);
}

TEST(inverse_and_slope) {
    const nqm_curve *curve = &nqm_curve_published;
    for (double delta_e = 0.5; delta_e < 200; delta_e *= 1.7) {
        assert_relative(nqm_curve_delta_e(curve, nqm_curve_jod(curve, delta_e)), delta_e, 1e-9);
        const double step = 1e-5 * delta_e;
        assert_relative(nqm_curve_slope(curve, delta_e),
                        (nqm_curve_jod(curve, delta_e + step) - nqm_curve_jod(curve, delta_e - step)) / (2 * step),
                        1e-6);
    }
    assert_true(nqm_curve_delta_e(curve, 10) == 0 && nqm_curve_delta_e(curve, 11) == 0);
    assert_true(isnan(nqm_curve_delta_e(curve, NAN)));
    assert_true(nqm_curve_delta_e(curve, 0) == 1000 && nqm_curve_delta_e(curve, -1) == 1000);
    assert_true(nqm_curve_slope(curve, 0) == 0 && nqm_curve_slope(curve, -1) == 0);
    assert_true(nqm_curve_slope(curve, 1e-300) == 0); /* the share overflows */
}
