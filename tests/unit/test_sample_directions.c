/* SPDX-License-Identifier: MIT
 *
 * Direction sets: bounds, density, seeds, the influence of references, identity by SHA-256, CSV round trip and
 * refusals.
 */
#include "brdf/brdf.h"
#include "io/io.h"
#include "math/math.h"
#include "sample/sample.h"
#include "support/allocations.h"
#include "support/check.h"
#include "support/scratch.h"

#include <pthread.h>

static nqm_directions *create(const nqm_directions_options *options, size_t n_refs, const nqm_brdf *const *refs) {
    nqm_directions *directions;
    nqm_error err = {0};
    if (nqm_directions_create(options, n_refs, refs, &directions, &err) != NQM_OK)
        fail_msg("%s", err.message);
    return directions;
}

TEST(test_default_set) {
    nqm_directions *directions = create(NULL, 0, NULL);
    assert_int_equal(nqm_directions_get_info(directions).n, 500);
    const double *degrees = nqm_directions_get_info(directions).degrees;
    double mean_theta_d = 0, mean_phi_d = 0;
    size_t n_near_normal = 0;
    for (size_t i = 0; i < 500; ++i) {
        double hd[3], wi[3], wo[3];
        for (size_t k = 0; k < 3; ++k)
            hd[k] = degrees[3 * i + k] * (NQM_PI / 180);
        nqm_half_diff_to_pair(hd, wi, wo);
        assert_true(acos(wi[2]) <= 75 * (NQM_PI / 180) + 1e-12);
        assert_true(acos(wo[2]) <= 75 * (NQM_PI / 180) + 1e-12);
        assert_true(degrees[3 * i + 2] >= 0 && degrees[3 * i + 2] < 180);
        assert_true(i == 0 || degrees[3 * i] >= degrees[3 * i - 3]);
        mean_theta_d += degrees[3 * i + 1] / 500;
        mean_phi_d += degrees[3 * i + 2] / 500;
        n_near_normal += degrees[3 * i] < 3;
    }
    assert_near(mean_phi_d, 90, 3);
    assert_true(mean_theta_d > 25 && mean_theta_d < 37.5);
    /* theta_h = 75 u^2 puts at least sqrt(3/75) = 20 % below 3 degrees, more because large angles are rejected */
    assert_true(n_near_normal > 100);
    nqm_directions_free(directions);
}

/* At small angles nothing is rejected, so u = sqrt(theta_h / max) must be uniform: Kolmogorov-Smirnov distance. */
TEST(test_theta_h_density) {
    nqm_directions_options options = nqm_directions_options_default();
    options.n = 2000;
    options.theta_h_power = 3;
    nqm_directions *directions = create(&options, 0, NULL);
    const double *degrees = nqm_directions_get_info(directions).degrees;
    size_t n_small = 0;
    while (n_small < options.n && degrees[3 * n_small] < 2)
        ++n_small;
    assert_true(n_small > 600);
    for (size_t i = 0, seen = 0; i < n_small; ++i) {
        if (degrees[3 * i + 1] > 72)
            continue;
        ++seen;
        double u = cbrt(degrees[3 * i] / 2);
        assert_near((double)seen / (0.96 * (double)n_small), u, 0.03);
    }
    nqm_directions_free(directions);
}

TEST(test_seeds_and_identity) {
    nqm_directions_options options = nqm_directions_options_default();
    options.n = 64;
    nqm_directions *a = create(&options, 0, NULL), *b = create(&options, 0, NULL);
    options.seed = 2;
    nqm_directions *c = create(&options, 0, NULL);
    assert_string_equal(nqm_directions_id(a), nqm_directions_id(b));
    assert_string_not_equal(nqm_directions_id(a), nqm_directions_id(c));
    nqm_directions_free(a);
    nqm_directions_free(b);
    nqm_directions_free(c);
    /* hashlib.sha256(struct.pack("<6d", 0, 10.5, 180, 1.25, 0, 0)).hexdigest()[:16] */
    const double degrees[6] = {0, 10.5, 180, 1.25, -0.0, 0};
    assert_int_equal(nqm_directions_from_degrees(2, degrees, &a, NULL), NQM_OK);
    assert_string_equal(nqm_directions_id(a), "61ebb380bf6a87ea");
    nqm_directions_free(a);
}

