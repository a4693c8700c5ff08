/* SPDX-License-Identifier: MIT
 *
 * The stages of a fit: least squares from each start, then the BRDF-space terms, then the whole loss. A loss that is one
 * root mean square ends with the first stage.
 */
#include "brdf/core/spec.h"
#include "fit/fit.h"

#include <math.h>

static bool is_square(const nqm_fit_options *options) {
    if (options->n_terms == 0)
        return nqm_fit_losses[options->loss].power == 2;
    return options->n_terms == 1 && !options->terms->visual && nqm_fit_losses[options->terms->loss].power == 2;
}

nqm_fit_loss nqm_fit_first_loss(const nqm_fit_options *options) {
    nqm_fit_loss loss = options->n_terms ? NQM_FIT_LOG : options->loss;
    double weight = 0;
    for (size_t i = 0; i < options->n_terms; ++i)
        if (!options->terms[i].visual && options->terms[i].weight > weight) {
            loss = options->terms[i].loss;
            weight = options->terms[i].weight;
        }
    return loss;
}

/* ---- starts ------------------------------------------------------------------------------------------------------ */

static double clamp(double x, double low, double high) {
    return x < low ? low : x > high ? high : x;
}

/* The values of a key; NULL when the model has no such key. */
static const double *values_of(const nqm_spec_schema *schema, const nqm_spec_values *values, const char *key) {
    for (size_t k = 0; k < schema->n_keys; ++k)
        if (strcmp(schema->keys[k].name, key) == 0)
            return values->v[k];
    return NULL;
}

nqm_status nqm_fit_read_spec(const nqm_fit_entry *model, const char *spec, nqm_fit_values *values, nqm_error *err) {
    size_t n = strlen(model->name);
    if (strncmp(spec, model->name, n) != 0 || spec[n] != ':')
        return nqm_fail(err, NQM_ERR_ARG, -1, "a %s fit cannot start from '%.80s'", model->name, spec);
    const nqm_spec_schema *schema = &nqm_analytic_model_find(model->name, n)->schema;
    nqm_spec_values parsed;
    nqm_status status = nqm_spec_parse(schema, spec + n + 1, &parsed, err);
    if (status != NQM_OK)
        return status;
    memcpy(values->kd, values_of(schema, &parsed, "kd"), sizeof values->kd);
    memcpy(values->ks, values_of(schema, &parsed, "ks"), sizeof values->ks);
    for (size_t k = 0; k < model->n_shape; ++k) {
        const nqm_fit_shape *shape = &model->shape[k];
        values->shape[k] = clamp(*values_of(schema, &parsed, shape->key), shape->low, shape->high);
    }
    return NQM_OK;
}

/* The random starts are drawn under one loss, so that they are the same for all. */
static nqm_status draw_starts(const nqm_fit_entry *model, const nqm_fit_target *target, const nqm_fit_options *options,
                              nqm_fit_candidate *starts, nqm_error *err) {
    nqm_fit_target target_log;
    nqm_fit_search search = {.target = NULL};
    nqm_status status = nqm_fit_target_under(target, NQM_FIT_LOG, &target_log, err);
    if (status == NQM_OK)
        status = nqm_fit_search_begin(model, &target_log, NULL, &search, err);
    for (size_t i = 0; status == NQM_OK && i < options->n_random; ++i) {
        nqm_rng rng = nqm_rng_make(options->start_seed, i);
        starts[i].start = i;
        status = nqm_fit_search_random(&search, &rng, &starts[i].values);
    }
    nqm_fit_search_end(&search);
    nqm_free(target_log.weight);
    return status;
}

/* ---- stages ------------------------------------------------------------------------------------------------------ */

/* Whether a start goes to the whole loss at once. */
static bool is_immediate(const nqm_fit_options *options) {
    return options->start || (options->n_random && options->immediate);
}

