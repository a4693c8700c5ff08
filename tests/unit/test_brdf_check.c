/* SPDX-License-Identifier: MIT
 *
 * Albedo and checks: against closed forms and scipy's adaptive quadrature (tests/vectors/analytic.py), for lobes much
 * narrower than a degree, and for made-up BRDFs with known asymmetry, negative values and gaps.
 */
#include "brdf/brdf.h"
#include "io/io.h"
#include "math/math.h"
#include "support/check.h"

static void albedo_of(const char *spec, double theta_deg, uint64_t seed, double *rgb) {
    nqm_brdf *brdf = must_open(spec);
    nqm_brdf_albedo(brdf, theta_deg * NQM_PI / 180, seed, rgb);
    nqm_brdf_free(brdf);
}

TEST(test_lambert_is_exact) {
    for (uint64_t seed = 0; seed < 20; ++seed)
        for (int theta = 0; theta <= 85; theta += 17) {
            double rgb[3];
            albedo_of("lambert:kd=0.2,0.5,0.9", theta, seed, rgb);
            assert_relative(rgb[0], 0.2, 1e-9);
            assert_relative(rgb[1], 0.5, 1e-9);
            assert_relative(rgb[2], 0.9, 1e-9);
        }
}

TEST(test_against_quadrature) {
    nqm_csv *csv;
    assert_int_equal(nqm_csv_load(test_vector("analytic_albedo.csv"), &csv, NULL), NQM_OK);
    assert_true(nqm_csv_rows(csv) == 13);
    for (size_t row = 0; row < nqm_csv_rows(csv); ++row) {
        double theta, expected;
        assert_int_equal(nqm_csv_number(csv, row, 1, &theta, NULL), NQM_OK);
        assert_int_equal(nqm_csv_number(csv, row, 2, &expected, NULL), NQM_OK);
        for (uint64_t seed = 1; seed < 6; ++seed) {
            double rgb[3];
            albedo_of(nqm_csv_text(csv, row, 0), theta, seed, rgb);
            assert_relative(rgb[1], expected, row < 8 ? 0.003 : 0.006); /* isotropic, anisotropic */
        }
    }
    nqm_csv_free(csv);
}

/* Toward alpha = 0 a GGX lobe with f0 = 1 becomes a mirror. The narrowest is 0.006 degrees wide. */
TEST(test_sharpest_lobes) {
    static const char *const specs[] = {"ggx:f0=1;alpha=0.0001", "ggx:f0=1;alpha=0.0007", "ggx:f0=1;alpha=0.003",
                                        "ggx:f0=1;alpha=0.01"};
    for (size_t i = 0; i < sizeof specs / sizeof *specs; ++i)
        for (int theta = 0; theta <= 75; theta += 25) {
            double rgb[3];
            albedo_of(specs[i], theta, 1, rgb);
            assert_near(rgb[0], 1, 0.004);
        }
}

/* The BRDF `user`, without values where the viewer is below 60 degrees. */
static void lose_grazing(void *user, size_t n, const double *wi, const double *wo, double *rgb) {
    nqm_brdf_eval(user, n, wi, wo, rgb, NULL);
    for (size_t i = 0; i < n; ++i)
        if (wo[3 * i + 2] < 0.5)
            rgb[3 * i] = NAN;
}

static void check_of(nqm_brdf *brdf, uint64_t seed, nqm_brdf_check_report *report) {
    nqm_error err = {0};
    assert_int_equal(nqm_brdf_check(brdf, seed, report, &err), NQM_OK);
}

TEST(test_plausible_brdf) {
    nqm_brdf *brdf = must_open("ggx:kd=.3,.2,.1;ks=1;alpha=.05;f0=.04");
    nqm_brdf_check_report a, b;
    check_of(brdf, 1, &a);
    check_of(brdf, 1, &b);
    assert_memory_equal(&a, &b, sizeof a);
    assert_true(a.n_pairs >= 4096);
    assert_true(a.n_clamped == 0 && a.n_invalid == 0);
    assert_true(a.reciprocity_p95 == 0);
    assert_true(a.albedo_max[0] < 1 && a.albedo_max[0] > a.albedo_max[1] && a.albedo_max[1] > a.albedo_max[2]);
    assert_near(a.albedo_max_theta_rad, 75 * NQM_PI / 180, 1e-12); /* Fresnel */
    nqm_brdf_free(brdf);
}

/* ---- made-up BRDFs ----------------------------------------------------------------------------------------------- */

static nqm_brdf *wrap(const nqm_brdf_class *class_) {
    nqm_brdf *brdf;
    assert_int_equal(nqm_brdf_wrap(class_, NULL, &(nqm_brdf_info){.name = "made up"}, &brdf, NULL), NQM_OK);
    return brdf;
}

