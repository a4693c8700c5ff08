/* SPDX-License-Identifier: MIT
 *
 * Vectors and half-vector coordinates: against the rotations that define them (tests/vectors/coordinates.py), and round
 * trips for random pairs and limiting cases: mirror direction, retroreflection, grazing angles, theta_h of a thousandth
 * of a degree.
 */
#include "io/io.h"
#include "math/math.h"
#include "support/check.h"

TEST(test_coordinates_by_rotation) {
    nqm_csv *csv;
    assert_int_equal(nqm_csv_load(test_vector("coordinates.csv"), &csv, NULL), NQM_OK);
    assert_true(nqm_csv_rows(csv) > 50);
    for (size_t row = 0; row < nqm_csv_rows(csv); ++row) {
        double v[9], hd[3];
        for (int k = 0; k < 9; ++k)
            v[k] = csv_number(csv, row, k);
        nqm_half_diff_from_pair(v, v + 3, hd);
        assert_near(hd[0], v[6], 1e-15);
        assert_near(hd[1], v[7], 1e-15);
        /* the azimuth is ill-conditioned for small sin(theta_d); pi and 0 are the same azimuth */
        double turn = fabs(hd[2] - v[8]);
        assert_near(fmin(turn, NQM_PI - turn) * sin(hd[1]), 0, 1e-15);
    }
    nqm_csv_free(csv);
}

static void check_pair(const double *hd) {
    double wi[3], wo[3], h[3];
    nqm_half_diff_to_pair(hd, wi, wo);
    assert_near(nqm_dot3(wi, wi), 1, 1e-15);
    assert_near(nqm_dot3(wo, wo), 1, 1e-15);
    for (int k = 0; k < 3; ++k)
        h[k] = wi[k] + wo[k];
    nqm_normalize3(h);
    if (hd[1] < 1.5) { /* at theta_d = 90 degrees, light and viewer are opposite and have no half vector */
        assert_near(h[0], sin(hd[0]), 1e-14);
        assert_near(h[1], 0, 1e-14);
        assert_near(nqm_dot3(wi, h), cos(hd[1]), 1e-14);
    }
}

TEST(test_round_trip) {
    const uint64_t seed = 5;
    print_message("seed %d\n", (int)seed);
    nqm_rng rng = nqm_rng_make(seed, 0);
    for (int i = 0; i < 20000; ++i) {
        double hd[3] = {1.57 * pow(nqm_rng_uniform(&rng), 3), 1.55 * nqm_rng_uniform(&rng),
                        NQM_PI * nqm_rng_uniform(&rng)};
        double wi[3], wo[3], back[3], swapped[3];
        check_pair(hd);
        nqm_half_diff_to_pair(hd, wi, wo);
        nqm_half_diff_from_pair(wi, wo, back);
        nqm_half_diff_from_pair(wo, wi, swapped);
        double cos_d = cos(hd[1]), sin_d = sin(hd[1]), turn = fabs(back[2] - hd[2]);
        /* near theta_d = 90 degrees the half vector suffers from cancellation */
        assert_near(back[0], hd[0], 1e-15 / cos_d);
        assert_near(back[1], hd[1], 1e-15 / cos_d);
        assert_near(fmin(turn, NQM_PI - turn) * sin_d * cos_d * sin(hd[0]), 0, 2e-15);
        assert_true(back[2] >= 0 && back[2] < NQM_PI);
        turn = fabs(swapped[2] - back[2]);
        assert_near(swapped[0], back[0], 1e-15 / cos_d);
        assert_near(swapped[1], back[1], 1e-15 / cos_d);
        assert_near(fmin(turn, NQM_PI - turn) * sin_d * cos_d * sin(hd[0]), 0, 2e-15);
    }
}

TEST(test_corners) {
    const double normal[3] = {0, 0, 1};
    double hd[3];
    nqm_half_diff_from_pair(normal, normal, hd);
    assert_near(hd[0], 0, 0);
    assert_near(hd[1], 0, 0);
    assert_near(hd[2], 0, 0);
    double wi[3], wo[3];
    nqm_spherical(0.9, 0.4, wi);
    nqm_spherical(0.9, 0.4 + NQM_PI, wo);
    nqm_half_diff_from_pair(wi, wo, hd); /* mirror direction */
    assert_near(hd[0], 0, 1e-15);
    assert_near(hd[1], 0.9, 1e-15);
    nqm_half_diff_from_pair(wi, wi, hd); /* retroreflection */
    assert_near(hd[0], 0.9, 1e-15);
    assert_near(hd[1], 0, 1e-15);
    const double tiny[3] = {1e-5, 0.6, 1.1};
    nqm_half_diff_to_pair(tiny, wi, wo);
    nqm_half_diff_from_pair(wi, wo, hd);
    assert_near(hd[0], 1e-5, 1e-15); /* acos would give only five digits */
    assert_near(hd[1], 0.6, 1e-15);
    assert_near(hd[2], 1.1, 1e-10);
}

TEST(test_vectors) {
    double x[3] = {1, 0, 0}, yz[3] = {0, 3, 4}, cross[3];
    nqm_cross3(x, yz, cross);
    assert_true(cross[0] == 0 && cross[1] == -4 && cross[2] == 3);
    assert_near(nqm_dot3(yz, cross), 0, 0);
    nqm_cross3(x, x, x); /* in place */
    assert_true(x[0] == 0 && x[1] == 0 && x[2] == 0);
    nqm_normalize3(yz);
    assert_near(yz[1], 0.6, 1e-16);
    assert_near(yz[2], 0.8, 1e-16);
    double zero[3] = {0, 0, 0};
    nqm_normalize3(zero);
    assert_near(zero[2], 1, 0);
    const double white[3] = {1, 1, 1};
    assert_near(nqm_luminance(white), 1, 1e-15);
}

/* By hand: the digits of i in the base, mirrored at the point. */
TEST(test_radical_inverse) {
    assert_near(nqm_radical_inverse(0, 2), 0, 0);
    assert_near(nqm_radical_inverse(1, 2), 0.5, 0);
    assert_near(nqm_radical_inverse(6, 2), 0.375, 0);       /* 110 */
    assert_near(nqm_radical_inverse(7, 3), 5 / 9.0, 1e-15); /* 21 becomes 0.12 */
}