/* The first stage: candidates (NQM_FIT_MAX_REFINED or n_random), each with its sum of squares. */
static nqm_status first_stage(nqm_fit_search *search, const nqm_fit_options *options, nqm_fit_candidate *candidates,
                              size_t *n_ret) {
    const nqm_fit_entry *model = search->lobes.model;
    if (!options->start && !options->n_random)
        return nqm_fit_search_starts(search, options, candidates, n_ret);
    *n_ret = options->start ? 1 : options->n_random;
    search->total = (double)*n_ret;
    nqm_status status = options->start ? nqm_fit_read_spec(model, options->start, &candidates->values, search->err)
                                       : draw_starts(model, search->target, options, candidates, search->err);
    for (size_t i = 0; status == NQM_OK && !is_immediate(options) && i < *n_ret; ++i) {
        status = nqm_fit_search_refine(search, &candidates[i], true);
        search->done += 1;
    }
    return status;
}

static nqm_status polish(nqm_fit_objective *objective, const nqm_fit_options *options, nqm_ticker *ticker,
                         nqm_fit_candidate *candidate, nqm_error *err) {
    size_t n_visual = 0;
    for (size_t i = 0; i < objective->n; ++i)
        n_visual += objective->parts[i].term.visual != NULL;
    bool staged = n_visual > 0 && n_visual < objective->n && !is_immediate(options);
    nqm_status status = NQM_OK;
    if (staged)
        status = nqm_fit_descend(objective, false, ticker, candidate, err);
    return status == NQM_OK ? nqm_fit_descend(objective, true, ticker, candidate, err) : status;
}

static nqm_status polish_all(const nqm_fit_entry *model, const nqm_fit_target *target, const nqm_fit_options *options,
                             nqm_ticker *ticker, size_t n, nqm_fit_candidate *candidates, nqm_error *err) {
    nqm_fit_term only = {.weight = 1, .loss = options->loss};
    nqm_fit_objective objective;
    nqm_status status = nqm_fit_objective_make(model, target, options->n_terms ? options->n_terms : 1,
                                               options->n_terms ? options->terms : &only, &objective, err);
    for (size_t i = 0; status == NQM_OK && i < n; ++i)
        status = polish(&objective, options, ticker, &candidates[i], err);
    nqm_fit_objective_free(&objective);
    return status;
}

nqm_status nqm_fit_minimise(const nqm_fit_entry *model, const nqm_fit_target *target, const nqm_fit_options *options,
                            nqm_fit_candidate *candidate, nqm_error *err) {
    nqm_ticker ticker = {.fn = options->progress, .user = options->progress_user};
    nqm_fit_search search = {.target = NULL};
    size_t n = 0, winner = 0, n_max = nqm_larger(options->n_random, NQM_FIT_MAX_REFINED);
    nqm_fit_candidate *candidates = nqm_alloc(n_max, sizeof *candidates);
    if (!candidates)
        return nqm_fail_nomem(err, n_max * sizeof *candidates);
    nqm_status status = nqm_fit_search_begin(model, target, &ticker, &search, err);
    if (status == NQM_OK)
        status = first_stage(&search, options, candidates, &n);
    if (status == NQM_OK && (!is_square(options) || is_immediate(options)))
        status = polish_all(model, target, options, &ticker, n, candidates, err);
    /* Far from the minimum Levenberg-Marquardt can leave the bounds, where the loss is flat: it comes after L-BFGS. */
    for (size_t i = 0; status == NQM_OK && is_square(options) && is_immediate(options) && i < n; ++i)
        status = nqm_fit_search_refine(&search, &candidates[i], false);
    nqm_fit_search_end(&search);
    for (size_t i = 1; status == NQM_OK && i < n; ++i)
        winner = candidates[i].loss < candidates[winner].loss ? i : winner;
    if (status == NQM_OK && !isfinite(candidates[winner].loss))
        status = nqm_fail(err, NQM_ERR_NUMERIC, -1, "the %s fit gave no finite result", model->name);
    if (status == NQM_OK)
        *candidate = candidates[winner];
    nqm_free(candidates);
    return status;
}
