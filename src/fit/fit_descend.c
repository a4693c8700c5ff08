/* SPDX-License-Identifier: MIT
 *
 * Minimisation of a weighted sum by L-BFGS with bounds (NLopt: Johnson, The NLopt nonlinear-optimization package; the
 * method: Nocedal 1980, DOI 10.1090/S0025-5718-1980-0572855-7). Coordinates: positions of the shapes in their ranges, and
 * log(albedo + offset), in which an albedo of 0 is a point like any other.
 */
#include "fit/fit.h"

#include <math.h>
#include <nlopt.h>

enum { MAX_PARAMETERS = 6 + NQM_FIT_MAX_SHAPE, MAX_EVALUATIONS = 200, MAX_RUNS = 6 };
static const double SHAPE_UNITS = 8; /* of a whole range: a unit changes a lobe about as much as a unit of log(ks) */
/* Smaller: fits from random starts stay at albedos of 0, where the loss hardly changes. */
static const double OFFSET = 0.05;

typedef struct descent {
    nqm_fit_objective *objective;
    bool visual;
    nqm_ticker *ticker;
    nlopt_opt solver;
    nqm_fit_candidate *best;
    size_t n_evaluations;
    nqm_status failure;
    nqm_error *err;
} descent;

static double clamp(double x, double low, double high) {
    return x < low ? low : x > high ? high : x;
}

static void to_scaled(const nqm_fit_entry *model, const nqm_fit_values *v, double *x) {
    for (size_t k = 0; k < model->n_shape; ++k)
        *x++ = SHAPE_UNITS * clamp(nqm_fit_shape_position(&model->shape[k], v->shape[k]), 0, 1);
    for (size_t c = 0; c < 3; ++c) {
        x[c] = log(fmin(v->kd[c], NQM_FIT_MAX_KD) + OFFSET);
        x[3 + c] = log(fmin(v->ks[c], NQM_FIT_MAX_KS) + OFFSET);
    }
}

/* Rounding makes 0 a trace. */
static double albedo(double x, double high) {
    double value = clamp(exp(x) - OFFSET, 0, high);
    return value < 1e-7 ? 0 : value;
}

static void from_scaled(const nqm_fit_entry *model, const double *x, nqm_fit_values *v) {
    for (size_t k = 0; k < model->n_shape; ++k)
        v->shape[k] = nqm_fit_shape_value(&model->shape[k], clamp(*x++ / SHAPE_UNITS, 0, 1));
    for (size_t c = 0; c < 3; ++c) {
        v->kd[c] = albedo(x[c], NQM_FIT_MAX_KD);
        v->ks[c] = albedo(x[3 + c], NQM_FIT_MAX_KS);
    }
}

static void set_bounds(const nqm_fit_entry *model, double *low, double *high) {
    for (size_t k = 0; k < model->n_shape; ++k) {
        *low++ = 0;
        *high++ = SHAPE_UNITS;
    }
    for (size_t c = 0; c < 6; ++c) {
        low[c] = log(OFFSET);
        high[c] = log((c < 3 ? NQM_FIT_MAX_KD : NQM_FIT_MAX_KS) + OFFSET);
    }
}

/* The derivatives by the scaled coordinates x. */
static void scale_gradient(const nqm_fit_entry *model, const double *x, const nqm_fit_values *slopes,
                           double *gradient) {
    for (size_t k = 0; k < model->n_shape; ++k)
        gradient[k] = slopes->shape[k] / SHAPE_UNITS;
    for (size_t c = 0; c < 3; ++c) {
        size_t kd = model->n_shape + c, ks = kd + 3;
        gradient[kd] = slopes->kd[c] * exp(x[kd]);
        gradient[ks] = slopes->ks[c] * exp(x[ks]);
    }
}

