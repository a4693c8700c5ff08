/* SPDX-License-Identifier: MIT
 *
 * pbrt's coateddiffuse against 200,000 random walks a pair (tests/vectors/shading_coated.py), and limits that have a closed form.
 */
#include "support/check.h"

TEST(values_are_means_of_random_walks) {
    nqm_csv *csv;
    double largest = 0;
    assert_int_equal(nqm_csv_load(test_vector("shading_coated.csv"), &csv, NULL), NQM_OK);
    assert_true(nqm_csv_rows(csv) == 15);
    for (size_t row = 0; row < nqm_csv_rows(csv); ++row) {
        nqm_brdf *brdf = must_open(nqm_csv_text(csv, row, 0));
        double v[12], rgb[3];
        for (int k = 0; k < 12; ++k)
            v[k] = csv_number(csv, row, k + 1);
        nqm_brdf_eval(brdf, 1, v, v + 3, rgb, NULL);
        for (int c = 0; c < 3; ++c) {
            largest = fmax(largest, fabs(rgb[c] - v[6 + c]) / v[6 + c]);
            assert_near(rgb[c], v[6 + c], 4 * v[9 + c] + 1e-4 * v[6 + c]);
        }
        nqm_brdf_free(brdf);
    }
    print_message("largest relative difference %.2g\n", largest);
    nqm_csv_free(csv);
}

/* A black base is the interface alone; a white one in an interface that hardly refracts is nearly Lambert's. */
TEST(limits_are_known) {
    static const double wi[3] = {0.6, 0, 0.8}, wo[3] = {-0.28, 0, 0.96};
    double coat[3], metal[3];
    nqm_brdf *brdf = must_open("pbrt-coated-diffuse:roughness=.2;reflectance=0;eta=1.5");
    nqm_brdf_eval(brdf, 1, wi, wo, coat, NULL);
    nqm_brdf_free(brdf);
    brdf = must_open("pbrt-conductor:roughness=.2;eta=1.5;k=0");
    nqm_brdf_eval(brdf, 1, wi, wo, metal, NULL);
    assert_near(coat[0], metal[0], 1e-12 * metal[0]);
    nqm_brdf_free(brdf);
    brdf = must_open("pbrt-coated-diffuse:roughness=1e-4;reflectance=1;eta=1.01;thickness=0;maxdepth=100");
    nqm_brdf_eval(brdf, 1, wi, wo, coat, NULL);
    assert_near(coat[0], 1 / acos(-1), 0.01);
    nqm_brdf_free(brdf);
}