static void *ask(void *directions) {
    return (void *)(uintptr_t)nqm_directions_id(directions);
}

/* The identity is computed at the first call, which can be in any thread. */
TEST(test_identity_for_threads) {
    enum { N_THREADS = 8 };
    const double degrees[6] = {0, 10.5, 180, 1.25, 0, 0};
    nqm_directions *directions;
    pthread_t thread[N_THREADS];
    void *id;
    assert_int_equal(nqm_directions_from_degrees(2, degrees, &directions, NULL), NQM_OK);
    for (size_t i = 0; i < N_THREADS; ++i)
        assert_int_equal(pthread_create(&thread[i], NULL, ask, directions), 0);
    for (size_t i = 0; i < N_THREADS; ++i) {
        assert_int_equal(pthread_join(thread[i], &id), 0);
        assert_string_equal(id, "61ebb380bf6a87ea");
    }
    nqm_directions_free(directions);
}

/* A material with a lobe only where phi_d < 90 degrees, plus a constant. */
static void eval_half_space(const void *self, size_t n, const double *hd, double *rgb) {
    (void)self;
    for (size_t i = 0; i < n; ++i)
        for (size_t k = 0; k < 3; ++k)
            rgb[3 * i + k] = hd[3 * i + 2] < NQM_PI / 2 ? 27 : 1;
}

static const nqm_brdf_class half_space = {.format = "test", .eval_half_diff = eval_half_space, .free = free_nothing};

static nqm_brdf *wrap(const nqm_brdf_class *class_) {
    nqm_brdf *brdf;
    assert_int_equal(nqm_brdf_wrap(class_, NULL, &(nqm_brdf_info){.name = "test"}, &brdf, NULL), NQM_OK);
    return brdf;
}

TEST(test_references_attract) {
    nqm_brdf *brdf = wrap(&half_space);
    const nqm_brdf *refs[] = {brdf};
    nqm_directions_options options = nqm_directions_options_default();
    options.n = 2000;
    options.oversampling = 8;
    nqm_directions *plain = create(&options, 0, NULL), *drawn = create(&options, 1, refs),
                   *again = create(&options, 1, refs);
    assert_string_equal(nqm_directions_id(drawn), nqm_directions_id(again));
    size_t n_bright = 0, n_duplicates = 0;
    const double *d = nqm_directions_get_info(drawn).degrees, *p = nqm_directions_get_info(plain).degrees;
    for (size_t i = 0; i < options.n; ++i) {
        n_bright += d[3 * i + 2] < 90;
        n_duplicates += i > 0 && memcmp(d + 3 * i, d + 3 * i - 3, 3 * sizeof *d) == 0;
        /* strata preserve the density in theta_h: quantiles of both sets agree within the width of a stratum */
        if (i < options.n - 40) /* the last strata are wide */
            assert_near(sqrt(d[3 * i] / 75), sqrt(p[3 * i] / 75), 0.02);
    }
    /* weights 3 and 1: three quarters, slightly less because sampling is without replacement */
    assert_near((double)n_bright / (double)options.n, 0.75, 0.04);
    assert_int_equal(n_duplicates, 0);
    nqm_directions_free(plain);
    nqm_directions_free(drawn);
    nqm_directions_free(again);
    nqm_brdf_free(brdf);
}

static int stop_at_once(void *user, const char *stage, double done, double total) {
    (void)user, (void)stage, (void)done, (void)total;
    return 1;
}

