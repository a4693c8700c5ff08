/* SPDX-License-Identifier: MIT
 *
 * Fits recover known parameters for every lobe width and loss; a model fitted to another model has the same highlight
 * and base; the same seed gives the same spec; invalid arguments are refused.
 */
#include "brdf/brdf.h"
#include "fit/fit.h"
#include "support/allocations.h"
#include "support/check.h"
#include "support/fitting.h"

TEST(ward_gives_itself_back) {
    static const double alphas[] = {0.002, 0.01, 0.05, 0.2, 0.6};
    for (size_t i = 0; i < sizeof alphas / sizeof *alphas; ++i) {
        char truth[200];
        snprintf(truth, sizeof truth, "ward:kd=0.3,0.02,0.1;ks=0.05,0.2,0.4;alpha=%g", alphas[i]);
        nqm_fit_report r = fit_spec(truth, "ward", NULL);
        check_spec_values(r.spec, truth, "alpha", 1e-3);
        check_spec_values(r.spec, truth, "kd", 2e-3);
        check_spec_values(r.spec, truth, "ks", 2e-3);
        assert_true(r.loss < 1e-4);
        assert_int_equal(r.n_directions, 6000);
    }
}

TEST(ggx_gives_itself_back) {
    static const double alphas[] = {0.002, 0.01, 0.05, 0.2, 0.6}, f0s[] = {0.04, 0.3, 0.9};
    for (size_t i = 0; i < 15; ++i) {
        char truth[200];
        snprintf(truth, sizeof truth, "ggx:kd=0.3,0.02,0.1;ks=0.05,0.2,0.4;alpha=%g;f0=%g", alphas[i / 3], f0s[i % 3]);
        nqm_fit_report r = fit_spec(truth, "ggx", NULL);
        check_spec_values(r.spec, truth, "alpha", 5e-3);
        check_spec_values(r.spec, truth, "f0", 2e-2);
        check_spec_values(r.spec, truth, "kd", 5e-3);
        check_spec_values(r.spec, truth, "ks", 2e-2);
        assert_true(r.loss < 1e-3);
    }
}

TEST(every_loss_finds_the_truth) {
    static const char *const names[] = {"log", "log-cos", "cube-root", "linear"};
    const char *truth = "ward:kd=0.3,0.02,0.1;ks=0.05,0.2,0.4;alpha=0.1";
    for (int k = 0; k < 4; ++k) {
        nqm_fit_options options = nqm_fit_options_default();
        options.loss = (nqm_fit_loss)k;
        assert_string_equal(nqm_fit_loss_words[k], names[k]);
        nqm_fit_report r = fit_spec(truth, "ward", &options);
        check_spec_values(r.spec, truth, "alpha", 5e-3);
        check_spec_values(r.spec, truth, "kd", 1e-2);
        check_spec_values(r.spec, truth, "ks", 1e-2);
    }
}

/* Mirror peak of Ward's model at theta_d (Ward 1992, eq. 5a with theta_h = 0). */
static double ward_peak(double kd, double ks, double alpha, double theta_d) {
    const double pi = acos(-1);
    return kd / pi + ks / (4 * pi * alpha * alpha * cos(theta_d));
}

TEST(sharp_metal_keeps_highlight_and_base) {
    static const double alphas[] = {0.003, 0.02};
    const double pi = acos(-1), theta_d = 20 * pi / 180;
    for (int i = 0; i < 2; ++i) {
        char truth[100];
        snprintf(truth, sizeof truth, "ward:kd=0.01;ks=0.6;alpha=%g", alphas[i]);
        nqm_fit_report r = fit_spec(truth, "ggx", NULL);
        nqm_brdf *ggx = must_open(r.spec);
        const double mirror[3] = {0, theta_d, pi / 2}, off[3] = {40 * pi / 180, theta_d, pi / 2};
        double rgb[3];
        nqm_brdf_eval_half_diff(ggx, 1, mirror, rgb, NULL);
        double ratio = rgb[1] / ward_peak(0.01, 0.6, alphas[i], theta_d);
        assert_true(ratio > 0.5 && ratio < 2.5);
        nqm_brdf_eval_half_diff(ggx, 1, off, rgb, NULL);
        assert_true(rgb[1] < 0.01 / pi + 0.01);
        nqm_brdf_free(ggx);
    }
}

