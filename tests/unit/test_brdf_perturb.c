/* SPDX-License-Identifier: MIT
 *
 * Perturbations against the definitions in doc/brdf.md, computed here from the base independently; reciprocity,
 * finiteness and limits of all settings.
 */
#include "brdf/brdf.h"
#include "math/math.h"
#include "support/brdf_files.h"
#include "support/check.h"
#include "support/rows.h"

static const double degree = NQM_PI / 180;
static const char glossy[] = "ggx:kd=.2,.1,.05;ks=1;alpha=.05;f0=.5,.4,.3";

/* The value at (theta_h, theta_d, phi_d) in degrees. */
static void value_at(const char *spec, double theta_h, double theta_d, double phi_d, double *rgb) {
    nqm_brdf *brdf = must_open(spec);
    const double hd[3] = {theta_h * degree, theta_d * degree, phi_d * degree};
    nqm_brdf_eval_half_diff(brdf, 1, hd, rgb, NULL);
    nqm_brdf_free(brdf);
}

/* The value of "perturb:SETTINGS;of=BASE" at `place`, in degrees. */
static void perturbed_at(const char *settings, const char *base, const double *place, double *rgb) {
    char spec[512];
    snprintf(spec, sizeof spec, "perturb:%s;of=%s", settings, base);
    value_at(spec, place[0], place[1], place[2], rgb);
}

static const double places[][3] = {{0, 0, 0}, {0.5, 10, 20}, {3, 30, 90}, {12, 60, 45}, {35, 20, 130}, {5, 80, 90}};
enum { N_PLACES = sizeof places / sizeof *places };

TEST(test_colour_settings) {
    for (size_t i = 0; i < N_PLACES; ++i) {
        double base[3], rgb[3];
        value_at(glossy, places[i][0], places[i][1], places[i][2], base);
        perturbed_at("scale=2.5", glossy, places[i], rgb);
        for (int c = 0; c < 3; ++c)
            assert_relative(rgb[c], 2.5 * base[c], 1e-15);
        perturbed_at("tint=1.5,1,.25", glossy, places[i], rgb);
        assert_relative(rgb[0], 1.5 * base[0], 1e-15);
        assert_relative(rgb[1], base[1], 1e-15);
        assert_relative(rgb[2], 0.25 * base[2], 1e-15);
        double grey = 0.2126 * base[0] + 0.7152 * base[1] + 0.0722 * base[2];
        perturbed_at("desaturate=1", glossy, places[i], rgb);
        for (int c = 0; c < 3; ++c)
            assert_relative(rgb[c], grey, 1e-14);
        perturbed_at("desaturate=.25", glossy, places[i], rgb);
        for (int c = 0; c < 3; ++c)
            assert_relative(rgb[c], 0.75 * base[c] + 0.25 * grey, 1e-14);
    }
}

/* theta_h in degrees at which the lobe above the diffuse level kd / pi falls to half its height. */
static double half_width(const char *spec) {
    double top[3], rgb[3], from = 0, to = 30;
    const double floor_value = 0.1 / NQM_PI;
    value_at(spec, 0, 20, 90, top);
    for (int i = 0; i < 50; ++i) {
        double mid = 0.5 * (from + to);
        value_at(spec, mid, 20, 90, rgb);
        if (rgb[1] - floor_value > 0.5 * (top[1] - floor_value))
            from = mid;
        else
            to = mid;
    }
    return from;
}

TEST(test_gloss_scales_the_width) {
    char spec[256];
    double width = half_width(glossy);
    static const double gloss[] = {0.5, 0.8, 1.25, 2, 4};
    for (size_t i = 0; i < sizeof gloss / sizeof *gloss; ++i) {
        snprintf(spec, sizeof spec, "perturb:gloss=%g;of=%s", gloss[i], glossy);
        assert_relative(half_width(spec), width / gloss[i], 0.05); /* the map is linear only near 0 */
    }
    double top[3], rgb[3];
    value_at(glossy, 0, 20, 90, top);
    perturbed_at("gloss=3", glossy, (const double[3]){0, 20, 90}, rgb);
    assert_memory_equal(top, rgb, sizeof top); /* the height is unchanged */
}