static double evaluate(unsigned n, const double *x, double *gradient, void *user) {
    (void)n;
    descent *d = user;
    const nqm_fit_entry *model = d->objective->model;
    nqm_fit_values v = {.kd = {0}}, slopes;
    double value = 0;
    from_scaled(model, x, &v);
    if (nqm_tick(d->ticker, "polish", (double)nqm_smaller(d->n_evaluations++, MAX_EVALUATIONS - 1), MAX_EVALUATIONS))
        d->failure = nqm_fit_cancelled(d->err);
    if (d->failure == NQM_OK)
        d->failure = nqm_fit_objective_eval(d->objective, d->visual, &v, &value, gradient ? &slopes : NULL, d->err);
    if (d->failure != NQM_OK) {
        nlopt_force_stop(d->solver);
        return INFINITY;
    }
    if (gradient)
        scale_gradient(model, x, &slopes, gradient);
    if (value < d->best->loss) {
        d->best->values = v;
        d->best->loss = value;
    }
    return value;
}

/* One run from the best point so far; results other than a stop need no check, because the best point is kept. */
static nqm_status run(descent *d) {
    const double tolerance = 1e-7; /* relative, of the loss */
    const nqm_fit_entry *model = d->objective->model;
    double x[MAX_PARAMETERS], low[MAX_PARAMETERS], high[MAX_PARAMETERS], value;
    d->solver = nlopt_create(NLOPT_LD_LBFGS, (unsigned)(model->n_shape + 6));
    if (!d->solver)
        return nqm_fail_nomem(d->err, sizeof x);
    to_scaled(model, &d->best->values, x);
    set_bounds(model, low, high);
    nlopt_set_lower_bounds(d->solver, low);
    nlopt_set_upper_bounds(d->solver, high);
    nlopt_set_min_objective(d->solver, evaluate, d);
    nlopt_set_ftol_rel(d->solver, tolerance);
    nlopt_set_maxeval(d->solver, MAX_EVALUATIONS);
    nlopt_optimize(d->solver, x, &value);
    nlopt_destroy(d->solver);
    return d->failure;
}

static bool has_kinks(const nqm_fit_part *part) {
    return !part->term.visual && nqm_fit_losses[part->term.loss].power == 1;
}

/* Evaluate the loss at the best values so far, then round the kinks of mean absolute losses over `fraction` of their
 * value. */
static nqm_status begin_stage(descent *d, double fraction) {
    nqm_fit_objective *objective = d->objective;
    for (size_t i = 0; i < objective->n; ++i)
        objective->parts[i].target.rounding = 0;
    nqm_status status = nqm_fit_objective_eval(objective, d->visual, &d->best->values, &d->best->loss, NULL, d->err);
    for (size_t i = 0; status == NQM_OK && fraction > 0 && i < objective->n; ++i)
        if (has_kinks(&objective->parts[i])) {
            objective->parts[i].target.rounding = fraction * objective->parts[i].value;
            d->best->loss = INFINITY; /* values of a rounded loss are smaller */
        }
    return status;
}

/* Run again, which forgets the curvature, while that gains. */
static nqm_status run_stage(descent *d) {
    const double min_gain = 1e-3; /* relative, of the loss per run */
    nqm_status status = NQM_OK;
    double before = INFINITY;
    for (int i = 0; status == NQM_OK && i < MAX_RUNS && d->best->loss < (1 - min_gain) * before; ++i) {
        before = d->best->loss;
        status = run(d);
    }
    return status;
}

/* The line search ends early at kinks, where several coordinates must change together: the first stages see them rounded. */
nqm_status nqm_fit_descend(nqm_fit_objective *objective, bool visual, nqm_ticker *ticker, nqm_fit_candidate *candidate,
                           nqm_error *err) {
    static const double rounding[] = {1, 0.1, 0.01};
    nqm_fit_candidate best = *candidate;
    descent d = {.objective = objective, .visual = visual, .ticker = ticker, .best = &best, .err = err};
    bool kinks = false;
    for (size_t i = 0; i < objective->n; ++i)
        kinks |= has_kinks(&objective->parts[i]);
    nqm_status status = begin_stage(&d, 0);
    *candidate = best;
    for (size_t i = 0; status == NQM_OK && kinks && i < sizeof rounding / sizeof *rounding; ++i) {
        status = begin_stage(&d, rounding[i]);
        if (status == NQM_OK)
            status = run(&d);
    }
    if (status == NQM_OK && kinks)
        status = begin_stage(&d, 0);
    if (status == NQM_OK)
        status = run_stage(&d);
    if (status == NQM_OK && best.loss < candidate->loss)
        *candidate = best;
    return status;
}
