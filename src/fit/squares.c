/* SPDX-License-Identifier: MIT
 *
 * Levenberg-Marquardt with bounds (Kanzow, Yamashita and Fukushima 2004, DOI 10.1016/j.cam.2004.02.013, without its line
 * search): parameters at a bound that the gradient pushes outwards are left out of the step, the others are moved into their
 * bounds after it. Mean absolute losses are minimised as reweighted squares.
 */
#include "fit/fit.h"

#include <math.h>

nqm_status nqm_fit_tick(nqm_ticker *ticker, const char *stage, double done, double total, nqm_error *err) {
    return nqm_tick(ticker, stage, done, total) ? nqm_fail(err, NQM_ERR_CANCELLED, -1, "interrupted") : NQM_OK;
}

void nqm_fit_solve(size_t n, const double *curvature, const bool *fixed, const double *gradient, double damping,
                   double *factor, double *step) {
    double *l = factor;
    for (size_t a = 0; a < n; ++a)
        for (size_t b = 0; b <= a; ++b) {
            double sum = a != b && (fixed[a] || fixed[b]) ? 0 : curvature[a * n + b] * (a == b ? 1 + damping : 1);
            for (size_t k = 0; k < b; ++k)
                sum -= l[a * n + k] * l[b * n + k];
            if (a != b)
                l[a * n + b] = sum / l[b * n + b];
            else /* dependent parameters: a tiny pivot would give a huge step */
                l[a * n + a] = sqrt(fmax(sum, 1e-12 * curvature[a * n + a] + 1e-300));
        }
    for (size_t a = 0; a < n; ++a) {
        double sum = fixed[a] ? 0 : -gradient[a];
        for (size_t k = 0; k < a; ++k)
            sum -= l[a * n + k] * step[k];
        step[a] = sum / l[a * n + a];
    }
    for (size_t a = n; a-- > 0;) {
        double sum = step[a];
        for (size_t k = a + 1; k < n; ++k)
            sum -= l[k * n + a] * step[k];
        step[a] = sum / l[a * n + a];
    }
}

typedef struct squares {
    const nqm_fit_space *space;
    const nqm_fit_target *target;
    size_t m;                    /* residuals: 3 per direction */
    double *rgb, *changed;       /* (m) f_r at the point and next to it; rgb owns the block */
    double *residual, *weight;   /* (m) */
    double *columns;             /* (space->n, m) derivatives of the residuals */
    double *normal, *factor;     /* (space->n, space->n) */
    double *gradient, *step, *x; /* (space->n) */
    double *low, *high, *next;   /* (space->n) */
    bool *fixed;                 /* (space->n) not part of this step */
} squares;

static nqm_status alloc_squares(const nqm_fit_space *space, const nqm_fit_target *target, squares *s, nqm_error *err) {
    const size_t n = space->n, m = 3 * target->n, size = sizeof(double);
    *s = (squares){.space = space, .target = target, .m = m};
    return nqm_alloc_arrays(NQM_ARRAYS({&s->rgb, m, size}, {&s->changed, m, size}, {&s->residual, m, size},
                                       {&s->weight, m, size}, {&s->columns, n * m, size}, {&s->normal, n * n, size},
                                       {&s->factor, n * n, size}, {&s->gradient, n, size}, {&s->step, n, size},
                                       {&s->x, n, size}, {&s->low, n, size}, {&s->high, n, size}, {&s->next, n, size},
                                       {&s->fixed, n, sizeof(bool)}),
                            err);
}

/* f_r of the values with the coordinates x. */
static void eval_at(const squares *s, const double *x, nqm_values *values, double *rgb) {
    nqm_fit_values(s->space, x, values);
    nqm_fit_eval(s->space, values, s->target->n, s->target->wi, s->target->wo, rgb);
}

/* The residuals, and the weights that make their squares the target's loss. */
static void linearise(squares *s) {
    const nqm_fit_target *t = s->target;
    double mean = 0;
    for (size_t i = 0; i < s->m; ++i) {
        s->residual[i] = nqm_fit_transform(t->loss, t->weight[i / 3], s->rgb[i]) - t->goal[i];
        mean += fabs(s->residual[i]) / (double)s->m;
    }
    const double rounding = 0.1 * mean + 1e-12;
    for (size_t i = 0; i < s->m; ++i)
        s->weight[i] = nqm_fit_losses[t->loss].power == 2 ? 1 : 1 / hypot(s->residual[i], rounding);
}

static void differentiate(squares *s, const nqm_values *values) {
    const nqm_fit_target *t = s->target;
    nqm_fit_slopes(s->space, values, t->n, t->wi, t->wo, s->rgb, s->columns);
    for (size_t i = 0; i < s->m; ++i) {
        const double slope = nqm_fit_transform_slope(t->loss, t->weight[i / 3], s->rgb[i]);
        for (size_t k = 0; k < s->space->n; ++k)
            s->columns[k * s->m + i] *= slope;
    }
}

