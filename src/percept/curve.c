/* SPDX-License-Identifier: MIT
 *
 * The JOD curve and its regression on human scores (Kavoosighafi et al. 2025, section 3): least squares by
 * Levenberg-Marquardt. The three coefficients are strongly correlated, so the fit starts from several exponents b3. For
 * a fixed b3, logit(JOD / 10) is linear in Delta-E^b3, which gives the initial b1 and b2 in closed form.
 */
#include "math/math.h"
#include "percept/percept.h"

#include <cminpack.h>
#include <math.h>
#include <string.h>

/* Least-squares fit to the authors' 180 human scores; the paper prints the coefficients as (-14.11, -0.47, -0.21). */
const nqm_curve nqm_curve_published = {-14.11196939758611, -0.47364347065458806, -0.21479944748134167};

/* Logit of JOD / 10, for delta_e > 0. */
static double logit(const nqm_curve *curve, double delta_e) {
    return curve->b1 * (-pow(delta_e, curve->b3) - curve->b2);
}

double nqm_curve_jod(const nqm_curve *curve, double delta_e) {
    assert(curve);
    if (delta_e <= 0) /* the limit for b3 < 0, without computing 0 to a negative power */
        return 10;
    return 10 / (1 + exp(-logit(curve, delta_e))); /* equals 10 (1 - 1 / (1 + exp(z))), without cancellation */
}

double nqm_curve_slope(const nqm_curve *curve, double delta_e) {
    if (delta_e <= 0)
        return 0;
    const double z = logit(curve, delta_e), both = (1 + exp(-z)) * (1 + exp(z)); /* 1 / (share (1 - share)) */
    return isfinite(both) ? -10 / both * curve->b1 * curve->b3 * pow(delta_e, curve->b3 - 1) : 0;
}

double nqm_curve_delta_e(const nqm_curve *curve, double jod) {
    enum { MOST = 1000 };
    if (!(jod < 10))
        return jod >= 10 ? 0 : NAN;
    const double power = -log(fmax(jod, 1e-9) / (10 - jod)) / curve->b1 - curve->b2;
    return power > 0 ? fmin(pow(power, 1 / curve->b3), MOST) : MOST;
}

enum { MAX_SCORES = 100000000 }; /* cminpack counts in int */

typedef struct scores {
    size_t n;
    const double *delta_e, *jod; /* (n) */
} scores;

/* Called by cminpack; -1 ends the fit. */
static int find_residuals(void *user, int n, int n_coefficients, const double *b, double *residual, int call) {
    const scores *s = user;
    const nqm_curve curve = {b[0], b[1], b[2]};
    bool is_finite = true;
    (void)n_coefficients, (void)call;
    for (int i = 0; i < n; ++i) {
        residual[i] = nqm_curve_jod(&curve, s->delta_e[i]) - s->jod[i];
        is_finite = is_finite && isfinite(residual[i]);
    }
    return is_finite ? 0 : -1;
}

/* Fit b1, b2 for a fixed b3: logit(JOD / 10) = -b1 dE^b3 - b1 b2. false when the scores do not determine the line. */
static bool start_for_exponent(const scores *s, double b3, double *b) {
    double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (size_t i = 0; i < s->n; ++i) {
        if (s->delta_e[i] <= 0)
            continue;
        double x = pow(s->delta_e[i], b3);
        double jod = fmin(fmax(s->jod[i], 0.1), 9.9); /* human scores may be outside the range of the curve */
        double y = log(jod / (10 - jod));
        n += 1;
        sx += x;
        sy += y;
        sxx += x * x;
        sxy += x * y;
    }
    double variance = n * sxx - sx * sx;
    if (!(variance > 1e-12 * n * sxx))
        return false;
    double slope = (n * sxy - sx * sy) / variance;
    double intercept = (sy - slope * sx) / n;
    b[0] = -slope;
    b[1] = slope != 0 ? intercept / slope : 0;
    b[2] = b3;
    return slope != 0;
}

