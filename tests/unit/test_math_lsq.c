/* SPDX-License-Identifier: MIT
 *
 * Least squares on problems with known solutions: Rosenbrock's valley, and two of the NIST Statistical Reference
 * Datasets (itl.nist.gov/div898/strd/nls) with their certified values; and every stopping condition.
 */
#include "math/math.h"
#include "support/check.h"

#include <math.h>

static int rosenbrock(void *user, const double *x, double *residual) {
    (void)user;
    residual[0] = 10 * (x[1] - x[0] * x[0]);
    residual[1] = 1 - x[0];
    return 0;
}

static void rosenbrock_valley(void **state) {
    (void)state;
    const nqm_lsq_problem problem = {.n_parameters = 2, .n_residuals = 2, .residuals = rosenbrock};
    double x[2] = {-1.2, 1}, rms;
    assert_int_equal(nqm_lsq_solve(&problem, x, &rms, NULL), NQM_OK);
    assert_near(x[0], 1, 1e-8);
    assert_near(x[1], 1, 1e-8);
    assert_near(rms, 0, 1e-8);
}

/* (y, x) */
static const double misra1a[14][2] = {{10.07, 77.6},  {14.73, 114.9}, {17.94, 141.1}, {23.93, 190.8}, {29.61, 239.9},
                                      {35.18, 289.0}, {40.02, 332.8}, {44.82, 378.4}, {50.76, 434.8}, {55.05, 477.3},
                                      {61.01, 536.8}, {66.40, 593.1}, {75.47, 689.1}, {81.78, 760.0}};

static int misra1a_residuals(void *user, const double *b, double *residual) {
    (void)user;
    for (size_t i = 0; i < 14; ++i)
        residual[i] = b[0] * (1 - exp(-b[1] * misra1a[i][1])) - misra1a[i][0];
    return 0;
}

static void nist_misra1a(void **state) {
    (void)state;
    static const double start[2][2] = {{500, 0.0001}, {250, 0.0005}};
    const nqm_lsq_problem problem = {.n_parameters = 2, .n_residuals = 14, .residuals = misra1a_residuals};
    for (int s = 0; s < 2; ++s) {
        double b[2] = {start[s][0], start[s][1]}, rms;
        assert_int_equal(nqm_lsq_solve(&problem, b, &rms, NULL), NQM_OK);
        assert_relative(b[0], 2.3894212918e+02, 1e-7);
        assert_relative(b[1], 5.5015643181e-04, 1e-7);
        assert_relative(rms * rms * 14, 1.2455138894e-01, 1e-9);
    }
}

static const double mgh09[11][2] = {{0.1957, 4},      {0.1947, 2},      {0.1735, 1},     {0.16, 0.5},
                                    {0.0844, 0.25},   {0.0627, 0.167},  {0.0456, 0.125}, {0.0342, 0.1},
                                    {0.0323, 0.0833}, {0.0235, 0.0714}, {0.0246, 0.0625}};

static int mgh09_residuals(void *user, const double *b, double *residual) {
    (void)user;
    for (size_t i = 0; i < 11; ++i) {
        double x = mgh09[i][1];
        residual[i] = b[0] * (x * x + x * b[1]) / (x * x + x * b[2] + b[3]) - mgh09[i][0];
    }
    return 0;
}

static void nist_mgh09_with_absolute_steps(void **state) {
    (void)state;
    static const double certified[4] = {1.9280693458e-01, 1.9128232873e-01, 1.2305650693e-01, 1.3606233068e-01};
    const nqm_lsq_problem problem = {
        .n_parameters = 4, .n_residuals = 11, .residuals = mgh09_residuals, .step = 1e-8, .max_evaluations = 2000};
    double b[4] = {0.25, 0.39, 0.415, 0.39}, rms;
    assert_int_equal(nqm_lsq_solve(&problem, b, &rms, NULL), NQM_OK);
    for (int k = 0; k < 4; ++k)
        assert_relative(b[k], certified[k], 1e-5);
    assert_relative(rms * rms * 11, 3.0750560385e-04, 1e-9);
}

/* Residuals rounded to float: finite differences with the step sqrt(eps) of double give a zero slope. */
static int rounded_exponential(void *user, const double *x, double *residual) {
    (void)user;
    for (int i = 0; i < 5; ++i)
        residual[i] = (double)(float)(exp(x[0]) * (i + 1)) - 3 * (i + 1);
    return 0;
}

static void absolute_steps_bridge_rounding(void **state) {
    (void)state;
    nqm_lsq_problem problem = {
        .n_parameters = 1, .n_residuals = 5, .residuals = rounded_exponential, .step = 1e-3, .tolerance = 1e-6};
    double x = 0, rms;
    assert_int_equal(nqm_lsq_solve(&problem, &x, &rms, NULL), NQM_OK);
    assert_near(x, log(3), 1e-5);
    problem.step = 0;
    x = 0;
    assert_int_equal(nqm_lsq_solve(&problem, &x, &rms, NULL), NQM_OK);
    assert_true(fabs(x) < 1e-6);
}

typedef struct stopper {
    int n_calls, stop_at;
    double value_at_stop; /* 0: stop; otherwise the residual after that call */
} stopper;

static int stopping(void *user, const double *x, double *residual) {
    stopper *s = user;
    residual[0] = x[0] - 7;
    residual[1] = x[0] * x[0];
    if (++s->n_calls < s->stop_at)
        return 0;
    if (s->value_at_stop == 0)
        return 1;
    residual[1] = s->value_at_stop;
    return 0;
}

static void stops_when_told_or_not_finite(void **state) {
    (void)state;
    for (int stop_at = 1; stop_at < 6; ++stop_at) {
        stopper s = {.stop_at = stop_at};
        nqm_lsq_problem problem = {.n_parameters = 1, .n_residuals = 2, .residuals = stopping, .user = &s};
        double x = 3, rms = -1;
        nqm_error err = {0};
        assert_int_equal(nqm_lsq_solve(&problem, &x, &rms, &err), NQM_ERR_CANCELLED);
        assert_int_equal(s.n_calls, stop_at);
        assert_true(x == 3 && rms == -1 && err.message[0]);
        s = (stopper){.stop_at = stop_at, .value_at_stop = stop_at % 2 ? NAN : INFINITY};
        assert_int_equal(nqm_lsq_solve(&problem, &x, &rms, &err), NQM_ERR_NUMERIC);
        assert_true(x == 3 && rms == -1);
    }
}

static void refuses_what_is_not_determined(void **state) {
    (void)state;
    double x[3] = {0}, rms;
    nqm_lsq_problem problem = {.n_parameters = 3, .n_residuals = 2, .residuals = rosenbrock};
    assert_int_equal(nqm_lsq_solve(&problem, x, &rms, NULL), NQM_ERR_ARG);
    problem.n_parameters = 0;
    assert_int_equal(nqm_lsq_solve(&problem, x, &rms, NULL), NQM_ERR_ARG);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rosenbrock_valley),
        cmocka_unit_test(nist_misra1a),
        cmocka_unit_test(nist_mgh09_with_absolute_steps),
        cmocka_unit_test(absolute_steps_bridge_rounding),
        cmocka_unit_test(stops_when_told_or_not_finite),
        cmocka_unit_test(refuses_what_is_not_determined),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
