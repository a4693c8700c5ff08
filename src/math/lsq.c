/* SPDX-License-Identifier: MIT
 *
 * Nonlinear least squares: calls the Levenberg-Marquardt method of MINPACK (More 1978, DOI 10.1007/BFb0067700) in
 * cminpack. This file computes the Jacobian by forward differences, because those of MINPACK use only relative steps,
 * and a parameter that is a logarithm near 0 needs an absolute step.
 */
#include "math/math.h"

#include <cminpack.h>
#include <float.h>
#include <limits.h>
#include <math.h>

/* Values that the callback of MINPACK returns to stop; lmder() then returns the same value. */
enum { STOPPED_BY_USER = -1, STOPPED_NOT_FINITE = -2 };

typedef struct solver {
    const nqm_lsq_problem *problem;
    double *shifted; /* (n_residuals) residuals at a shifted point, for the differences */
} solver;

static int evaluate(const nqm_lsq_problem *problem, const double *x, double *residual) {
    if (problem->residuals(problem->user, x, residual) != 0)
        return STOPPED_BY_USER;
    for (size_t i = 0; i < problem->n_residuals; ++i)
        if (!isfinite(residual[i]))
            return STOPPED_NOT_FINITE;
    return 0;
}

/* jacobian: (n_parameters, n_residuals), that is, MINPACK's column-major matrix. */
static int differentiate(solver *s, double *x, const double *residual, double *jacobian) {
    const nqm_lsq_problem *problem = s->problem;
    for (size_t j = 0; j < problem->n_parameters; ++j) {
        double keep = x[j];
        double step = problem->step > 0 ? problem->step : sqrt(DBL_EPSILON) * (keep != 0 ? fabs(keep) : 1);
        x[j] = keep + step;
        step = x[j] - keep; /* the step after rounding */
        int stop = evaluate(problem, x, s->shifted);
        x[j] = keep;
        if (stop)
            return stop;
        for (size_t i = 0; i < problem->n_residuals; ++i)
            jacobian[j * problem->n_residuals + i] = (s->shifted[i] - residual[i]) / step;
    }
    return 0;
}

static int minpack_callback(void *p, int m, int n, const double *x, double *residual, double *jacobian, int ld_jacobian,
                            int task) {
    (void)m;
    (void)n;
    (void)ld_jacobian;
    solver *s = p;
    if (task == 1)
        return evaluate(s->problem, x, residual);
    return differentiate(s, (double *)(uintptr_t)x, residual, jacobian); /* differentiate() restores x */
}

static double root_mean_square(size_t n, const double *residual) {
    double sum = 0;
    for (size_t i = 0; i < n; ++i)
        sum += residual[i] * residual[i];
    return sqrt(sum / (double)n);
}

nqm_status nqm_lsq_solve(const nqm_lsq_problem *problem, double *x, double *rms_ret, nqm_error *err) {
    size_t m = problem->n_residuals, n = problem->n_parameters;
    if (n < 1 || m < n || m > INT_MAX / 2 || n > 1000)
        return nqm_fail(err, NQM_ERR_ARG, -1, "least squares: %zu residuals do not determine %zu parameters", m, n);

    solver s = {.problem = problem};
    double *jacobian, *residual, *scratch_m, *scale, *qtf, *scratch, *best;
    int *pivot;
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&jacobian, n * m, sizeof(double)}, {&residual, m, sizeof(double)}, {&s.shifted, m, sizeof(double)},
                   {&scratch_m, m, sizeof(double)}, {&scale, n, sizeof(double)}, {&qtf, n, sizeof(double)},
                   {&scratch, 3 * n, sizeof(double)}, {&best, n, sizeof(double)}, {&pivot, n, sizeof(int)}),
        err);
    if (status != NQM_OK)
        return status;
    double tolerance = problem->tolerance > 0 ? problem->tolerance : 1e-12;
    int max_evaluations = problem->max_evaluations > 0 ? problem->max_evaluations : 200 * ((int)n + 1);
    for (size_t j = 0; j < n; ++j)
        best[j] = x[j];
    int n_residual_calls, n_jacobian_calls;
    int info = lmder(minpack_callback, &s, (int)m, (int)n, best, residual, jacobian, (int)m, tolerance, tolerance, 0,
                     max_evaluations, scale, 1, 100, 0, &n_residual_calls, &n_jacobian_calls, pivot, qtf, scratch,
                     scratch + n, scratch + 2 * n, scratch_m);

    if (info == STOPPED_BY_USER)
        status = nqm_fail(err, NQM_ERR_CANCELLED, -1, "least squares: stopped by the caller");
    else if (info == STOPPED_NOT_FINITE)
        status = nqm_fail(err, NQM_ERR_NUMERIC, -1, "least squares: a residual is not finite");
    else if (info <= 0)
        status = nqm_fail(err, NQM_ERR_NUMERIC, -1, "least squares: MINPACK gave up (%d)", info);
    if (status == NQM_OK) {
        for (size_t j = 0; j < n; ++j)
            x[j] = best[j];
        *rms_ret = root_mean_square(m, residual);
    }
    nqm_free(jacobian);
    return status;
}
