/* SPDX-License-Identifier: MIT
 *
 * Regression of the JOD curve: exact scores give the coefficients of their curve, made-up noisy scores give scipy's
 * result (vectors/percept.py), scores that cannot be fitted are refused.
 */
#include "percept/percept.h"
#include "support/check.h"
#include "support/vectors.h"

enum { N_SCORES = 30, MAX_TIMES = 1 + 10000 / N_SCORES };

TEST(exact_scores) {
    nqm_curve truth = nqm_curve_published;
    double delta_e[20], jod[20];
    for (int i = 0; i < 20; ++i) {
        delta_e[i] = 0.5 * pow(1.3, i);
        jod[i] = nqm_curve_jod(&truth, delta_e[i]);
    }
    nqm_regress_report report;
    assert_int_equal(nqm_regress(20, delta_e, jod, &report, NULL), NQM_OK);
    assert_relative(report.curve.b1, truth.b1, 1e-6);
    assert_relative(report.curve.b2, truth.b2, 1e-6);
    assert_relative(report.curve.b3, truth.b3, 1e-6);
    assert_near(report.rmse, 0, 1e-8);
    assert_true(report.spearman == -1 && report.n == 20);
}

/* Each score n_times: this does not change the fit. */
static void fit_as_scipy(size_t n_times) {
    static double delta_e[MAX_TIMES * N_SCORES], jod[MAX_TIMES * N_SCORES];
    double score_vector[N_SCORES][2], score_fit[5]; /* of the latter: b1, b2, b3, RMSE, Spearman */
    get_vector("percept.safetensors", "score", sizeof score_vector, score_vector);
    get_vector("percept.safetensors", "fit", sizeof score_fit, score_fit);
    for (size_t i = 0; i < n_times * N_SCORES; ++i) {
        delta_e[i] = score_vector[i / n_times][0];
        jod[i] = score_vector[i / n_times][1];
    }
    nqm_regress_report report;
    assert_int_equal(nqm_regress(n_times * N_SCORES, delta_e, jod, &report, NULL), NQM_OK);
    assert_relative(report.curve.b1, score_fit[0], 1e-4);
    assert_relative(report.curve.b2, score_fit[1], 1e-4);
    assert_relative(report.curve.b3, score_fit[2], 1e-4);
    assert_relative(report.rmse, score_fit[3], 1e-8);
    assert_relative(report.spearman, score_fit[4], 1e-9);
}

TEST(noisy_scores_as_scipy) {
    fit_as_scipy(1);
    fit_as_scipy(MAX_TIMES); /* so many that a sample of them selects the start */
}

TEST(refuses_what_does_not_determine_a_curve) {
    double delta_e[5] = {7, 7, 7, 7, 7}, jod[5] = {1, 2, 3, 4, 5};
    nqm_regress_report report = {.n = 99};
    nqm_error err = {0};
    assert_int_equal(nqm_regress(5, delta_e, jod, &report, &err), NQM_ERR_NUMERIC);
    assert_int_equal(nqm_regress(3, delta_e, jod, &report, &err), NQM_ERR_ARG);
    jod[4] = NAN;
    assert_int_equal(nqm_regress(5, delta_e, jod, &report, &err), NQM_ERR_ARG);
    assert_string_equal(err.message, "regression of the JOD curve: score 5 is not finite");
    assert_int_equal(report.n, 99);
}
