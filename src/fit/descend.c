/* SPDX-License-Identifier: MIT
 *
 * Minimisation of a sum of terms by BFGS updates with Powell's damping (Nocedal and Wright 2006, section 18.3, DOI
 * 10.1007/978-0-387-40065-5) of a full matrix that starts as the curvature of least squares: L-BFGS needs five times as many
 * gradients. Bounds as in squares.c.
 */
#include "fit/fit.h"

#include <math.h>

typedef struct descent {
    nqm_fit_objective *objective;
    const nqm_fit_space *space;
    nqm_ticker *ticker;
    size_t n;
    double *matrix, *factor;                      /* (n, n); matrix owns the block */
    double *x, *next, *low, *high;                /* (n) */
    double *gradient, *next_gradient, *step, *bs; /* (n) */
    bool *fixed;                                  /* (n) */
} descent;

static nqm_status alloc_descent(nqm_fit_objective *objective, const nqm_fit_space *space, nqm_ticker *ticker,
                                descent *d, nqm_error *err) {
    const size_t n = space->n, size = sizeof(double);
    *d = (descent){.objective = objective, .space = space, .ticker = ticker, .n = n};
    return nqm_alloc_arrays(NQM_ARRAYS({&d->matrix, n * n, size}, {&d->factor, n * n, size}, {&d->x, n, size},
                                       {&d->next, n, size}, {&d->low, n, size}, {&d->high, n, size},
                                       {&d->gradient, n, size}, {&d->next_gradient, n, size}, {&d->step, n, size},
                                       {&d->bs, n, size}, {&d->fixed, n, sizeof(bool)}),
                            err);
}

/* Go along the step until the sum falls; `next` receives the point. false: it does not. */
static nqm_status search_line(descent *d, const nqm_fit_point *point, nqm_fit_point *next, bool *found,
                              nqm_error *err) {
    enum { MAX_TRIES = 8 };
    const double longest = 1; /* per coordinate */
    double scale = 1, most = 0;
    for (size_t k = 0; k < d->n; ++k)
        most = fmax(most, fabs(d->step[k]));
    scale = most > longest ? longest / most : 1;
    *found = false;
    nqm_status status = NQM_OK;
    for (int i = 0; status == NQM_OK && !*found && i < MAX_TRIES; ++i, scale *= 0.35) {
        double expected = 0;
        for (size_t k = 0; k < d->n; ++k) {
            d->next[k] = fmin(fmax(d->x[k] + scale * d->step[k], d->low[k]), d->high[k]);
            expected += d->gradient[k] * (d->next[k] - d->x[k]);
        }
        *next = *point;
        nqm_fit_values(d->space, d->next, &next->values);
        status = nqm_fit_objective_value(d->objective, &next->values, &next->loss, err);
        *found = next->loss < point->loss + fmin(1e-4 * expected, 0);
    }
    return status;
}

/* Update the matrix by the step just made, from x to next. */
static void update(descent *d) {
    const size_t n = d->n;
    double s_bs = 0, s_y = 0;
    for (size_t a = 0; a < n; ++a) {
        d->bs[a] = 0;
        for (size_t b = 0; b < n; ++b)
            d->bs[a] += d->matrix[a * n + b] * (d->next[b] - d->x[b]);
        s_bs += d->bs[a] * (d->next[a] - d->x[a]);
        s_y += (d->next_gradient[a] - d->gradient[a]) * (d->next[a] - d->x[a]);
    }
    if (!(s_bs > 0))
        return;
    const double theta = s_y >= 0.2 * s_bs ? 1 : 0.8 * s_bs / (s_bs - s_y);
    for (size_t a = 0; a < n; ++a) /* the damped difference of gradients replaces the step's buffer */
        d->step[a] = theta * (d->next_gradient[a] - d->gradient[a]) + (1 - theta) * d->bs[a];
    const double s_r = theta * s_y + (1 - theta) * s_bs;
    for (size_t a = 0; a < n; ++a)
        for (size_t b = 0; b < n; ++b)
            d->matrix[a * n + b] += d->step[a] * d->step[b] / s_r - d->bs[a] * d->bs[b] / s_bs;
}

/* One step; *gained: the point is better by more than the tolerance. */
static nqm_status advance(descent *d, nqm_fit_point *point, bool *gained, nqm_error *err) {
    const double tolerance = 3e-4; /* relative, of the loss per step */
    nqm_fit_point next;
    for (size_t k = 0; k < d->n; ++k)
        d->fixed[k] = (d->x[k] <= d->low[k] && d->gradient[k] >= 0) || (d->x[k] >= d->high[k] && d->gradient[k] <= 0);
    nqm_fit_solve(d->n, d->matrix, d->fixed, d->gradient, 0, d->factor, d->step);
    nqm_status status = search_line(d, point, &next, gained, err);
    if (status != NQM_OK || !*gained)
        return status;
    status = nqm_fit_objective_gradient(d->objective, d->space, &next.values, d->next_gradient, err);
    if (status != NQM_OK)
        return status;
    update(d);
    memcpy(d->x, d->next, d->n * sizeof *d->x);
    memcpy(d->gradient, d->next_gradient, d->n * sizeof *d->gradient);
    *gained = next.loss < (1 - tolerance) * point->loss;
    *point = next;
    return status;
}

/* Descend under the present rounding; point->loss is that of the rounded sum. */
static nqm_status run(descent *d, size_t max_steps, nqm_fit_point *point, nqm_error *err) {
    enum { MAX_SLOW = 3 };
    nqm_status status = nqm_fit_objective_value(d->objective, &point->values, &point->loss, err);
    if (status == NQM_OK)
        status = nqm_fit_objective_curvature(d->objective, d->space, &point->values, d->matrix, err);
    if (status != NQM_OK)
        return status;
    nqm_fit_coordinates(d->space, &point->values, d->x);
    nqm_fit_bounds(d->space, d->low, d->high);
    status = nqm_fit_objective_gradient(d->objective, d->space, &point->values, d->gradient, err);
    int n_slow = 0;
    for (size_t i = 0; status == NQM_OK && i < max_steps && n_slow < MAX_SLOW; ++i) {
        bool gained;
        const double before = point->loss;
        status = advance(d, point, &gained, err);
        if (status != NQM_OK || point->loss == before)
            break;
        n_slow = gained ? 0 : n_slow + 1;
        status = nqm_fit_tick(d->ticker, "polish", (double)i, (double)max_steps + 1, err);
    }
    return status;
}

nqm_status nqm_fit_descend(nqm_fit_objective *o, const nqm_fit_space *space, size_t max_steps, nqm_ticker *ticker,
                           nqm_fit_point *point, nqm_error *err) {
    static const double rounding[] = {0.3, 0.03};
    const bool is_short = max_steps < NQM_FIT_STEPS;
    descent d;
    nqm_fit_point best = *point;
    nqm_status status = alloc_descent(o, space, ticker, &d, err);
    if (status == NQM_OK)
        status = nqm_fit_objective_value(o, &point->values, &point->loss, err);
    const bool rounded = status == NQM_OK && nqm_fit_objective_round(o, rounding[0]);
    if (status == NQM_OK)
        status = run(&d, max_steps, &best, err);
    if (status == NQM_OK && rounded && !is_short && nqm_fit_objective_round(o, rounding[1]))
        status = run(&d, max_steps, &best, err);
    nqm_fit_objective_round(o, 0);
    if (status == NQM_OK)
        status = nqm_fit_objective_value(o, &best.values, &best.loss, err);
    if (status == NQM_OK && best.loss < point->loss)
        *point = best;
    nqm_free(d.matrix);
    return status;
}