TEST(a_seed_is_a_result) {
    nqm_fit_options options = nqm_fit_options_default();
    nqm_fit_report a = fit_spec("sgd:blue-rubber", "ggx", &options), b = fit_spec("sgd:blue-rubber", "ggx", &options);
    assert_string_equal(a.spec, b.spec);
    options.seed = 2;
    nqm_fit_report c = fit_spec("sgd:blue-rubber", "ggx", &options);
    assert_string_not_equal(a.spec, c.spec);
    check_spec_values(c.spec, a.spec, "alpha", 0.05);
}

TEST(a_spec_says_what_was_fitted) {
    nqm_fit_report r = fit_spec("sgd:red-plastic", "ward", NULL);
    nqm_brdf *brdf = must_open(r.spec);
    assert_string_equal(nqm_brdf_get_info(brdf).format, "ward");
    nqm_brdf_free(brdf);
}

/* ---- failures ---------------------------------------------------------------------------------------------------- */

static void nothing_eval(const void *self, size_t n, const double *wi, const double *wo, double *rgb) {
    (void)self;
    (void)wi;
    (void)wo;
    for (size_t i = 0; i < 3 * n; ++i)
        rgb[i] = NAN;
}

TEST(a_brdf_without_values_is_refused) {
    static const nqm_brdf_class nothing = {.format = "nothing", .eval = nothing_eval, .free = free_nothing};
    nqm_brdf *brdf;
    nqm_error err = {0};
    nqm_fit_report report = {.loss = -1};
    assert_int_equal(nqm_brdf_wrap(&nothing, NULL, &(nqm_brdf_info){.name = "nothing.bsdf"}, &brdf, NULL), NQM_OK);
    assert_int_equal(nqm_fit(brdf, "ward", NULL, &report, NULL, &err), NQM_ERR_INCOMPATIBLE);
    assert_non_null(strstr(err.message, "nothing.bsdf"));
    assert_true(report.loss == -1);
    nqm_brdf_free(brdf);
}

TEST(bad_arguments_are_refused) {
    nqm_brdf *brdf = must_open("lambert:kd=0.5");
    nqm_fit_report report;
    nqm_error err = {0};
    assert_int_equal(nqm_fit(brdf, "phong", NULL, &report, NULL, &err), NQM_ERR_ARG);
    assert_non_null(strstr(err.message, "phong"));
    for (int k = 0; k < 5; ++k) {
        nqm_fit_options options = nqm_fit_options_default();
        options.n_directions = k == 0 ? 10 : options.n_directions;
        options.max_polar_rad = k == 1 ? 2 : options.max_polar_rad;
        options.highlight_fraction = k == 2 ? 1.5 : options.highlight_fraction;
        options.n_starts = k == 3 ? 0 : options.n_starts;
        options.loss = k == 4 ? (nqm_fit_loss)99 : options.loss;
        assert_int_equal(nqm_fit(brdf, "ward", &options, &report, NULL, &err), NQM_ERR_ARG);
    }
    nqm_brdf_free(brdf);
}

/* Fails allocation 0, 1, 2, 3, 5, 7, 10, ... of tens. */
TEST(memory_runs_out) {
    nqm_brdf *brdf = must_open("sgd:nickel");
    nqm_fit_options options = nqm_fit_options_default();
    options.n_directions = 200;
    options.n_starts = 2;
    nqm_status status = NQM_OK;
    long n = -1;
    EVERY_ALLOCATION(n, status, 3) {
        nqm_fit_report report;
        nqm_error err = {0};
        status = nqm_fit(brdf, "ggx", &options, &report, NULL, &err);
        assert_int_equal(err.status, status);
    }
    assert_true(n > 20);
    nqm_brdf_free(brdf);
}

static int stop(void *user, const char *stage, double done, double total) {
    (void)user;
    (void)stage;
    (void)done;
    (void)total;
    return 1;
}

TEST(a_fit_can_be_stopped) {
    nqm_brdf *brdf = must_open("sgd:nickel");
    nqm_fit_options options = nqm_fit_options_default();
    nqm_fit_report report;
    options.progress = stop;
    assert_int_equal(nqm_fit(brdf, "ggx", &options, &report, NULL, NULL), NQM_ERR_CANCELLED);
    nqm_brdf_free(brdf);
}
