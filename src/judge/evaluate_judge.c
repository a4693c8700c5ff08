/* SPDX-License-Identifier: MIT
 *
 * Judges the predictions of an evaluation on the pairs that the options select; agreement.c computes the statistics.
 */
#include "judge/judge.h"

#include <math.h>

static bool is_metric(const nqm_evaluation *ev, size_t predictor) {
    return predictor >= ev->n_models && predictor < ev->n_models + NQM_METRIC_COUNT;
}

/* Select pairs, and collect their labels and predictions. */
static nqm_status begin(const nqm_evaluation *ev, const nqm_eval_options *o, nqm_selection *s, nqm_judgement *j,
                        nqm_error *err) {
    nqm_status status = nqm_options_check(&nqm_eval_option_table, o, err);
    if (status == NQM_OK)
        status = nqm_selection_create(ev, o, ev->n_predictors, s, err);
    for (size_t k = 0; k < s->n; ++k)
        s->label[k] = ev->dataset->jod[s->pairs[k]];
    for (size_t i = 0; i < ev->n_predictors; ++i) {
        const double sign = is_metric(ev, i) ? -1 : 1; /* metrics are distances: negate them */
        for (size_t k = 0; k < s->n; ++k)
            s->prediction[i * s->n + k] = sign * ev->values[i * ev->dataset->n_pairs + s->pairs[k]];
    }
    *j = (nqm_judgement){.n = s->n,
                         .n_groups = s->n_groups,
                         .n_predictors = ev->n_predictors,
                         .group_begin = s->group_begin,
                         .label = s->label,
                         .prediction = s->prediction,
                         .order_margin = o->order_margin};
    return status;
}

nqm_status nqm_evaluation_judge(const nqm_evaluation *evaluation, const nqm_eval_options *options,
                                nqm_agreement *results, nqm_error *err) {
    NQM_REQUIRE(err, evaluation, results);
    nqm_eval_options o = options ? *options : nqm_eval_options_default();
    nqm_selection s = {0};
    nqm_judgement j;
    nqm_status status = begin(evaluation, &o, &s, &j, err);
    if (status == NQM_OK)
        status = nqm_judge(&j, o.n_bootstrap, o.seed, results, err);
    for (size_t i = 0; status == NQM_OK && i < evaluation->n_predictors; ++i) {
        results[i].name = evaluation->names[i];
        /* Metrics are distances, and human scores may be on any scale: errors in JOD are not defined for them. */
        if (is_metric(evaluation, i) || evaluation->dataset->order_only)
            results[i].mae = results[i].rmse = results[i].r2 = (nqm_estimate){NAN, {NAN, NAN}};
    }
    if (status == NQM_OK)
        nqm_mark_best(results + evaluation->n_models);
    nqm_selection_free(&s);
    return status;
}

nqm_status nqm_evaluation_contrast(const nqm_evaluation *evaluation, const nqm_eval_options *options,
                                   size_t n_contrasts, nqm_contrast *contrasts, nqm_error *err) {
    NQM_REQUIRE(err, evaluation);
    NQM_REQUIRE_IF(n_contrasts, err, contrasts);
    nqm_eval_options o = options ? *options : nqm_eval_options_default();
    nqm_selection s = {0};
    nqm_judgement j;
    for (size_t i = 0; i < n_contrasts; ++i)
        if (contrasts[i].first >= evaluation->n_predictors || contrasts[i].second >= evaluation->n_predictors)
            return nqm_fail(err, NQM_ERR_ARG, -1, "contrast %zu: there are %zu predictors", i,
                            evaluation->n_predictors);
    nqm_status status = begin(evaluation, &o, &s, &j, err);
    j.without_kendall = true;
    if (status == NQM_OK)
        status = nqm_judge_contrasts(&j, o.n_bootstrap, o.seed, n_contrasts, contrasts, err);
    nqm_selection_free(&s);
    return status;
}
