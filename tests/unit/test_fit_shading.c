/* SPDX-License-Identifier: MIT
 *
 * Fits of shading models: each recovers a material of its own, plain values stay plain, bounds and starts hold, and invalid
 * ones are refused.
 */
#include "fit/fit.h"
#include "support/check.h"
#include "support/fitting.h"
#include "support/rows.h"

static nqm_fit_options few_directions(void) {
    nqm_fit_options options = nqm_fit_options_default();
    options.n_directions = 300;
    return options;
}

/* A material and the fit of its own model: the loss vanishes, and the spec has the same keys. */
TEST(models_give_themselves_back) {
    const nqm_fit_options options = few_directions();
    EVERY_ROW(row, "materials fitted to themselves") {
        char model[40];
        snprintf(model, sizeof model, "%.*s", (int)strcspn(row[0], ":"), row[0]);
        nqm_fit_report r = fit_spec(row[0], model, &options);
        assert_true(r.loss < 5e-3);
        if (strncmp(model, "gltf", 4) == 0) {
            check_spec_values(r.spec, row[0], "base_color", 0.02);
            check_spec_values(r.spec, row[0], "roughness", 0.02);
        }
        assert_true(strlen(r.spec) < 160); /* without keys at their defaults */
    }
}

TEST(bounds_and_starts_hold) {
    const char *truth = "gltf:base_color=0.2,0.5,0.1;metallic=0;roughness=0.3";
    const nqm_fit_bound bounds[] = {{"roughness", 0.5, 0.6}, {"ior", 1.4, 1.4}};
    nqm_fit_options options = few_directions();
    options.bounds = bounds;
    options.n_bounds = 2;
    nqm_fit_report r = fit_spec(truth, "gltf", &options);
    double v[3];
    spec_values(r.spec, "roughness", v);
    assert_true(v[0] >= 0.5 && v[0] <= 0.6);
    spec_values(r.spec, "ior", v);
    assert_true(v[0] == 1.4);
    options.n_bounds = 0;
    options.start = "gltf:base_color=0.3;metallic=0.1;roughness=0.4";
    r = fit_spec(truth, "gltf", &options);
    assert_true(r.loss < 5e-3);
    assert_int_equal(r.best_start, 0);
}

static void check_refusal(const nqm_fit_options *options, const char *model, const char *message) {
    nqm_brdf *brdf = must_open("lambert:kd=0.5");
    nqm_fit_report report;
    nqm_error err = {0};
    assert_int_equal(nqm_fit(brdf, model, options, &report, NULL, &err), NQM_ERR_ARG);
    assert_non_null(strstr(err.message, message));
    nqm_brdf_free(brdf);
}

TEST(faults_are_refused) {
    nqm_fit_bound bound = {"gloss", 0, 1};
    nqm_fit_options options = few_directions();
    options.bounds = &bound;
    options.n_bounds = 1;
    check_refusal(&options, "gltf", "no bounds for 'gloss'");
    bound = (nqm_fit_bound){"roughness", 0.5, 1.5};
    check_refusal(&options, "gltf", "between 0 and 1");
    options.n_bounds = 0;
    options.start = "ggx:kd=1;ks=1;alpha=1;f0=1";
    check_refusal(&options, "gltf", "cannot start from");
    check_refusal(NULL, "gtlf", "gtlf");
}
