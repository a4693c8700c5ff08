/* SPDX-License-Identifier: MIT
 *
 * The last stage of the fit of a shading model: keys get their defaults where the loss hardly changes.
 */
#include "fit/fit.h"

#include <math.h>

typedef struct simplification {
    nqm_fit_objective *objective;
    const nqm_fit_target *target; /* of its terms */
    nqm_fit_space space;          /* without the keys that have been decided */
    double budget;                /* of the loss */
    nqm_ticker *ticker;
    nqm_fit_point *point;
    nqm_error *err;
} simplification;

static bool has_value(const nqm_values *values, size_t key, double v) {
    return values->v[key][0] == v && values->v[key][1] == v && values->v[key][2] == v;
}

/* Replace the point by one of least squares near it if that has the smaller loss: exact where keys make up for each other. */
static nqm_status adapt(const simplification *s, const nqm_fit_space *space, nqm_fit_point *point) {
    enum { N_STEPS = 3 };
    nqm_fit_point next = *point;
    nqm_status status = nqm_fit_refine(space, s->target, N_STEPS, s->ticker, &next, s->err);
    if (status == NQM_OK)
        status = nqm_fit_objective_value(s->objective, &next.values, &next.loss, s->err);
    if (status == NQM_OK && next.loss < point->loss)
        *point = next;
    return status;
}

/* Give a free key one value if the loss with the best values of the others stays within the budget. */
static nqm_status try_value(simplification *s, size_t key, double v) {
    enum { TRIAL_STEPS = 8 };
    nqm_fit_space without = s->space;
    nqm_fit_point next = *s->point;
    nqm_fit_fix(&without, key);
    if (without.n == s->space.n)
        return NQM_OK;
    for (size_t c = 0; c < 3; ++c)
        next.values.v[key][c] = v;
    nqm_status status = nqm_fit_objective_value(s->objective, &next.values, &next.loss, s->err);
    if (status == NQM_OK && next.loss > s->budget)
        status = adapt(s, &without, &next);
    if (status == NQM_OK && next.loss > s->budget)
        status = nqm_fit_descend(s->objective, &without, TRIAL_STEPS, s->ticker, &next, s->err);
    if (status == NQM_OK && next.loss <= s->budget) {
        *s->point = next;
        s->space = without;
    }
    return status;
}

/* Metals become 0 or 1; then defaults: of layers first, and of the last keys of the schema, which are extensions, before
 * others. */
static nqm_status try_all(simplification *s) {
    const nqm_schema *schema = s->space.model->schema;
    nqm_status status = NQM_OK;
    for (size_t k = 0; status == NQM_OK && k < schema->n_keys; ++k)
        if (schema->keys[k].role == NQM_ROLE_METAL)
            status = try_value(s, k, round(s->point->values.v[k][0]));
    for (size_t i = 2 * schema->n_keys; status == NQM_OK && i-- > 0;) {
        const size_t k = i % schema->n_keys;
        const nqm_schema_key *key = &schema->keys[k];
        const bool is_first = i >= schema->n_keys;
        if (is_first == nqm_schema_is_layer(schema, k) && !key->required &&
            !has_value(&s->point->values, k, key->fallback))
            status = try_value(s, k, key->fallback);
    }
    return status;
}

static nqm_status simplify(nqm_fit_objective *objective, const nqm_fit_target *target, nqm_fit_run *run,
                           nqm_fit_space *space, nqm_fit_point *point) {
    const double share_of_black = 0.05; /* exact fits have no loss to compare with */
    double black;
    simplification s = {.objective = objective,
                        .target = target,
                        .space = *space,
                        .ticker = &run->ticker,
                        .point = point,
                        .err = run->err};
    nqm_status status = nqm_fit_objective_black(objective, &black, run->err);
    if (status == NQM_OK)
        status = nqm_fit_objective_value(objective, &point->values, &point->loss, run->err);
    if (status != NQM_OK)
        return status;
    s.budget = point->loss + run->options->simplify * (point->loss + share_of_black * black);
    status = try_all(&s);
    *space = s.space;
    return status;
}

nqm_status nqm_fit_simplify(nqm_fit_run *run, nqm_fit_point *point) {
    enum { THIN = 600 };
    nqm_fit_space space = run->space;
    nqm_fit_target target = {0};
    nqm_fit_objective *objective = NULL;
    if (run->space.entry->n_shape || run->options->simplify <= 0)
        return NQM_OK;
    nqm_status status = nqm_fit_target_thin(&run->target, THIN, &target, run->err);
    if (status == NQM_OK)
        status = nqm_fit_objective_make(&space, &target, run->n_terms, run->terms, &objective, run->err);
    if (status == NQM_OK)
        status = simplify(objective, &target, run, &space, point);
    if (status == NQM_OK)
        status = nqm_fit_descend(run->objective, &space, NQM_FIT_STEPS, &run->ticker, point, run->err);
    nqm_fit_objective_free(objective);
    nqm_free(target.wi);
    return status;
}
