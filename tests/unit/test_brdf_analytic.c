/* SPDX-License-Identifier: MIT
 *
 * The analytic models, and BRDFs made of anisotropic ones, against their formulas in 80-bit floats (tests/vectors/analytic.py);
 * equal widths; what turning does and does not change; with the shared data, the presets against neural-process
 * reconstructions of the same measurements.
 */
#include "brdf/brdf.h"
#include "io/io.h"
#include "math/math.h"
#include "support/check.h"
#include "support/rows.h"
#include <nqm/brdf.h>

TEST(test_published_formulas) {
    nqm_csv *csv;
    assert_int_equal(nqm_csv_load(test_vector("analytic.csv"), &csv, NULL), NQM_OK);
    assert_true(nqm_csv_rows(csv) >= 880);
    for (size_t row = 0; row < nqm_csv_rows(csv); ++row) {
        nqm_brdf *brdf = must_open(nqm_csv_text(csv, row, 0));
        const bool is_model = nqm_brdf_get_info(brdf).n_values > 0;
        double v[9], rgb[3], swapped[3];
        uint8_t flag;
        for (int k = 0; k < 9; ++k)
            v[k] = csv_number(csv, row, k + 1);
        nqm_brdf_eval(brdf, 1, v, v + 3, rgb, &flag);
        nqm_brdf_eval(brdf, 1, v + 3, v, swapped, NULL);
        assert_int_equal(flag, NQM_VALUE_OK);
        for (int c = 0; c < 3; ++c) {
            assert_near(rgb[c], v[6 + c], 1e-10 * fabs(v[6 + c]) + 1e-15);
            assert_true(!is_model || rgb[c] == swapped[c]);
        }
        nqm_brdf_free(brdf);
    }
    nqm_csv_free(csv);
}

/* ---- anisotropy -------------------------------------------------------------------------------------------------- */

enum { N_RANDOM = 300 };

static void draw_random_pairs(double *wi, double *wo) {
    nqm_rng rng = nqm_rng_make(5, 0);
    for (size_t i = 0; i < N_RANDOM;) {
        const double u = nqm_rng_uniform(&rng), angle = 2 * NQM_PI * nqm_rng_uniform(&rng);
        const double hd[3] = {1.5 * u * u, 1.5 * nqm_rng_uniform(&rng), NQM_PI * nqm_rng_uniform(&rng)};
        const double turn[2] = {sin(angle), cos(angle)};
        nqm_half_diff_to_pair(hd, wi + 3 * i, wo + 3 * i);
        nqm_turn3(turn, wi + 3 * i, wi + 3 * i);
        nqm_turn3(turn, wo + 3 * i, wo + 3 * i);
        i += wi[3 * i + 2] > 0.02 && wo[3 * i + 2] > 0.02;
    }
}

/* Compare two BRDFs at random pairs, and at half-vector coordinates; tolerance 0: to the bit. */
static void assert_same(const char *spec, const char *other, double tolerance) {
    static double wi[3 * N_RANDOM], wo[3 * N_RANDOM], values[2][6 * N_RANDOM];
    const char *const specs[] = {spec, other};
    draw_random_pairs(wi, wo);
    for (size_t k = 0; k < 2; ++k) {
        nqm_brdf *brdf = must_open(specs[k]);
        double hd[3 * N_RANDOM];
        for (size_t i = 0; i < N_RANDOM; ++i)
            nqm_half_diff_from_pair(wi + 3 * i, wo + 3 * i, hd + 3 * i);
        nqm_brdf_eval(brdf, N_RANDOM, wi, wo, values[k], NULL);
        nqm_brdf_eval_half_diff(brdf, N_RANDOM, hd, values[k] + 3 * N_RANDOM, NULL);
        nqm_brdf_free(brdf);
    }
    for (size_t i = 0; i < 6 * N_RANDOM; ++i)
        assert_near(values[0][i], values[1][i], tolerance * fabs(values[1][i]));
}

TEST(test_equal_widths) {
    assert_same("ggx:kd=.1;alpha=.123,.123;f0=.9", "ggx:kd=.1;alpha=.123;f0=.9", 0);
    assert_same("ward:ks=.3;alpha=.0123,.0123", "ward:ks=.3;alpha=.0123", 0);
    assert_same("ward-duer:ks=.3;alpha=.3,.3", "ward-duer:ks=.3;alpha=.3", 0);
    assert_same("ashikhmin-shirley:ks=.3;n=33.3,33.3;f0=.1", "ashikhmin-shirley:ks=.3;n=33.3;f0=.1", 0);
    assert_same("ggx:alpha=.3,.3000000000000001", "ggx:alpha=.3", 1e-13); /* the general path */
    assert_same("ward:ks=.3;alpha=.3,.3000000000000001", "ward:ks=.3;alpha=.3", 1e-12);
    assert_same("ashikhmin-shirley:ks=.3;n=33,33.00000000000001;f0=.1", "ashikhmin-shirley:ks=.3;n=33;f0=.1", 1e-13);
}

#define X "ggx:kd=.1;alpha=.1,.4"
#define Y "ggx:kd=.1;alpha=.4,.1"

