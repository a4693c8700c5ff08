/* SPDX-License-Identifier: MIT
 *
 * The analytic models against their published formulas in 80-bit floats (tests/vectors/analytic.py), and, with the
 * shared data, the presets against neural-process reconstructions of the same measurements.
 */
#include "io/io.h"
#include "math/math.h"
#include "support/check.h"
#include <nqm/brdf.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

static void test_published_formulas(void **state) {
    (void)state;
    nqm_csv *csv;
    assert_int_equal(nqm_csv_load(test_vector("analytic.csv"), &csv, NULL), NQM_OK);
    assert_true(nqm_csv_rows(csv) >= 490);
    for (size_t row = 0; row < nqm_csv_rows(csv); ++row) {
        nqm_brdf *brdf = open_brdf(nqm_csv_text(csv, row, 0));
        double v[9], rgb[3], swapped[3];
        uint8_t flag;
        for (int k = 0; k < 9; ++k)
            v[k] = csv_number(csv, row, k + 1);
        nqm_brdf_eval(brdf, 1, v, v + 3, rgb, &flag);
        nqm_brdf_eval(brdf, 1, v + 3, v, swapped, NULL);
        assert_int_equal(flag, NQM_VALUE_OK);
        for (int c = 0; c < 3; ++c) {
            assert_near(rgb[c], v[6 + c], 1e-10 * fabs(v[6 + c]) + 1e-15);
            assert_true(rgb[c] == swapped[c]);
        }
        nqm_brdf_free(brdf);
    }
    nqm_csv_free(csv);
}

/* Pairs with a direction below or on the horizon give zero and the flag NQM_VALUE_HORIZON. */
static void test_horizon(void **state) {
    (void)state;
    nqm_brdf *brdf = open_brdf("ggx:kd=.5;alpha=.1");
    const double up[3] = {0, 0, 1}, down[3] = {0, 0.6, -0.8}, level[3] = {1, 0, 0};
    const double *pairs[][2] = {{up, down}, {down, up}, {up, level}, {down, down}};
    for (size_t i = 0; i < 4; ++i) {
        double rgb[3] = {7, 7, 7};
        uint8_t flag;
        nqm_brdf_eval(brdf, 1, pairs[i][0], pairs[i][1], rgb, &flag);
        assert_int_equal(flag, NQM_VALUE_HORIZON);
        assert_true(rgb[0] == 0 && rgb[1] == 0 && rgb[2] == 0);
    }
    nqm_brdf_free(brdf);
}

/* ---- presets against another source of the same measurements ----------------------------------------------------- */

enum { N_PAIRS = 250 };

/* Pairs off the highlight (theta_h above 15 degrees), polar angles below 70 degrees. */
static void draw_off_specular(double *hd) {
    nqm_rng rng = nqm_rng_make(3, 0);
    for (size_t i = 0; i < N_PAIRS;) {
        double wi[3], wo[3], *p = hd + 3 * i;
        p[0] = NQM_PI / 12 + 5 * NQM_PI / 12 * nqm_rng_uniform(&rng);
        p[1] = NQM_PI / 2 * nqm_rng_uniform(&rng);
        p[2] = NQM_PI * nqm_rng_uniform(&rng);
        nqm_half_diff_to_pair(p, wi, wo);
        i += wi[2] > 0.342 && wo[2] > 0.342;
    }
}

