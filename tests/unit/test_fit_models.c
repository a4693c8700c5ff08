/* SPDX-License-Identifier: MIT
 *
 * Fits of the published models: each recovers known parameters, stays within bounds, and refuses invalid bounds.
 */
#include "fit/fit.h"
#include "support/check.h"
#include "support/fitting.h"
#include "support/rows.h"

/* Several lobes of every model that other tests do not cover: wide and narrow, strong and weak Fresnel effect, dark
 * bases. */
TEST(every_model_gives_itself_back) {
    nqm_fit_options options = nqm_fit_options_default();
    options.n_directions = 2000;
    EVERY_ROW(row, "lobes of all models") {
        char model[40], truth[200];
        size_t n = strcspn(row[0], ";");
        snprintf(model, sizeof model, "%.*s", (int)n, row[0]);
        int abc = strstr(row[0], ";C=") != NULL;
        snprintf(truth, sizeof truth, "%s:kd=0.3,0.02,0.1;ks=%s%s", model, abc ? "50,200,400" : "0.05,0.2,0.4",
                 row[0] + n);
        nqm_fit_report r = fit_spec(truth, model, &options);
        check_spec_values(r.spec, truth, "kd", 5e-3);
        check_spec_values(r.spec, truth, "ks", 2e-2);
        static const char *const keys[] = {"alpha", "n", "cz", "f0", "B", "C", "eta"};
        size_t n_shape = 0;
        for (size_t k = 0; k < sizeof keys / sizeof *keys; ++k)
            if (nqm_fit_model_has(model, keys[k])) {
                check_spec_values(r.spec, truth, keys[k], 2e-2);
                ++n_shape;
            }
        assert_int_equal(r.n_numbers, 6 + n_shape);
        assert_true(r.loss < 1e-4);
    }
}

/* The fit stays in the narrower range; an optimum outside it is moved to its border. */
TEST(bounds_hold) {
    const nqm_fit_bound bounds[] = {{"alpha", 0.2, 0.5}, {"f0", 0.3, 0.31}};
    nqm_fit_options options = nqm_fit_options_default();
    options.bounds = bounds;
    options.n_bounds = 2;
    nqm_fit_report r = fit_spec("ggx:kd=0.1;ks=0.3;alpha=0.1;f0=0.04", "ggx", &options);
    double alpha[3], f0[3];
    spec_values(r.spec, "alpha", alpha);
    spec_values(r.spec, "f0", f0);
    assert_true(alpha[0] >= 0.2 && alpha[0] < 0.21 && f0[0] >= 0.3 && f0[0] <= 0.31);
    options.n_bounds = 1;
    r = fit_spec("cook-torrance:kd=0.1;ks=0.3;alpha=0.3;f0=0.04", "cook-torrance", &options);
    spec_values(r.spec, "alpha", alpha);
    assert_true(fabs(alpha[0] - 0.3) < 1e-3);
}

TEST(bad_bounds_are_refused) {
    nqm_brdf *brdf = must_open("lambert:kd=0.5");
    nqm_fit_report report;
    nqm_error err = {0};
    static const nqm_fit_bound bad[] = {{"f0", 0.1, 0.2},     {"kd", 0, 1},      {"alpha", 0.2, 0.1},
                                        {"alpha", 1e-5, 0.1}, {"alpha", 0.1, 2}, {"alpha", NAN, 1}};
    for (size_t k = 0; k < sizeof bad / sizeof *bad; ++k) {
        nqm_fit_options options = nqm_fit_options_default();
        options.bounds = &bad[k];
        options.n_bounds = 1;
        assert_int_equal(nqm_fit(brdf, "ward", &options, &report, NULL, &err), NQM_ERR_ARG);
        assert_non_null(strstr(err.message, bad[k].key));
    }
    assert_int_equal(nqm_fit_model_has("ward", "alpha"), 1);
    assert_int_equal(nqm_fit_model_has("ward", "f0"), 0);
    assert_int_equal(nqm_fit_model_has("nbrdf", "alpha"), 0);
    nqm_brdf_free(brdf);
}

/* Coordinate to value and back, for every scale; the bounds are those of the values. */
TEST(coordinates_are_those_of_values) {
    const nqm_fit_options options = nqm_fit_options_default();
    for (size_t m = 0; m < NQM_FIT_FIRST_SHADING; ++m) {
        const nqm_fit_entry *entry;
        nqm_fit_space space;
        assert_int_equal(nqm_fit_entry_find(nqm_fit_model(m), &entry, NULL), NQM_OK);
        if (entry->encode)
            continue;
        assert_int_equal(nqm_fit_space_make(entry, &options, &space, NULL), NQM_OK);
        double low[NQM_FIT_MAX_FREE], high[NQM_FIT_MAX_FREE], x[NQM_FIT_MAX_FREE], again[NQM_FIT_MAX_FREE];
        nqm_fit_bounds(&space, low, high);
        for (double at = 0; at <= 1; at += 0.25) {
            nqm_values values = space.defaults;
            for (size_t k = 0; k < space.n; ++k)
                x[k] = low[k] + at * (high[k] - low[k]);
            nqm_fit_values(&space, x, &values);
            nqm_fit_coordinates(&space, &values, again);
            for (size_t k = 0; k < space.n; ++k) {
                assert_true(low[k] < high[k]);
                assert_near(again[k], x[k], 1e-6);
            }
        }
    }
}