static nqm_status check_scores(const scores *s, nqm_error *err) {
    if (s->n < 4)
        return nqm_fail(err, NQM_ERR_ARG, -1, "regression of the JOD curve needs 4 scores at least, not %zu", s->n);
    if (s->n > MAX_SCORES)
        return nqm_fail(err, NQM_ERR_LIMIT, -1, "regression of the JOD curve: %zu scores; at most %d are possible",
                        s->n, MAX_SCORES);
    for (size_t i = 0; i < s->n; ++i)
        if (!isfinite(s->delta_e[i]) || !isfinite(s->jod[i]))
            return nqm_fail(err, NQM_ERR_ARG, -1, "regression of the JOD curve: score %zu is not finite", i + 1);
    return NQM_OK;
}

/* Minimise from b on; *rmse is infinite if cminpack gave up. */
static nqm_status solve(const scores *s, double *b, double *rmse, nqm_error *err) {
    enum { N = 3 };
    const size_t n_scratch = (N + 1) * s->n + 5 * N;
    double *residual, *scratch, sum = 0;
    int pivot[N];
    nqm_status status =
        nqm_alloc_arrays(NQM_ARRAYS({&residual, s->n, sizeof(double)}, {&scratch, n_scratch, sizeof(double)}), err);
    if (status != NQM_OK)
        return status;
    const int info =
        lmdif1(find_residuals, (void *)(uintptr_t)s, (int)s->n, N, b, residual, 1e-12, pivot, scratch, (int)n_scratch);
    for (size_t i = 0; i < s->n; ++i)
        sum += residual[i] * residual[i];
    *rmse = info > 0 ? sqrt(sum / (double)s->n) : INFINITY;
    nqm_free(residual);
    return NQM_OK;
}

/* The best fit from several starts; *rmse is infinite if there is none. */
static nqm_status solve_from_starts(const scores *s, double *best, double *rmse, nqm_error *err) {
    static const double exponents[] = {-0.1, -0.2, -0.4, -0.8, -1.6, 0.2, 0.5, 1};
    *rmse = INFINITY;
    for (size_t i = 0; i < sizeof exponents / sizeof *exponents; ++i) {
        double b[3], rmse_i;
        if (!start_for_exponent(s, exponents[i], b))
            continue;
        const nqm_status status = solve(s, b, &rmse_i, err);
        if (status != NQM_OK)
            return status;
        if (rmse_i < *rmse) {
            *rmse = rmse_i;
            memcpy(best, b, sizeof b);
        }
    }
    return NQM_OK;
}

/* Some starts take hundreds of steps: with many scores, evenly spaced ones of them select the start of the fit to all. */
static nqm_status solve_from_sample(const scores *s, double *best, double *rmse, nqm_error *err) {
    enum { N_SAMPLE = 4096 };
    double *delta_e, *jod;
    if (s->n <= N_SAMPLE)
        return solve_from_starts(s, best, rmse, err);
    nqm_status status =
        nqm_alloc_arrays(NQM_ARRAYS({&delta_e, N_SAMPLE, sizeof *delta_e}, {&jod, N_SAMPLE, sizeof *jod}), err);
    for (size_t i = 0; status == NQM_OK && i < N_SAMPLE; ++i) {
        delta_e[i] = s->delta_e[i * s->n / N_SAMPLE];
        jod[i] = s->jod[i * s->n / N_SAMPLE];
    }
    if (status == NQM_OK)
        status = solve_from_starts(&(scores){N_SAMPLE, delta_e, jod}, best, rmse, err);
    if (status == NQM_OK && isfinite(*rmse))
        status = solve(s, best, rmse, err);
    nqm_free(delta_e);
    return status;
}

nqm_status nqm_regress(size_t n, const double *delta_e, const double *jod, nqm_regress_report *report_ret,
                       nqm_error *err) {
    NQM_REQUIRE(err, delta_e, jod, report_ret);
    const scores s = {.n = n, .delta_e = delta_e, .jod = jod};
    nqm_status status = check_scores(&s, err);
    if (status != NQM_OK)
        return status;
    double b[3], rmse;
    status = solve_from_sample(&s, b, &rmse, err);
    if (status != NQM_OK)
        return status;
    if (!isfinite(rmse))
        return nqm_fail(err, NQM_ERR_NUMERIC, -1, "regression of the JOD curve: the scores do not determine it");
    *report_ret = (nqm_regress_report){
        .curve = {b[0], b[1], b[2]}, .rmse = rmse, .n = n, .spearman = nqm_spearman(n, delta_e, jod)};
    return NQM_OK;
}