TEST(test_shift_moves_the_lobe) {
    double base[3], rgb[3];
    perturbed_at("shift=4", glossy, (const double[3]){4, 20, 90}, rgb);
    value_at(glossy, 0, 20, 90, base);
    assert_relative(rgb[1], base[1], 1e-12);
    perturbed_at("shift=4", glossy, (const double[3]){1, 20, 90}, rgb);
    value_at(glossy, 3, 20, 90, base);
    assert_relative(rgb[1], base[1], 1e-9);
    perturbed_at("shift=-2", glossy, (const double[3]){1, 20, 90}, rgb);
    assert_relative(rgb[1], base[1], 1e-9);
}

TEST(test_peak_and_fresnel) {
    double base[3], off[3], rgb[3];
    const double place[3] = {1, 40, 90}; /* light and viewer reach the horizon at theta_h = 90 degrees */
    value_at(glossy, 1, 40, 90, base);
    value_at(glossy, 63, 40, 90, off);
    perturbed_at("peak=3", glossy, place, rgb);
    for (int c = 0; c < 3; ++c)
        assert_relative(rgb[c], off[c] + 3 * (base[c] - off[c]), 1e-12);
    perturbed_at("peak=0", glossy, place, rgb);
    for (int c = 0; c < 3; ++c)
        assert_relative(rgb[c], off[c], 1e-9);
    perturbed_at("peak=5", "lambert:kd=.3", place, rgb); /* lambert has no lobe to scale */
    assert_relative(rgb[0], 0.3 / NQM_PI, 1e-14);
    for (int theta_d = 0; theta_d <= 80; theta_d += 20) {
        const double where[3] = {2, theta_d, 90};
        value_at(glossy, 2, theta_d, 90, base);
        perturbed_at("fresnel=4", glossy, where, rgb);
        assert_relative(rgb[2], base[2] * (1 + 3 * pow(1 - cos(theta_d * degree), 5)), 1e-13);
    }
}

TEST(test_mix_keeps_the_albedo) {
    double base[3], rgb[3], half[3];
    nqm_brdf *brdf = must_open(glossy);
    nqm_brdf_albedo(brdf, 45 * degree, 1, base);
    nqm_brdf_free(brdf);
    perturbed_at("mix=1", glossy, places[3], rgb);
    for (int c = 0; c < 3; ++c)
        assert_relative(rgb[c], base[c] / NQM_PI, 1e-12);
    perturbed_at("mix=.5", glossy, places[1], half);
    value_at(glossy, places[1][0], places[1][1], places[1][2], base);
    for (int c = 0; c < 3; ++c)
        assert_relative(half[c], 0.5 * (rgb[c] + base[c]), 1e-12);
}

TEST(test_quantise) {
    for (size_t i = 0; i < N_PLACES; ++i) {
        double base[3], rgb[3];
        value_at(glossy, places[i][0], places[i][1], places[i][2], base);
        perturbed_at("quantise=4", glossy, places[i], rgb);
        for (int c = 0; c < 3; ++c) {
            double steps = 4 * log10(rgb[c]);
            assert_near(steps, nearbyint(steps), 1e-9);
            assert_near(log10(rgb[c]), log10(base[c]), 0.125 + 1e-12);
        }
    }
    double rgb[3];
    perturbed_at("quantise=4", "lambert:kd=0", places[1], rgb);
    assert_true(rgb[0] == 0);
}

TEST(test_rounding) {
    for (size_t i = 0; i < N_PLACES; ++i) {
        double base[3], rgb[3];
        value_at(glossy, places[i][0], places[i][1], places[i][2], base);
        perturbed_at("bits=24", glossy, places[i], rgb);
        for (int c = 0; c < 3; ++c)
            assert_true(rgb[c] == (double)(float)base[c]);
        perturbed_at("bits=3", glossy, places[i], rgb);
        for (int c = 0; c < 3; ++c) {
            int exponent;
            double eighths = 8 * frexp(rgb[c], &exponent);
            assert_true(eighths == nearbyint(eighths));
            assert_relative(rgb[c], base[c], 1.0 / 8);
        }
        perturbed_at("half=1", glossy, places[i], rgb);
        for (int c = 0; c < 3; ++c)
            assert_relative(rgb[c], base[c], 1.0 / 2048);
    }
    double rgb[3];
    perturbed_at("bits=53", "lambert:kd=.3", places[1], rgb);
    assert_true(rgb[0] == 0.3 / NQM_PI);
    perturbed_at("half=1;scale=1000", "perturb:scale=1000;of=lambert:kd=1", places[1], rgb);
    assert_true(rgb[0] == 65504); /* the largest number */
    perturbed_at("half=1;scale=1e-7", "lambert:kd=1", places[1], rgb);
    assert_true(rgb[0] == ldexp(1, -24)); /* the smallest */
    perturbed_at("half=1;bits=5", "lambert:kd=0", places[1], rgb);
    assert_true(rgb[0] == 0);
}

