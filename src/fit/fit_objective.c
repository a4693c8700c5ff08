/* SPDX-License-Identifier: MIT
 *
 * A loss that is a weighted sum of terms, as a function of the values of a model, with its gradient. Every term has its
 * directions: those of the fit, or the caller's.
 */
#include "fit/fit.h"

#include <math.h>

static nqm_status make_part(const nqm_fit_entry *model, const nqm_fit_target *target, const nqm_fit_term *term,
                            nqm_fit_part *part, nqm_error *err) {
    const nqm_fit_visual *visual = term->visual;
    part->term = *term;
    nqm_status status = NQM_OK;
    if (visual)
        status = nqm_fit_lobes_make(model, visual->n, visual->wi, visual->wo, &part->lobes, err);
    else
        status = nqm_fit_target_under(target, term->loss, &part->target, err);
    if (status == NQM_OK && !visual)
        status = nqm_fit_lobes_make(model, target->n, target->wi, target->wo, &part->lobes, err);
    size_t n = part->lobes.n;
    if (status == NQM_OK)
        status =
            nqm_alloc_arrays(NQM_ARRAYS({&part->rgb, n, 3 * sizeof(double)}, {&part->gradient, n, 3 * sizeof(double)},
                                        {&part->slopes, n, model->n_shape * sizeof(double)}),
                             err);
    return status;
}

nqm_status nqm_fit_objective_make(const nqm_fit_entry *model, const nqm_fit_target *target, size_t n_terms,
                                  const nqm_fit_term *terms, nqm_fit_objective *objective, nqm_error *err) {
    *objective = (nqm_fit_objective){.model = model};
    objective->parts = nqm_alloc(n_terms, sizeof *objective->parts);
    if (!objective->parts)
        return nqm_fail_nomem(err, n_terms * sizeof *objective->parts);
    objective->n = n_terms;
    nqm_status status = NQM_OK;
    for (size_t i = 0; status == NQM_OK && i < n_terms; ++i)
        status = make_part(model, target, &terms[i], &objective->parts[i], err);
    return status;
}

void nqm_fit_objective_free(nqm_fit_objective *objective) {
    for (size_t i = 0; i < objective->n; ++i) {
        nqm_fit_part *part = &objective->parts[i];
        nqm_free(part->target.weight);
        nqm_free(part->lobes.rgb);
        nqm_free(part->rgb);
    }
    nqm_free(objective->parts);
}

/* Add weight times the derivatives of a part by the values of the model: the chain rule over f = kd D + ks L. */
static nqm_status add_gradient(nqm_fit_part *part, const nqm_fit_values *v, nqm_fit_values *sum, nqm_error *err) {
    const nqm_fit_lobes *lobes = &part->lobes;
    double weight = part->term.weight;
    for (size_t i = 0; i < lobes->n; ++i)
        for (size_t c = 0; c < 3; ++c) {
            sum->kd[c] += weight * part->gradient[3 * i + c] * lobes->diffuse[i];
            sum->ks[c] += weight * part->gradient[3 * i + c] * lobes->lobe[i];
        }
    nqm_status status = nqm_fit_lobes_slopes(&part->lobes, part->slopes, err);
    for (size_t k = 0; status == NQM_OK && k < lobes->model->n_shape; ++k)
        for (size_t i = 0; i < lobes->n; ++i)
            for (size_t c = 0; c < 3; ++c)
                sum->shape[k] += weight * part->gradient[3 * i + c] * v->ks[c] * part->slopes[k * lobes->n + i];
    return status;
}

nqm_status nqm_fit_objective_eval(nqm_fit_objective *objective, bool visual, const nqm_fit_values *v, double *value,
                                  nqm_fit_values *gradient, nqm_error *err) {
    double sum = 0;
    nqm_fit_values slopes = {.kd = {0}};
    for (size_t i = 0; i < objective->n; ++i) {
        nqm_fit_part *part = &objective->parts[i];
        const nqm_fit_visual *theirs = part->term.visual;
        if (theirs && !visual)
            continue;
        nqm_status status = nqm_fit_lobes_set(&part->lobes, v->shape, err);
        if (status != NQM_OK)
            return status;
        nqm_fit_lobes_combine(&part->lobes, v, part->rgb);
        part->value = (theirs ? theirs->eval(theirs->user, part->rgb, part->gradient)
                              : nqm_fit_loss_value(&part->target, part->rgb, part->gradient));
        sum += part->term.weight * part->value;
        if (!isfinite(sum))
            return nqm_fail(err, NQM_ERR_NUMERIC, -1, "the loss of the %s fit is not finite", objective->model->name);
        if (gradient)
            status = add_gradient(part, v, &slopes, err);
        if (status != NQM_OK)
            return status;
    }
    *value = sum;
    if (gradient)
        *gradient = slopes;
    return NQM_OK;
}
