/* SPDX-License-Identifier: MIT
 *
 * The shading models of Mitsuba 3 and pbrt-v4 against their formulas in 80-bit floats (tests/vectors/shading_*.py), and the
 * properties that the formulas promise.
 */
#include "io/io.h"
#include "math/math.h"
#include "support/check.h"

#include <math.h>

static void compare_with(const char *vectors, double tolerance) {
    nqm_csv *csv;
    assert_int_equal(nqm_csv_load(test_vector(vectors), &csv, NULL), NQM_OK);
    assert_true(nqm_csv_rows(csv) >= 100);
    for (size_t row = 0; row < nqm_csv_rows(csv); ++row) {
        nqm_brdf *brdf = must_open(nqm_csv_text(csv, row, 0));
        double v[9], rgb[3], swapped[3];
        for (int k = 0; k < 9; ++k)
            v[k] = csv_number(csv, row, k + 1);
        nqm_brdf_eval(brdf, 1, v, v + 3, rgb, NULL);
        nqm_brdf_eval(brdf, 1, v + 3, v, swapped, NULL);
        for (int c = 0; c < 3; ++c) {
            assert_near(rgb[c], v[6 + c], tolerance * fabs(v[6 + c]) + 1e-15);
            assert_near(rgb[c], swapped[c], 1e-14 * rgb[c]);
        }
        nqm_brdf_free(brdf);
    }
    nqm_csv_free(csv);
}

TEST(conductors_have_the_documented_values) {
    compare_with("shading_conductor.csv", 1e-8);
}

TEST(principled_has_the_documented_values) {
    compare_with("shading_principled.csv", 1e-8);
}

/* The table's error is part of the difference. */
TEST(plastics_have_the_documented_values) {
    compare_with("shading_plastic.csv", 1e-4);
}

/* Mitsuba does not evaluate the main lobe where its dielectric reflects nothing. */
TEST(principled_without_a_main_lobe) {
    const double up[3] = {0, 0, 1};
    double rgb[3];
    nqm_brdf *brdf = must_open("principled:metallic=1;eta=1");
    nqm_brdf_eval(brdf, 1, up, up, rgb, NULL);
    assert_true(rgb[0] == 0);
    nqm_brdf_free(brdf);
}

/* The largest albedo of the three channels at the incident angle, by midpoints in cosine squared and phi. */
static double albedo(const nqm_brdf *brdf, double theta_i) {
    enum { N = 120 };
    double sum[3] = {0};
    const double wi[3] = {sin(theta_i), 0, cos(theta_i)};
    for (size_t i = 0; i < N * N; ++i) {
        const double sin2 = ((double)(i / N) + 0.5) / N, phi = ((double)(i % N) + 0.5) / N * NQM_PI;
        const double wo[3] = {sqrt(sin2) * cos(phi), sqrt(sin2) * sin(phi), sqrt(1 - sin2)};
        double rgb[3];
        nqm_brdf_eval(brdf, 1, wi, wo, rgb, NULL);
        for (int c = 0; c < 3; ++c)
            sum[c] += rgb[c] * NQM_PI / (N * N);
    }
    return fmax(sum[0], fmax(sum[1], sum[2]));
}

TEST(nothing_reflects_more_than_it_receives) {
    static const char *const specs[] = {"rough-conductor:alpha=.3",
                                        "rough-conductor:alpha=.3;distribution=1",
                                        "rough-conductor:alpha=.8",
                                        "rough-conductor:alpha=1;distribution=1;eta=.1;k=9",
                                        "pbrt-conductor:roughness=.3;eta=.1;k=9",
                                        "principled:base_color=1;metallic=1",
                                        "rough-plastic:diffuse_reflectance=1;alpha=.2",
                                        "rough-plastic:diffuse_reflectance=1;alpha=.5;distribution=1;eta=2"};
    for (size_t i = 0; i < sizeof specs / sizeof *specs; ++i) {
        nqm_brdf *brdf = must_open(specs[i]);
        for (double theta = 0; theta < 1.5; theta += 0.35) {
            const double a = albedo(brdf, theta);
            assert_true(a <= 1.001 && a > 0.2);
        }
        nqm_brdf_free(brdf);
    }
}