/* Exchanging light and viewer multiplies the value by 3 or 1/3: the difference over the mean is exactly 1. */
static void eval_one_sided(const void *self, size_t n, const double *wi, const double *wo, double *rgb) {
    (void)self;
    for (size_t i = 0; i < n; ++i)
        rgb[3 * i] = rgb[3 * i + 1] = rgb[3 * i + 2] = wi[3 * i + 2] > wo[3 * i + 2] ? 0.3 : 0.1;
}

TEST(test_asymmetry_is_measured) {
    static const nqm_brdf_class one_sided = {.format = "test", .eval = eval_one_sided, .free = free_nothing};
    nqm_brdf *brdf = wrap(&one_sided);
    nqm_brdf_check_report r;
    check_of(brdf, 1, &r);
    assert_near(r.reciprocity_median, 1, 1e-12);
    assert_near(r.reciprocity_p95, 1, 1e-12);
    nqm_brdf_free(brdf);
}

/* Red is negative for a high light; a low viewer has no value. Every pair counts as at most one fault. */
static void eval_faulty(const void *self, size_t n, const double *wi, const double *wo, double *rgb) {
    (void)self;
    for (size_t i = 0; i < n; ++i) {
        rgb[3 * i] = wo[3 * i + 2] < 0.2 ? (double)NAN : wi[3 * i + 2] > 0.8 ? -0.1 : 0.1;
        rgb[3 * i + 1] = rgb[3 * i + 2] = 1;
    }
}

TEST(test_faults_are_counted) {
    static const nqm_brdf_class faulty = {.format = "test", .eval = eval_faulty, .free = free_nothing};
    nqm_brdf *brdf = wrap(&faulty);
    nqm_brdf_check_report r;
    check_of(brdf, 3, &r);
    assert_true(r.n_clamped > 0 && r.n_invalid > 0);
    assert_true(r.n_clamped + r.n_invalid < r.n_pairs);
    assert_true(r.albedo_max[1] > 1.02); /* the albedo of f_r = 1 / sr is pi */
    assert_near(r.albedo_max[1], NQM_PI * (1 - 0.2 * 0.2), 0.01);
    nqm_brdf_free(brdf);
}

static void eval_black(const void *self, size_t n, const double *wi, const double *wo, double *rgb) {
    (void)self;
    (void)wi;
    (void)wo;
    memset(rgb, 0, 3 * n * sizeof *rgb);
}

TEST(test_black) {
    static const nqm_brdf_class black = {.format = "test", .eval = eval_black, .free = free_nothing};
    nqm_brdf *brdf = wrap(&black);
    nqm_brdf_check_report r;
    check_of(brdf, 1, &r);
    assert_true(r.reciprocity_median == 0 && r.reciprocity_p95 == 0);
    assert_true(r.albedo_max[0] == 0 && r.albedo_max[1] == 0 && r.albedo_max[2] == 0);
    nqm_brdf_free(brdf);
}

TEST(test_largest_difference) {
    nqm_brdf_difference d;
    nqm_error err = {0};
    nqm_brdf *ref = must_open("ggx:kd=.3,.2,.1;ks=1;alpha=.05;f0=.04"), *brighter, *hole;
    brighter = must_open("perturb:scale=1.25;of=ggx:kd=.3,.2,.1;ks=1;alpha=.05;f0=.04");
    const nqm_brdf_callbacks nothing = {.eval = lose_grazing, .user = ref};
    assert_int_equal(nqm_brdf_create(&nothing, &hole, &err), NQM_OK);
    assert_int_equal(nqm_brdf_compare(ref, ref, 0, 1, &d, &err), NQM_OK);
    assert_true(d.is_equal && d.n_pairs == 8192 && d.largest <= 0);
    assert_int_equal(nqm_brdf_compare(ref, brighter, 0.1, 1, &d, &err), NQM_OK);
    assert_true(!d.is_equal && d.n_different == 8192 && d.n_missing == 0);
    assert_relative(d.largest, 0.2, 1e-12);
    assert_relative(d.test, 1.25 * d.ref, 1e-12);
    double rgb[3];
    nqm_brdf_eval(ref, 1, d.wi, d.wo, rgb, NULL);
    assert_near(rgb[d.channel], d.ref, 0);
    assert_int_equal(nqm_brdf_compare(ref, brighter, 0.201, 1, &d, &err), NQM_OK);
    assert_true(d.is_equal);
    assert_int_equal(nqm_brdf_compare(ref, hole, 0.1, 1, &d, &err), NQM_OK);
    assert_true(!d.is_equal && d.n_different == 0 && d.n_missing > 0 && d.n_missing < d.n_pairs);
    assert_int_equal(nqm_brdf_compare(ref, brighter, -1, 1, &d, &err), NQM_ERR_ARG);
    nqm_brdf_free(hole);
    nqm_brdf_free(brighter);
    nqm_brdf_free(ref);
}