/* Median of preset / reconstruction, per channel, and the median relative difference of all channels. */
static double compare_with_nps(const char *preset, const double *hd, double *ratio) {
    static double ours[3 * N_PAIRS], theirs[3 * N_PAIRS], sorted[N_PAIRS], difference[3 * N_PAIRS];
    char path[5000];
    const char *decoder = shared_data("nps/nps_decoder_f32le.bin");
    snprintf(path, sizeof path, "%s:%s", decoder, strchr(preset, ':') + 1);
    nqm_brdf *a = open_brdf(preset), *b = open_brdf(path);
    nqm_brdf_eval_half_diff(a, N_PAIRS, hd, ours, NULL);
    nqm_brdf_eval_half_diff(b, N_PAIRS, hd, theirs, NULL);
    nqm_brdf_free(a);
    nqm_brdf_free(b);
    for (size_t c = 0; c < 3; ++c) {
        for (size_t i = 0; i < N_PAIRS; ++i)
            sorted[i] = ours[3 * i + c] / theirs[3 * i + c];
        qsort(sorted, N_PAIRS, sizeof *sorted, nqm_compare_doubles);
        ratio[c] = sorted[N_PAIRS / 2];
    }
    for (size_t i = 0; i < 3 * N_PAIRS; ++i)
        difference[i] = fabs(ours[i] - theirs[i]) / theirs[i];
    qsort(difference, 3 * N_PAIRS, sizeof *difference, nqm_compare_doubles);
    return difference[3 * N_PAIRS / 2];
}

static void test_sgd_presets_are_the_measurements(void **state) {
    (void)state;
    if (!shared_data("nps/nps_decoder_f32le.bin"))
        skip();
    static const char *const matte[] = {
        "sgd:pink-felt",      "sgd:polyethylene",    "sgd:white-fabric", "sgd:yellow-paint",
        "sgd:dark-red-paint", "sgd:light-red-paint", "sgd:gray-plastic", "sgd:specular-white-phenolic",
        "sgd:white-marble",   "sgd:red-plastic",     "sgd:pearl-paint",  "sgd:alumina-oxide"};
    static double hd[3 * N_PAIRS];
    draw_off_specular(hd);
    for (size_t i = 0; i < sizeof matte / sizeof *matte; ++i) {
        double ratio[3], difference = compare_with_nps(matte[i], hd, ratio);
        print_message("%-30s ratio %.3f %.3f %.3f, median difference %.3f\n", matte[i], ratio[0], ratio[1], ratio[2],
                      difference);
        assert_true(difference < 0.08);
        for (int c = 0; c < 3; ++c)
            assert_near(ratio[c], 1, 0.1);
    }
}

/* Ngan's fits have MERL's colours only with the colour scale that presets/make.py applies; Low's have them as printed.
 * A missing constant factor (1 / pi, 1 / 4) would change the level (doc/brdf.md shows the peaks of the whole table). */
static void test_presets_have_the_colours(void **state) {
    (void)state;
    if (!shared_data("nps/nps_decoder_f32le.bin"))
        skip();
    static const char *const tables[] = {"ward",
                                         "ward-duer",
                                         "blinn-phong",
                                         "lafortune",
                                         "cook-torrance",
                                         "ashikhmin-shirley",
                                         "low-cook-torrance",
                                         "low-cook-torrance-e1",
                                         "abc",
                                         "smooth",
                                         "low-ashikhmin-shirley"};
    static const char *const matte[] = {"pink-felt", "pvc", "gray-plastic"};
    static double hd[3 * N_PAIRS];
    draw_off_specular(hd);
    for (size_t i = 0; i < 3 * (sizeof tables / sizeof *tables); ++i) {
        char preset[100];
        double ratio[3];
        snprintf(preset, sizeof preset, "%s:%s", tables[i / 3], matte[i % 3]);
        compare_with_nps(preset, hd, ratio);
        print_message("%-30s ratio %.3f %.3f %.3f\n", preset, ratio[0], ratio[1], ratio[2]);
        assert_near(ratio[0], 1, 0.25);
        assert_near(ratio[1] / ratio[0], 1, 0.12);
        assert_near(ratio[2] / ratio[0], 1, 0.12);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_published_formulas),
        cmocka_unit_test(test_horizon),
        cmocka_unit_test(test_sgd_presets_are_the_measurements),
        cmocka_unit_test(test_presets_have_the_colours),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