/* No channel exceeds the given fraction of the maximum over mirror directions, at theta_d = 60 degrees for this
 * lobe. */
TEST(test_clamp) {
    double top[3];
    value_at(glossy, 0, 60, 0, top);
    for (size_t i = 0; i < N_PLACES; ++i) {
        double base[3], rgb[3];
        value_at(glossy, places[i][0], places[i][1], places[i][2], base);
        perturbed_at("clamp=.02", glossy, places[i], rgb);
        for (int c = 0; c < 3; ++c)
            assert_relative(rgb[c], fmin(base[c], 0.02 * top[0]), 1e-12);
    }
    double rgb[3];
    perturbed_at("clamp=.1", "lambert:kd=0", places[0], rgb);
    assert_true(rgb[0] == 0);
    perturbed_at("clamp=.1", "lambert:kd=.5,.1,.01", places[2], rgb);
    assert_relative(rgb[0], 0.05 / NQM_PI, 1e-12);
    assert_relative(rgb[2], 0.01 / NQM_PI, 1e-12);
}

TEST(test_ripple) {
    double base[3], rgb[3];
    for (size_t i = 0; i < N_PLACES; ++i) {
        value_at(glossy, places[i][0], places[i][1], places[i][2], base);
        perturbed_at("ripple=.4;bands=5", glossy, places[i], rgb);
        double wave = 1 + 0.4 * sin(10 * NQM_PI * sqrt(places[i][0] / 90));
        for (int c = 0; c < 3; ++c)
            assert_relative(rgb[c], base[c] * wave, 1e-12);
    }
}

/* A rotation by 120 degrees permutes the channels; any rotation preserves the sum, the distance from grey, and
 * greys. */
TEST(test_hue) {
    static const char base[] = "lambert:kd=.5,.4,.3", grey[] = "lambert:kd=.3";
    double rgb[3];
    perturbed_at("hue=120", base, places[1], rgb);
    assert_relative(rgb[0], 0.3 / NQM_PI, 1e-12);
    assert_relative(rgb[1], 0.5 / NQM_PI, 1e-12);
    assert_relative(rgb[2], 0.4 / NQM_PI, 1e-12);
    for (int turn = -170; turn <= 180; turn += 25) {
        char settings[32];
        snprintf(settings, sizeof settings, "hue=%d", turn);
        perturbed_at(settings, base, places[1], rgb);
        assert_relative(rgb[0] + rgb[1] + rgb[2], 1.2 / NQM_PI, 1e-12);
        double squares = 0;
        for (int c = 0; c < 3; ++c)
            squares += pow(rgb[c] * NQM_PI - 0.4, 2);
        assert_relative(squares, 0.02, 1e-9);
        perturbed_at(settings, grey, places[1], rgb);
        for (int c = 0; c < 3; ++c)
            assert_relative(rgb[c], 0.3 / NQM_PI, 1e-12);
    }
    perturbed_at("hue=180", "lambert:kd=.5,0,0", places[1], rgb);
    assert_true(rgb[0] == 0 && rgb[1] > 0.3 / NQM_PI);
}

/* The Gaussian mean over the plane of half vectors by brute force: (x, y) = theta_h (cos, sin), 400 x 400 points. */
static double blur(const char *spec, double centre_deg, double sigma_deg) {
    enum { N = 400 };
    nqm_brdf *brdf = must_open(spec);
    double sum = 0, weights = 0;
    for (int i = 0; i < N; ++i)
        for (int j = 0; j < N; ++j) {
            double x = 10 * ((i + 0.5) / N - 0.5) * sigma_deg, y = 10 * ((j + 0.5) / N - 0.5) * sigma_deg;
            double w = exp(-(x * x + y * y) / (2 * sigma_deg * sigma_deg)), rgb[3];
            const double hd[3] = {hypot(centre_deg + x, y) * degree, 20 * degree, 90 * degree};
            nqm_brdf_eval_half_diff(brdf, 1, hd, rgb, NULL);
            sum += w * rgb[1];
            weights += w;
        }
    nqm_brdf_free(brdf);
    return sum / weights;
}

