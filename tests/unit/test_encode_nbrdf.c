/* SPDX-License-Identifier: MIT
 *
 * Training of a network for one BRDF: its loss on known materials, that the seed determines the result, its directions,
 * and cancellation. Compared with measured materials and the published networks if the shared data are present.
 */
#include "brdf/brdf.h"
#include "fit/fit.h"
#include "math/math.h"
#include "support/check.h"

#include <nqm/fit.h>

static nqm_fit_report fit(const nqm_brdf *ref, size_t n_directions, uint64_t seed, nqm_brdf **brdf_ret) {
    nqm_fit_options options = nqm_fit_options_default();
    nqm_fit_report report;
    nqm_error err = {0};
    options.n_directions = n_directions;
    options.seed = seed;
    if (nqm_fit(ref, "nbrdf", &options, &report, brdf_ret, &err) != NQM_OK)
        fail_msg("%s", err.message);
    return report;
}

/* Mean absolute difference of log(1 + cos(theta_i) f_r) over directions of MERL cells at which both BRDFs have a
 * value. */
static double distance(const nqm_brdf *a, const nqm_brdf *b) {
    enum { N = 8192 };
    nqm_rng rng = nqm_rng_make(77, 0);
    double sum = 0;
    size_t n = 0;
    for (size_t i = 0; i < N; ++i) {
        double u = nqm_rng_uniform(&rng), wi[3], wo[3], x[3], y[3];
        const double hd[3] = {u * u * NQM_PI / 2, nqm_rng_uniform(&rng) * NQM_PI / 2, nqm_rng_uniform(&rng) * NQM_PI};
        uint8_t flag[2];
        nqm_half_diff_to_pair(hd, wi, wo);
        nqm_brdf_eval_half_diff(a, 1, hd, x, &flag[0]);
        nqm_brdf_eval_half_diff(b, 1, hd, y, &flag[1]);
        if (flag[0] >= NQM_VALUE_INVALID || flag[1] >= NQM_VALUE_INVALID)
            continue;
        for (size_t c = 0; c < 3; ++c)
            sum += fabs(log1p(wi[2] * x[c]) - log1p(wi[2] * y[c]));
        n += 3;
    }
    assert_true(n > N);
    return sum / (double)n;
}

TEST(known_materials_are_learned) {
    static const struct {
        const char *spec;
        double loss;
    } cases[] = {{"lambert:kd=0.8,0.3,0.02", 0.0005}, {"ggx:kd=0.3,0.1,0.05;ks=1;alpha=0.3;f0=0.04", 0.004}};
    for (size_t i = 0; i < 2; ++i) {
        nqm_brdf *ref = must_open(cases[i].spec), *brdf;
        nqm_fit_report report = fit(ref, 300, 1, &brdf);
        print_message("%s: loss %.5f, distance %.5f\n", cases[i].spec, report.loss, distance(ref, brdf));
        assert_true(report.loss < cases[i].loss);
        assert_true(distance(ref, brdf) < 2 * cases[i].loss);
        assert_string_equal(report.spec, "");
        assert_int_equal(report.n_numbers, 675);
        assert_true(report.n_directions >= 4800);
        assert_string_equal(nqm_brdf_get_info(brdf).format, "nbrdf");
        nqm_brdf_free(brdf);
        nqm_brdf_free(ref);
    }
}

TEST(a_seed_is_a_result) {
    nqm_brdf *ref = must_open("ggx:alpha=0.2"), *a, *b, *c;
    nqm_fit_report first = fit(ref, 200, 1, &a), again = fit(ref, 200, 1, &b), other = fit(ref, 200, 2, &c);
    assert_true(first.loss == again.loss && distance(a, b) == 0);
    assert_true(first.loss != other.loss && distance(a, c) > 0);
    nqm_brdf_free(a);
    nqm_brdf_free(b);
    nqm_brdf_free(c);
    nqm_brdf_free(ref);
}

