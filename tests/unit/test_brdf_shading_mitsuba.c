/* SPDX-License-Identifier: MIT
 *
 * The shading models of Mitsuba 3 and pbrt-v4 against their formulas in 80-bit floats (tests/vectors/shading_*.py), and the
 * properties that the formulas promise.
 */
#include "support/rows.h"
#include "support/shading.h"

TEST(conductors_have_the_documented_values) {
    assert_true(check_shading_vectors("shading_conductor.csv", 384, 1e-8, 1e-15) <= 1e-14);
}

TEST(principled_has_the_documented_values) {
    assert_true(check_shading_vectors("shading_principled.csv", 320, 1e-8, 1e-15) <= 1e-14);
}

/* The table's error is part of the difference. */
TEST(plastics_have_the_documented_values) {
    assert_true(check_shading_vectors("shading_plastic.csv", 128, 1e-4, 1e-15) <= 1e-14);
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

TEST(nothing_reflects_more_than_it_receives) {
    EVERY_ROW(row, "surfaces of Mitsuba and pbrt") {
        for (double theta = 0; theta < 1.5; theta += 0.35) {
            const double a = shading_albedo(row[0], theta);
            assert_true(a <= 1.001 && a > 0.2);
        }
    }
}
