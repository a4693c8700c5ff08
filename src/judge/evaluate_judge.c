/* SPDX-License-Identifier: MIT
 *
 * Judges the predictions of an evaluation on the pairs that the options select; agreement.c computes the statistics.
 */
#include "judge/agreement.h"
#include "judge/evaluate.h"

#include <math.h>
#include <string.h>

/* Input arrays of one judgement. */
typedef struct chosen {
    nqm_selection pairs;
    double *label;      /* (n); owns the block of both */
    double *prediction; /* (n_predictors, n) */
} chosen;

static bool is_metric(const nqm_evaluation *ev, size_t predictor) {
    return predictor >= ev->n_models && predictor < ev->n_models + NQM_METRIC_COUNT;
}

static nqm_status collect(const nqm_evaluation *ev, chosen *c, nqm_error *err) {
    const nqm_dataset *d = ev->dataset;
    nqm_status status =
        nqm_alloc_arrays(NQM_ARRAYS({&c->label, c->pairs.n, sizeof *c->label},
                                    {&c->prediction, ev->n_predictors, c->pairs.n * sizeof *c->prediction}),
                         err);
    if (status != NQM_OK)
        return status;
    for (size_t k = 0; k < c->pairs.n; ++k)
        c->label[k] = d->jod[c->pairs.pairs[k]];
    for (size_t i = 0; i < ev->n_predictors; ++i) {
        double sign = is_metric(ev, i) ? -1 : 1; /* metrics are distances: negate them */
        for (size_t k = 0; k < c->pairs.n; ++k)
            c->prediction[i * c->pairs.n + k] = sign * ev->values[i * d->n_pairs + c->pairs.pairs[k]];
    }
    return NQM_OK;
}

static nqm_status begin(const nqm_evaluation *ev, const nqm_eval_options *o, chosen *c, nqm_judgement *j,
                        nqm_error *err) {
    nqm_status status = nqm_options_check(&nqm_eval_option_table, o, err);
    if (status == NQM_OK)
        status = nqm_selection_create(ev, o, &c->pairs, err);
    if (status == NQM_OK)
        status = collect(ev, c, err);
    *j = (nqm_judgement){.n = c->pairs.n,
                         .n_groups = c->pairs.n_groups,
                         .n_predictors = ev->n_predictors,
                         .group_begin = c->pairs.group_begin,
                         .label = c->label,
                         .prediction = c->prediction,
                         .order_margin = o->order_margin};
    return status;
}

static void release(chosen *c) {
    nqm_selection_free(&c->pairs);
    nqm_free(c->label);
}

/* Metrics are distances, and human scores may be on any scale: errors in JOD are not defined for them. */
static void clear_errors(nqm_agreement *a) {
    const nqm_estimate none = {NAN, {NAN, NAN}};
    a->mae = a->rmse = a->r2 = none;
}

nqm_status nqm_evaluation_judge(const nqm_evaluation *evaluation, const nqm_eval_options *options,
                                nqm_agreement *results, nqm_error *err) {
    NQM_REQUIRE(err, evaluation, results);
    nqm_eval_options o = options ? *options : nqm_eval_options_default();
    chosen c = {0};
    nqm_judgement j;
    nqm_status status = begin(evaluation, &o, &c, &j, err);
    if (status == NQM_OK)
        status = nqm_judge(&j, o.n_bootstrap, o.seed, results, err);
    for (size_t i = 0; status == NQM_OK && i < evaluation->n_predictors; ++i) {
        results[i].name = evaluation->names[i];
        if (is_metric(evaluation, i) || evaluation->dataset->order_only)
            clear_errors(&results[i]);
    }
    if (status == NQM_OK)
        nqm_mark_best(results + evaluation->n_models);
    release(&c);
    return status;
}

nqm_status nqm_evaluation_contrast(const nqm_evaluation *evaluation, const nqm_eval_options *options,
                                   size_t n_contrasts, nqm_contrast *contrasts, nqm_error *err) {
    NQM_REQUIRE(err, evaluation);
    NQM_REQUIRE_IF(n_contrasts, err, contrasts);
    nqm_eval_options o = options ? *options : nqm_eval_options_default();
    chosen c = {0};
    nqm_judgement j;
    for (size_t i = 0; i < n_contrasts; ++i)
        if (contrasts[i].first >= evaluation->n_predictors || contrasts[i].second >= evaluation->n_predictors)
            return nqm_fail(err, NQM_ERR_ARG, -1, "contrast %zu: there are %zu predictors", i,
                            evaluation->n_predictors);
    nqm_status status = begin(evaluation, &o, &c, &j, err);
    j.without_kendall = true;
    if (status == NQM_OK)
        status = nqm_judge_contrasts(&j, o.n_bootstrap, o.seed, n_contrasts, contrasts, err);
    release(&c);
    return status;
}