/* f_r in 1/sr: 0.5 where phi_d < pi, 5 elsewhere; no value beyond theta_h = 0.9. */
static void lopsided_eval(const void *self, size_t n, const double *hd, double *rgb) {
    (void)self;
    for (size_t i = 0; i < 3 * n; ++i)
        rgb[i] = hd[3 * (i / 3)] > 0.9 ? NAN : hd[3 * (i / 3) + 2] < NQM_PI ? 0.5 : 5;
}

static void nothing_eval(const void *self, size_t n, const double *hd, double *rgb) {
    (void)self;
    (void)hd;
    for (size_t i = 0; i < 3 * n; ++i)
        rgb[i] = NAN;
}

TEST(missing_values_are_left_out) {
    static const nqm_brdf_class lopsided = {.format = "x", .eval_half_diff = lopsided_eval, .free = free_nothing};
    static const nqm_brdf_class nothing = {.format = "x", .eval_half_diff = nothing_eval, .free = free_nothing};
    nqm_brdf *ref, *brdf;
    nqm_fit_report report;
    nqm_error err = {0};
    assert_int_equal(nqm_brdf_wrap(&lopsided, NULL, &(nqm_brdf_info){.name = "lopsided"}, &ref, NULL), NQM_OK);
    report = fit(ref, 200, 1, &brdf);
    assert_true(report.loss < 0.01 && distance(ref, brdf) < 0.02);
    nqm_brdf_free(brdf);
    nqm_brdf_free(ref);
    assert_int_equal(nqm_brdf_wrap(&nothing, NULL, &(nqm_brdf_info){.name = "nothing"}, &ref, NULL), NQM_OK);
    assert_int_equal(nqm_fit(ref, "nbrdf", NULL, &report, &brdf, &err), NQM_ERR_INCOMPATIBLE);
    assert_non_null(strstr(err.message, "nothing"));
    assert_null(brdf);
    nqm_brdf_free(ref);
}

/* ---- progress ---------------------------------------------------------------------------------------------------- */

typedef struct watch {
    size_t n_calls, stop_at;
    double last;
} watch;

static int on_progress(void *user, const char *stage, double done, double total) {
    watch *w = user;
    assert_non_null(stage);
    assert_true(done >= w->last && done <= total);
    w->last = done;
    return ++w->n_calls == w->stop_at;
}

TEST(progress_is_told_and_stops) {
    nqm_brdf *ref = must_open("lambert:kd=0.5"), *brdf;
    nqm_fit_options options = nqm_fit_options_default();
    nqm_fit_report report;
    watch all = {0}, some = {.stop_at = 2};
    options.n_directions = 200;
    options.progress = on_progress;
    options.progress_user = &all;
    assert_int_equal(nqm_fit(ref, "nbrdf", &options, &report, NULL, NULL), NQM_OK);
    assert_true(all.n_calls >= 3);
    options.progress_user = &some;
    assert_int_equal(nqm_fit(ref, "nbrdf", &options, &report, &brdf, NULL), NQM_ERR_CANCELLED);
    assert_null(brdf);
    assert_int_equal(some.n_calls, 2);
    nqm_brdf_free(ref);
}

/* ---- measured materials ------------------------------------------------------------------------------------------ */

/* With a tenth of the default number of steps the loss is lower than that of the published network. */
TEST(as_near_as_the_published) {
    static const char *const materials[] = {"cardboard_rgb", "satin_purple_rgb"};
    for (size_t i = 0; i < sizeof materials / sizeof *materials; ++i) {
        char path[512], zip[600];
        snprintf(path, sizeof path, "rgl/%s.bsdf", materials[i]);
        const char *measured = shared_data(path);
        if (!measured)
            skip();
        nqm_brdf *ref = must_open(measured), *published, *own;
        snprintf(zip, sizeof zip, "%s:%s", shared_data("nbrdf/rgl-isotropic_nbrdf.zip"), materials[i]);
        published = must_open(zip);
        fit(ref, 600, 1, &own);
        double ours = distance(ref, own), theirs = distance(ref, published);
        print_message("%s: %.5f, published %.5f\n", materials[i], ours, theirs);
        assert_true(ours < theirs);
        nqm_brdf_free(own);
        nqm_brdf_free(published);
        nqm_brdf_free(ref);
    }
}