TEST(test_smooth_is_a_blur) {
    static const double centres[] = {0, 1, 3, 8};
    for (size_t i = 0; i < sizeof centres / sizeof *centres; ++i) {
        double rgb[3];
        const double place[3] = {centres[i], 20, 90};
        perturbed_at("smooth=2", glossy, place, rgb);
        assert_relative(rgb[1], blur(glossy, centres[i], 2), 0.003);
        perturbed_at("smooth=2", "ggx:kd=.1;f0=1;alpha=.01", place, rgb); /* a lobe much narrower than the blur */
        assert_relative(rgb[1], blur("ggx:kd=.1;f0=1;alpha=.01", centres[i], 2), 0.01);
        perturbed_at("smooth=2", "lambert:kd=.4", place, rgb);
        assert_relative(rgb[1], 0.4 / NQM_PI, 1e-12);
    }
}

static void random_place(nqm_rng *rng, double *hd) {
    double wi[3], wo[3];
    do {
        double u = nqm_rng_uniform(rng);
        hd[0] = 90 * degree * u * u;
        hd[1] = 90 * degree * nqm_rng_uniform(rng);
        hd[2] = NQM_PI * nqm_rng_uniform(rng);
        nqm_half_diff_to_pair(hd, wi, wo);
    } while (wi[2] < 0.02 || wo[2] < 0.02);
}

static void log_noise(const char *spec, size_t n, double *z) {
    nqm_brdf *brdf = must_open(spec);
    nqm_rng rng = nqm_rng_make(9, 0);
    for (size_t i = 0; i < n; ++i) {
        double hd[3], rgb[3];
        random_place(&rng, hd);
        nqm_brdf_eval_half_diff(brdf, 1, hd, rgb, NULL);
        for (size_t c = 0; c < 3; ++c)
            z[3 * i + c] = log(rgb[c] * NQM_PI);
    }
    nqm_brdf_free(brdf);
}

/* The noise in log f_r has mean 0 and deviation sigma, is proportional to sigma, and differs between seeds and
 * channels. */
TEST(test_noise) {
    enum { N = 4000 };
    static double a[3 * N], b[3 * N], other[3 * N];
    log_noise("perturb:noise=.1;seed=4;cells=24;of=lambert:kd=1", N, a);
    log_noise("perturb:noise=.3;seed=4;cells=24;of=lambert:kd=1", N, b);
    log_noise("perturb:noise=.1;seed=5;cells=24;of=lambert:kd=1", N, other);
    double sum = 0, squares = 0, with_other = 0, between_channels = 0;
    for (size_t i = 0; i < 3 * N; ++i) {
        assert_near(b[i], 3 * a[i], 1e-9);
        sum += a[i] / (3 * N);
        squares += a[i] * a[i] / (3 * N);
        with_other += a[i] * other[i] / (3 * N);
        between_channels += i % 3 ? a[i] * a[i - 1] / (2 * N) : 0;
    }
    assert_near(sum, 0, 0.01);
    assert_relative(sqrt(squares), 0.1, 0.05);
    assert_near(with_other / squares, 0, 0.1);
    assert_near(between_channels / squares, 0, 0.1);
}

/* The noise is continuous, also where phi_d wraps and where phi_d is undefined. */
TEST(test_noise_is_continuous) {
    nqm_brdf *brdf = must_open("perturb:noise=.5;of=lambert:kd=1");
    static const double pairs[][2][3] = {{{0.3, 0.7, 1e-6}, {0.3, 0.7, NQM_PI - 1e-6}},
                                         {{1e-9, 0.7, 0.2}, {1e-9, 0.7, 2}},
                                         {{0.4, 1e-9, 0.2}, {0.4, 1e-9, 2}}};
    for (size_t i = 0; i < sizeof pairs / sizeof *pairs; ++i) {
        double rgb[6];
        nqm_brdf_eval_half_diff(brdf, 2, pairs[i][0], rgb, NULL);
        for (int c = 0; c < 3; ++c)
            assert_relative(rgb[c], rgb[3 + c], 1e-3);
    }
    nqm_brdf_free(brdf);
}