/* The normal equations of the weighted residuals. */
static void form_normal(squares *s) {
    const size_t n = s->space->n;
    for (size_t a = 0; a < n; ++a) {
        const double *column = s->columns + a * s->m;
        double sum = 0;
        for (size_t i = 0; i < s->m; ++i)
            sum += s->weight[i] * column[i] * s->residual[i];
        s->gradient[a] = sum;
        for (size_t b = 0; b <= a; ++b) {
            const double *other = s->columns + b * s->m;
            sum = 0;
            for (size_t i = 0; i < s->m; ++i)
                sum += s->weight[i] * column[i] * other[i];
            s->normal[a * n + b] = s->normal[b * n + a] = sum;
        }
        s->fixed[a] = s->normal[a * n + a] <= 0 || (s->x[a] <= s->low[a] && s->gradient[a] >= 0) ||
                      (s->x[a] >= s->high[a] && s->gradient[a] <= 0);
    }
}

/* Evaluate at the point and form the equations. */
static void begin(squares *s, const nqm_values *values) {
    nqm_values at = *values;
    nqm_fit_coordinates(s->space, values, s->x);
    nqm_fit_bounds(s->space, s->low, s->high);
    eval_at(s, s->x, &at, s->rgb);
}

nqm_status nqm_fit_curvature(const nqm_fit_space *space, const nqm_fit_target *target, const nqm_values *values,
                             double *curvature, nqm_error *err) {
    squares s;
    nqm_status status = alloc_squares(space, target, &s, err);
    if (status != NQM_OK)
        return status;
    begin(&s, values);
    linearise(&s);
    differentiate(&s, values);
    form_normal(&s);
    const double loss = nqm_fit_losses[target->loss].power == 2 ? nqm_fit_loss_value(target, s.rgb, NULL) : 1;
    for (size_t i = 0; i < space->n * space->n; ++i)
        curvature[i] = s.normal[i] / ((double)s.m * fmax(loss, 1e-12));
    nqm_free(s.rgb);
    return NQM_OK;
}

/* Try steps with growing damping until one lowers the loss; false: none does. */
static bool improve(squares *s, double *damping, nqm_fit_point *point) {
    enum { MAX_TRIES = 10 };
    const double longest = 2; /* per coordinate */
    for (int i = 0; i < MAX_TRIES; ++i) {
        nqm_values values = point->values;
        nqm_fit_solve(s->space->n, s->normal, s->fixed, s->gradient, *damping, s->factor, s->step);
        for (size_t k = 0; k < s->space->n; ++k)
            s->next[k] = fmin(fmax(s->x[k] + fmin(fmax(s->step[k], -longest), longest), s->low[k]), s->high[k]);
        eval_at(s, s->next, &values, s->changed);
        const double loss = nqm_fit_loss_value(s->target, s->changed, NULL);
        if (loss < point->loss) {
            point->values = values;
            point->loss = loss;
            memcpy(s->x, s->next, s->space->n * sizeof *s->x);
            memcpy(s->rgb, s->changed, s->m * sizeof *s->rgb);
            *damping = fmax(*damping / 8, 1e-10);
            return true;
        }
        *damping *= 4;
    }
    return false;
}

nqm_status nqm_fit_refine(const nqm_fit_space *space, const nqm_fit_target *target, size_t n_steps, nqm_ticker *ticker,
                          nqm_fit_point *point, nqm_error *err) {
    const double min_gain = 1e-4; /* relative, of the loss per step */
    const double exact = 1e-6;    /* of the loss of a black surface */
    squares s;
    double damping = 1e-2;
    nqm_status status = alloc_squares(space, target, &s, err);
    if (status != NQM_OK)
        return status;
    begin(&s, &point->values);
    point->loss = nqm_fit_loss_value(target, s.rgb, NULL);
    const double done = exact * nqm_fit_loss_value(target, s.changed, NULL); /* zeros so far */
    int n_slow = 0;
    for (size_t i = 0; status == NQM_OK && i < n_steps && n_slow < 2 && point->loss > done; ++i) {
        const double before = point->loss;
        linearise(&s);
        differentiate(&s, &point->values);
        form_normal(&s);
        if (!improve(&s, &damping, point))
            break;
        n_slow = point->loss > (1 - min_gain) * before ? n_slow + 1 : 0;
        status = nqm_fit_tick(ticker, "fit", (double)i, (double)n_steps + 1, err);
    }
    nqm_free(s.rgb);
    return status;
}
