/* SPDX-License-Identifier: MIT
 *
 * Fit a spec with another model, and compare the values of two specs.
 */
#include "support/fitting.h"
#include "fit/fit.h"
#include "support/check.h"

nqm_fit_report fit_spec(const char *spec, const char *model, const nqm_fit_options *options) {
    nqm_error err = {0};
    nqm_fit_report report;
    nqm_brdf *ref = must_open(spec);
    if (nqm_fit(ref, model, options, &report, NULL, &err) != NQM_OK)
        fail_msg("%s: %s", spec, err.message);
    nqm_brdf_free(ref);
    return report;
}

double loss_of_spec(const nqm_fit_target *target, const char *spec) {
    nqm_brdf *brdf = must_open(spec);
    double *rgb = nqm_alloc(target->n, 3 * sizeof *rgb);
    assert_non_null(rgb);
    nqm_brdf_eval(brdf, target->n, target->wi, target->wo, rgb, NULL);
    const double loss = nqm_fit_loss_value(target, rgb, NULL);
    nqm_free(rgb);
    nqm_brdf_free(brdf);
    return loss;
}

nqm_fit_report fit_from_random(const char *spec, const char *model, const nqm_fit_options *options, size_t n) {
    nqm_fit_report best = {.loss = INFINITY};
    nqm_brdf *ref = must_open(spec);
    for (size_t seed = 0; seed < n; ++seed) {
        char start[512];
        nqm_fit_options from = *options;
        assert_int_equal(nqm_fit_path(ref, model, options, seed, 0, start, NULL), NQM_OK);
        from.start = start;
        nqm_fit_report report = fit_spec(spec, model, &from);
        best = report.loss < best.loss ? report : best;
    }
    nqm_brdf_free(ref);
    return best;
}

void spec_values(const char *spec, const char *key, double v[3]) {
    char pattern[16];
    snprintf(pattern, sizeof pattern, "%s=", key);
    const char *at = strstr(spec, pattern);
    assert_non_null(at);
    int n = sscanf(at + strlen(pattern), "%lf,%lf,%lf", &v[0], &v[1], &v[2]);
    assert_true(n >= 1);
    if (n == 1)
        v[1] = v[2] = v[0];
}

void check_spec_values(const char *fitted, const char *truth, const char *key, double tolerance) {
    double found[3], expected[3];
    spec_values(fitted, key, found);
    spec_values(truth, key, expected);
    for (int c = 0; c < 3; ++c)
        if (!(fabs(found[c] - expected[c]) <= tolerance * expected[c] + 1e-4))
            fail_msg("%s of %s: %s gave %s", key, truth, key, fitted);
}