/* Every pair above the horizon has a finite, non-negative value, which is the same when light and viewer are
 * exchanged. */
TEST(test_all_settings_are_sane) {
    const uint64_t seed = 12;
    print_message("seed %d\n", (int)seed);
    uint64_t s = 0;
    EVERY_ROW(row, "settings of perturb") {
        char spec[512];
        snprintf(spec, sizeof spec, "perturb:%s;of=ward:kd=.2;ks=.3,.2,.1;alpha=.02", row[0]);
        nqm_brdf *brdf = must_open(spec);
        nqm_rng rng = nqm_rng_make(seed, s++);
        assert_int_equal(nqm_brdf_get_info(brdf).reciprocal, 1);
        for (int i = 0; i < 500; ++i) {
            double hd[3], wi[3], wo[3], rgb[3], swapped[3];
            uint8_t flag;
            random_place(&rng, hd);
            nqm_half_diff_to_pair(hd, wi, wo);
            nqm_brdf_eval(brdf, 1, wi, wo, rgb, &flag);
            nqm_brdf_eval(brdf, 1, wo, wi, swapped, NULL);
            assert_int_equal(flag, NQM_VALUE_OK);
            for (int c = 0; c < 3; ++c) {
                assert_true(isfinite(rgb[c]) && rgb[c] >= 0);
                if (!strstr(row[0], "quantise") && !strstr(row[0], "bits") &&
                    !strstr(row[0], "half")) /* rounding may change the step */
                    assert_near(swapped[c], rgb[c], 1e-6 * rgb[c]);
            }
        }
        nqm_brdf_free(brdf);
    }
}

/* Ratio of two BRDFs at random pairs, in both orders of light and viewer, against the expected one of a setting. */
static void check_ratio(const char *settings, const char *base, double (*expected)(const double *hd, double x),
                        double x) {
    char spec[512];
    snprintf(spec, sizeof spec, "perturb:%s;of=%s", settings, base);
    nqm_brdf *plain = must_open(base), *changed = must_open(spec);
    nqm_rng rng = nqm_rng_make(14, 0);
    for (int i = 0; i < 500; ++i) {
        double hd[3], wi[3], wo[3], rgb[2][3];
        random_place(&rng, hd);
        for (int order = 0; order < 2; ++order, hd[2] += NQM_PI) {
            nqm_half_diff_to_pair(hd, wi, wo);
            nqm_brdf_eval(plain, 1, wi, wo, rgb[0], NULL);
            nqm_brdf_eval(changed, 1, wi, wo, rgb[1], NULL);
            for (int c = 0; c < 3; ++c)
                assert_relative(rgb[1][c], rgb[0][c] * expected(hd, x), 1e-6);
        }
    }
    nqm_brdf_free(plain);
    nqm_brdf_free(changed);
}

static double constant(const double *hd, double x) {
    (void)hd;
    return x;
}

static double by_azimuth(const double *hd, double x) {
    return exp(x * sin(hd[2]));
}

static double by_theta_d(const double *hd, double x) {
    return 1 + (x - 1) * pow(1 - cos(hd[1]), 5);
}

/* Settings that do not move directions keep the order of light and viewer of a base that is not reciprocal. */
TEST(test_order_of_light_and_viewer) {
    static const char *const bases[] = {
        "gltf:base_color=.8,.3,.1;metallic=0;roughness=.5;clearcoat=1;clearcoat_roughness=.3",
        "standard-surface:coat=1;coat_roughness=.2;specular_roughness=.4",
        "between:t=.5;with=(lambert:kd=.1);of=gltf:clearcoat=1;clearcoat_roughness=.3"};
    for (size_t i = 0; i < sizeof bases / sizeof *bases; ++i) {
        static const char *const same[] = {
            "scale=1", "tint=1",       "gloss=1",  "shift=0", "peak=1",     "fresnel=1", "mix=0",      "clamp=0",
            "hue=0",   "desaturate=0", "ripple=0", "noise=0", "lopsided=0", "half=0",    "quantise=0", "bits=53"};
        for (size_t s = 0; s < sizeof same / sizeof *same; ++s)
            check_ratio(same[s], bases[i], constant, 1);
        check_ratio("scale=1.5", bases[i], constant, 1.5);
        check_ratio("tint=1.5", bases[i], constant, 1.5);
        check_ratio("fresnel=3", bases[i], by_theta_d, 3);
        check_ratio("lopsided=.2", bases[i], by_azimuth, 0.2);
        check_ratio("lopsided=-.3", bases[i], by_azimuth, -0.3);
        nqm_brdf *brdf = must_open(bases[i]);
        assert_int_equal(nqm_brdf_get_info(brdf).reciprocal, 0);
        nqm_brdf_free(brdf);
    }
    check_ratio("lopsided=.2", glossy, by_azimuth, 0.2);
    nqm_brdf *brdf = must_open("perturb:lopsided=.2;of=lambert:kd=.5");
    assert_int_equal(nqm_brdf_get_info(brdf).reciprocal, 0);
    nqm_brdf_free(brdf);
}