TEST(test_options_are_checked) {
    nqm_directions *directions;
    const nqm_directions_options good = nqm_directions_options_default();
    nqm_directions_options bad[7] = {good, good, good, good, good, good, good};
    bad[0].n = 0;
    bad[1].n = 100001;
    bad[2].max_polar_rad = 0;
    bad[3].max_polar_rad = NAN;
    bad[4].theta_h_power = -1;
    bad[5].oversampling = 0.5;
    bad[6].oversampling = 1e9;
    for (size_t i = 0; i < 7; ++i)
        assert_int_equal(nqm_directions_create(&bad[i], 0, NULL, &directions, NULL), NQM_ERR_ARG);
    nqm_brdf *brdf = wrap(&half_space);
    const nqm_brdf *refs[] = {brdf};
    nqm_directions_options stopped = good;
    stopped.progress = stop_at_once;
    assert_int_equal(nqm_directions_create(&stopped, 1, refs, &directions, NULL), NQM_ERR_CANCELLED);
    assert_null(directions);
    nqm_brdf_free(brdf);
    const double outside[][3] = {{-1, 0, 0}, {91, 0, 0}, {0, 90.5, 0}, {0, 0, 361}, {NAN, 0, 0}, {0, 0, INFINITY}};
    for (size_t i = 0; i < sizeof outside / sizeof *outside; ++i)
        assert_int_equal(nqm_directions_from_degrees(1, outside[i], &directions, NULL), NQM_ERR_ARG);
    assert_int_equal(nqm_directions_from_degrees(0, outside[0], &directions, NULL), NQM_ERR_ARG);
}

TEST(test_csv_round_trip) {
    nqm_directions *directions = create(NULL, 0, NULL), *back;
    assert_int_equal(nqm_directions_save_csv(directions, scratch_path("directions.csv"), NULL), NQM_OK);
    assert_int_equal(nqm_directions_load_csv(scratch_path("directions.csv"), &back, NULL), NQM_OK);
    assert_string_equal(nqm_directions_id(directions), nqm_directions_id(back));
    nqm_directions_free(back);
    nqm_directions_free(directions);
    scratch_text("directions.csv", "material,Phi_D,theta_h,theta_d\nfelt,10,20,30\n");
    assert_int_equal(nqm_directions_load_csv(scratch_path("directions.csv"), &back, NULL), NQM_OK);
    assert_near(nqm_directions_get_info(back).degrees[0], 20, 0);
    assert_near(nqm_directions_get_info(back).degrees[1], 30, 0);
    assert_near(nqm_directions_get_info(back).degrees[2], 10, 0);
    nqm_directions_free(back);
}

static void refuse(const char *text, const char *words) {
    nqm_directions *directions;
    nqm_error err = {0};
    scratch_text("directions.csv", text);
    assert_int_equal(nqm_directions_load_csv(scratch_path("directions.csv"), &directions, &err), NQM_ERR_FORMAT);
    assert_null(directions);
    assert_non_null(strstr(err.message, scratch_path("directions.csv")));
    if (!strstr(err.message, words))
        fail_msg("'%s' does not say '%s'", err.message, words);
}

TEST(test_csv_refusals) {
    refuse("", "empty");
    refuse("theta_h,theta_d\n1,2\n", "phi_d");
    refuse("theta_h,theta_d,phi_d\n", "0 directions");
    refuse("theta_h,theta_d,phi_d\n1,2,3\n1,x,3\n", "line 3");
    refuse("theta_h,theta_d,phi_d\n1,2,3\n1,99,3\n", "direction 2");
}

TEST(test_out_of_memory) {
    nqm_brdf *brdf = wrap(&half_space);
    const nqm_brdf *refs[] = {brdf};
    nqm_status status = NQM_OK;
    long n = -1;
    EVERY_ALLOCATION(n, status, 0) {
        nqm_directions *directions;
        status = nqm_directions_create(NULL, 1, refs, &directions, NULL);
        assert_true((status == NQM_OK) == (directions != NULL));
        nqm_directions_free(directions);
    }
    nqm_brdf_free(brdf);
}
