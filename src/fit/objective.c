/* SPDX-License-Identifier: MIT
 *
 * A weighted sum of terms as a function of the values of a model, and its gradient.
 */
#include "fit/fit.h"

#include <math.h>

/* A set of directions and the terms there. */
typedef struct part {
    nqm_fit_term term;
    nqm_fit_target target; /* of a BRDF-space term */
    size_t n;
    const double *wi, *wo;  /* (n, 3) borrowed */
    double *rgb, *gradient; /* (n, 3); rgb owns the block */
    double value;           /* of the last evaluation */
} part;

struct nqm_fit_objective {
    const nqm_fit_space *space;
    size_t n;
    part *parts; /* (n) */
};

static nqm_status make_part(const nqm_fit_target *target, const nqm_fit_term *term, part *p, nqm_error *err) {
    const nqm_fit_visual *visual = term->visual;
    nqm_status status = visual ? NQM_OK : nqm_fit_target_under(target, term->loss, &p->target, err);
    p->term = *term;
    p->n = visual ? visual->n : target->n;
    p->wi = visual ? visual->wi : target->wi;
    p->wo = visual ? visual->wo : target->wo;
    if (status == NQM_OK)
        status = nqm_alloc_arrays(
            NQM_ARRAYS({&p->rgb, p->n, 3 * sizeof(double)}, {&p->gradient, p->n, 3 * sizeof(double)}), err);
    return status;
}

nqm_status nqm_fit_objective_make(const nqm_fit_space *space, const nqm_fit_target *target, size_t n_terms,
                                  const nqm_fit_term *terms, nqm_fit_objective **objective_ret, nqm_error *err) {
    nqm_fit_objective *o;
    part *parts;
    *objective_ret = NULL;
    nqm_status status = nqm_alloc_arrays(NQM_ARRAYS({&o, 1, sizeof *o}, {&parts, n_terms, sizeof *parts}), err);
    if (status != NQM_OK)
        return status;
    *o = (nqm_fit_objective){.space = space, .n = n_terms, .parts = parts};
    for (size_t i = 0; status == NQM_OK && i < n_terms; ++i)
        status = make_part(target, &terms[i], &parts[i], err);
    if (status == NQM_OK)
        *objective_ret = o;
    else
        nqm_fit_objective_free(o);
    return status;
}

void nqm_fit_objective_free(nqm_fit_objective *o) {
    for (size_t i = 0; o && i < o->n; ++i) {
        nqm_free(o->parts[i].target.weight);
        nqm_free(o->parts[i].rgb);
    }
    nqm_free(o);
}

/* Set the value and the gradient by f_r of a part from its f_r; returns its term. */
static double evaluate(part *p) {
    const nqm_fit_visual *visual = p->term.visual;
    p->value =
        visual ? visual->eval(visual->user, p->rgb, p->gradient) : nqm_fit_loss_value(&p->target, p->rgb, p->gradient);
    return p->term.weight * p->value;
}

nqm_status nqm_fit_objective_value(nqm_fit_objective *o, const nqm_values *values, double *value, nqm_error *err) {
    double sum = 0;
    for (size_t i = 0; i < o->n; ++i) {
        part *p = &o->parts[i];
        nqm_fit_eval(o->space, values, p->n, p->wi, p->wo, p->rgb);
        sum += evaluate(p);
        if (!isfinite(sum))
            return nqm_fail(err, NQM_ERR_NUMERIC, -1, "the loss of the %s fit is not finite",
                            o->space->model->schema->model);
    }
    *value = sum;
    return NQM_OK;
}

nqm_status nqm_fit_objective_black(nqm_fit_objective *o, double *value, nqm_error *err) {
    *value = 0;
    for (size_t i = 0; i < o->n; ++i) {
        memset(o->parts[i].rgb, 0, 3 * o->parts[i].n * sizeof *o->parts[i].rgb);
        *value += evaluate(&o->parts[i]);
    }
    return isfinite(*value) ? NQM_OK : nqm_fail(err, NQM_ERR_NUMERIC, -1, "the loss of a black surface is not finite");
}

nqm_status nqm_fit_objective_gradient(nqm_fit_objective *o, const nqm_fit_space *space, const nqm_values *values,
                                      double *gradient, nqm_error *err) {
    memset(gradient, 0, space->n * sizeof *gradient);
    for (size_t i = 0; i < o->n; ++i) {
        const part *p = &o->parts[i];
        double *columns = nqm_alloc(3 * p->n * space->n, sizeof *columns);
        if (!columns)
            return nqm_fail_nomem(err, 3 * p->n * space->n * sizeof *columns);
        nqm_fit_slopes(space, values, p->n, p->wi, p->wo, p->rgb, columns);
        for (size_t k = 0; k < space->n; ++k)
            for (size_t j = 0; j < 3 * p->n; ++j)
                gradient[k] += p->term.weight * p->gradient[j] * columns[3 * p->n * k + j];
        nqm_free(columns);
    }
    return NQM_OK;
}

nqm_status nqm_fit_objective_curvature(const nqm_fit_objective *o, const nqm_fit_space *space, const nqm_values *values,
                                       double *curvature, nqm_error *err) {
    const size_t n = space->n;
    double between_values = 0, all = 0;
    double *one = nqm_alloc(n * n, sizeof *one);
    if (!one)
        return nqm_fail_nomem(err, n * n * sizeof *one);
    memset(curvature, 0, n * n * sizeof *curvature);
    nqm_status status = NQM_OK;
    for (size_t i = 0; status == NQM_OK && i < o->n; ++i) {
        const part *p = &o->parts[i];
        all += p->term.weight * p->value;
        if (p->term.visual)
            continue;
        between_values += p->term.weight * p->value;
        status = nqm_fit_curvature(space, &p->target, values, one, err);
        for (size_t k = 0; status == NQM_OK && k < n * n; ++k)
            curvature[k] += p->term.weight * one[k];
    }
    nqm_free(one);
    for (size_t k = 0; between_values > 0 && k < n * n; ++k)
        curvature[k] *= all / between_values;
    for (size_t k = 0; k < n; ++k) /* a unit of a coordinate changes f_r by about the factor e */
        curvature[k * n + k] += (between_values > 0 ? 1e-4 : 1) * fmax(all, 1e-12);
    return status;
}

bool nqm_fit_objective_round(nqm_fit_objective *o, double fraction) {
    bool any = false;
    for (size_t i = 0; i < o->n; ++i) {
        part *p = &o->parts[i];
        if (p->term.visual || nqm_fit_losses[p->term.loss].power != 1)
            continue;
        p->target.rounding = fraction * p->value;
        any = true;
    }
    return any;
}