/* The result does not depend on the order of the pairs or on the batch size. */
TEST(test_batches) {
    enum { N = 1000 };
    static double hd[3 * N], together[3 * N];
    nqm_brdf *brdf = must_open("perturb:smooth=2;noise=.3;peak=2;of=ward:kd=.1;ks=.1;alpha=.1");
    nqm_rng rng = nqm_rng_make(2, 0);
    for (size_t i = 0; i < N; ++i)
        random_place(&rng, hd + 3 * i);
    nqm_brdf_eval_half_diff(brdf, N, hd, together, NULL);
    for (size_t i = 0; i < N; ++i) {
        double rgb[3];
        nqm_brdf_eval_half_diff(brdf, 1, hd + 3 * i, rgb, NULL);
        assert_memory_equal(rgb, together + 3 * i, sizeof rgb);
    }
    nqm_brdf_free(brdf);
}

TEST(test_nesting) {
    double base[3], rgb[3];
    value_at("lambert:kd=.5", 1, 10, 0, base);
    value_at("perturb:scale=2;of=perturb:tint=1,.5,1;of=lambert:kd=.5", 1, 10, 0, rgb);
    assert_relative(rgb[0], 2 * base[0], 1e-15);
    assert_relative(rgb[1], base[1], 1e-15);
    nqm_brdf *brdf;
    nqm_error err = {0};
    assert_int_equal(nqm_brdf_open("perturb:scale=2;of=perturb:scale=2;of=perturb:scale=2;of=perturb:scale=2;of="
                                   "lambert:kd=.5",
                                   &brdf, &err),
                     NQM_ERR_LIMIT);
    assert_null(brdf);
    assert_int_equal(nqm_brdf_open("perturb:scale=2;of=/nowhere/x.binary", &brdf, &err), NQM_ERR_IO);
    assert_null(brdf);
}

/* Where the base has no value, the result has none; `smooth` averages the neighbours with a value. The table has no
 * value where the sum of its theta_h and theta_d cell indices exceeds a limit. */
TEST(test_gaps_of_the_base) {
    char spec[4096];
    const char *path = scratch_path("gaps.binary");
    blob_put(make_merl(), path);
    nqm_brdf *base = must_open(path);
    snprintf(spec, sizeof spec, "perturb:scale=2;of=%s", path);
    nqm_brdf *scaled = must_open(spec);
    snprintf(spec, sizeof spec, "perturb:smooth=10;of=%s", path);
    nqm_brdf *smooth = must_open(spec);
    size_t n_gaps = 0, n_bridged = 0;
    for (int theta_h = 1; theta_h < 80; ++theta_h) {
        const double hd[3] = {theta_h * degree, 45 * degree, 90 * degree};
        double rgb[9];
        uint8_t flag[3];
        nqm_brdf_eval_half_diff(base, 1, hd, rgb, flag);
        nqm_brdf_eval_half_diff(scaled, 1, hd, rgb + 3, flag + 1);
        nqm_brdf_eval_half_diff(smooth, 1, hd, rgb + 6, flag + 2);
        assert_int_equal(flag[0], flag[1]);
        for (int c = 0; c < 3; ++c)
            assert_relative(rgb[3 + c], 2 * rgb[c], 1e-14);
        n_gaps += flag[0] == NQM_VALUE_INVALID;
        n_bridged += flag[0] == NQM_VALUE_INVALID && flag[2] == NQM_VALUE_OK && rgb[6] > 0;
    }
    assert_true(n_gaps > 10 && n_bridged > 5 && n_bridged < n_gaps);
    nqm_brdf_free(base);
    nqm_brdf_free(scaled);
    nqm_brdf_free(smooth);
}