TEST(test_turning) {
    assert_same("rotate:deg=77;of=sgd:nickel", "sgd:nickel", 0);
    assert_same("rotate:deg=77;of=perturb:gloss=.7;of=sgd:nickel", "perturb:gloss=.7;of=sgd:nickel", 0);
    assert_same("tilt:deg=0;azimuth=40;of=" X, X, 0);
    assert_same("rotate:deg=0;of=" X, X, 0);
    assert_same("rotate:deg=90;of=" X, Y, 1e-11);
    assert_same("rotate:deg=-90;of=" X, Y, 1e-11);
    assert_same("rotate:deg=20;of=rotate:deg=25;of=" X, "rotate:deg=45;of=" X, 1e-11);
    assert_same("rotate:deg=30;of=tilt:deg=10;azimuth=20;of=sgd:nickel", "tilt:deg=10;azimuth=50;of=sgd:nickel", 1e-9);
    assert_same("rotate:deg=30;of=perturb:gloss=.5;shift=3;peak=.5;noise=.2;of=" X,
                "perturb:gloss=.5;shift=3;peak=.5;noise=.2;of=rotate:deg=30;of=" X, 1e-9);
    assert_same("rotate:deg=30;of=perturb:smooth=5;lopsided=1;of=" X,
                "perturb:smooth=5;lopsided=1;of=rotate:deg=30;of=" X, 1e-9);
    assert_same("between:t=.3;log=1;with=(rotate:deg=30;of=" X ");of=rotate:deg=30;of=" Y,
                "rotate:deg=30;of=between:t=.3;log=1;with=(" X ");of=" Y, 1e-11);
}

TEST(test_facts) {
    EVERY_ROW(row, "isotropic or reciprocal") {
        nqm_brdf *brdf = must_open(row[0]);
        assert_int_equal(nqm_brdf_get_info(brdf).isotropic, atoi(row[1]));
        assert_int_equal(nqm_brdf_get_info(brdf).reciprocal, atoi(row[2]));
        assert_true((nqm_brdf_anisotropy(brdf) > 0) == !atoi(row[1]));
        nqm_brdf_free(brdf);
    }
}

/* What has no value stays without one. */
static void no_value(void *user, size_t n, const double *wi, const double *wo, double *rgb) {
    (void)user, (void)wi, (void)wo;
    for (size_t i = 0; i < 3 * n; ++i)
        rgb[i] = NAN;
}

TEST(test_missing_values) {
    static const char *const settings[][2] = {{"rotate:", "deg=30"}, {"tilt:", "deg=5"}, {"tilt:", "deg=0"}};
    nqm_brdf *empty, *brdf;
    const double hd[3] = {0.1, 0.7, 1}, up[3] = {0, 0, 1};
    assert_int_equal(nqm_brdf_create(&(nqm_brdf_callbacks){.eval = no_value}, &empty, NULL), NQM_OK);
    for (size_t i = 0; i < 3; ++i) {
        double rgb[3];
        uint8_t flag[2];
        const nqm_between_bases bases = {.of = empty};
        const nqm_spec_wrapper *wrapper = nqm_spec_wrapper_of(settings[i][0]);
        nqm_values values;
        assert_int_equal(nqm_wrapper_parse(wrapper, settings[i][1], &values, NULL), NQM_OK);
        assert_int_equal(nqm_wrapper_make(wrapper, &values, &bases, NULL, &brdf, NULL), NQM_OK);
        nqm_brdf_eval(brdf, 1, up, up, rgb, flag);
        nqm_brdf_eval_half_diff(brdf, 1, hd, rgb, flag + 1);
        assert_true(flag[0] == NQM_VALUE_INVALID && flag[1] == NQM_VALUE_INVALID);
        nqm_brdf_free(brdf);
    }
    nqm_brdf_free(empty);
}

/* Pairs with a direction below or on the horizon give zero and the flag NQM_VALUE_HORIZON. */
TEST(test_horizon) {
    nqm_brdf *brdf = must_open("ggx:kd=.5;alpha=.1");
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
    nqm_brdf *a = must_open(preset), *b = must_open(path);
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

TEST(test_sgd_presets_are_the_measurements) {
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
TEST(test_presets_have_the_colours) {
    if (!shared_data("nps/nps_decoder_f32le.bin"))
        skip();
    static const char *const matte[] = {"pink-felt", "pvc", "gray-plastic"};
    static double hd[3 * N_PAIRS];
    draw_off_specular(hd);
    size_t n;
    const table_row *tables = table_rows("tables of presets", &n);
    for (size_t i = 0; i < 3 * n; ++i) {
        char preset[100];
        double ratio[3];
        snprintf(preset, sizeof preset, "%s:%s", tables[i / 3][0], matte[i % 3]);
        compare_with_nps(preset, hd, ratio);
        print_message("%-30s ratio %.3f %.3f %.3f\n", preset, ratio[0], ratio[1], ratio[2]);
        assert_near(ratio[0], 1, 0.25);
        assert_near(ratio[1] / ratio[0], 1, 0.12);
        assert_near(ratio[2] / ratio[0], 1, 0.12);
    }
}
