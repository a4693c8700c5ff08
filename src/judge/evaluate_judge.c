/* SPDX-License-Identifier: MIT
 *
 * Selects pairs of an evaluation by the options, and judges its predictions there; agreement.c computes the statistics.
 */
#include "judge/judge.h"

#include <math.h>
#include <string.h>

/* ---- selection ---------------------------------------------------------------------------------------------------- */

static bool is(const char *required, const char *value) {
    return !required || strcmp(required, value) == 0;
}

/* See nqm_eval_options.subset. */
static bool in_subset(const nqm_evaluation *ev, const char *subset, size_t kind) {
    const char *family = nqm_dataset_get_kind(ev->dataset, kind).family;
    if (!subset)
        return true;
    if (strcmp(subset, "unseen") == 0)
        return ev->unseen[kind];
    if (strcmp(subset, "seen") == 0)
        return ev->has_unseen && !ev->unseen[kind];
    const bool is_near = *family && strcmp(family, "far") != 0 && strcmp(family, "rounding") != 0;
    return strcmp(subset, "near") == 0 ? is_near : strcmp(subset, family) == 0;
}

static bool selected(const nqm_evaluation *ev, const nqm_eval_options *o, size_t pair) {
    const nqm_dataset *d = ev->dataset;
    const nqm_dataset_kind kind = nqm_dataset_get_kind(d, d->pair_kind[pair]);
    return nqm_evaluation_in_split(d, pair, o->split) && nqm_evaluation_in_split(d, pair, ev->split) &&
           (d->order_only || (d->jod[pair] >= o->jod_from && d->jod[pair] < o->jod_to)) && is(o->kind, kind.name) &&
           is(o->family, kind.family) && in_subset(ev, o->subset, d->pair_kind[pair]) &&
           is(o->source, nqm_dataset_ref_source(d, d->pair_ref[pair])) &&
           is(o->material_class, nqm_material_class_name(ev->ref_class[d->pair_ref[pair]]));
}

/* Sort the selected pairs by group, by counting. */
static void sort_pairs(const nqm_evaluation *ev, const nqm_eval_options *o, nqm_selection *s) {
    const nqm_dataset *d = ev->dataset;
    size_t *next = s->group_begin + 1; /* first the number of pairs of each group, one place further */
    for (size_t pair = 0; pair < d->n_pairs; ++pair)
        next[d->ref_group[d->pair_ref[pair]] + 1] += selected(ev, o, pair);
    for (size_t g = 0; g < d->n_groups; ++g)
        next[g + 1] += next[g];
    for (size_t pair = 0; pair < d->n_pairs; ++pair)
        if (selected(ev, o, pair))
            s->pairs[next[d->ref_group[d->pair_ref[pair]]]++] = pair;
    s->n = s->group_begin[d->n_groups];
    for (size_t g = 0; g < d->n_groups; ++g) /* leave out the groups without pairs */
        if (s->group_begin[g + 1] > s->group_begin[g])
            s->group_begin[s->n_groups++] = s->group_begin[g];
    s->group_begin[s->n_groups] = s->n;
}

nqm_status nqm_selection_create(const nqm_evaluation *ev, const nqm_eval_options *options, size_t n_predictors,
                                nqm_selection *s, nqm_error *err) {
    const size_t n_pairs = ev->dataset->n_pairs;
    *s = (nqm_selection){0};
    nqm_status status =
        nqm_alloc_arrays(NQM_ARRAYS({&s->group_begin, ev->dataset->n_groups + 2, sizeof *s->group_begin},
                                    {&s->pairs, n_pairs, sizeof *s->pairs}, {&s->label, n_pairs, sizeof *s->label},
                                    {&s->prediction, n_predictors, n_pairs * sizeof *s->prediction}),
                         err);
    if (status != NQM_OK)
        return status;
    sort_pairs(ev, options, s);
    if (s->n > 0)
        return NQM_OK;
    nqm_selection_free(s);
    return nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "no pair is left to judge on");
}

void nqm_selection_free(nqm_selection *s) {
    nqm_free(s->group_begin);
    *s = (nqm_selection){0};
}

/* ---- judging ------------------------------------------------------------------------------------------------------ */

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
    nqm_selection s = {0};
    nqm_judgement j;
    nqm_status status = begin(evaluation, options, &s, &j, err);
    if (status == NQM_OK)
        status = nqm_judge(&j, options->n_bootstrap, options->seed, results, err);
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
    nqm_selection s = {0};
    nqm_judgement j;
    for (size_t i = 0; i < n_contrasts; ++i)
        if (contrasts[i].first >= evaluation->n_predictors || contrasts[i].second >= evaluation->n_predictors)
            return nqm_fail(err, NQM_ERR_ARG, -1, "contrast %zu: there are %zu predictors", i,
                            evaluation->n_predictors);
    nqm_status status = begin(evaluation, options, &s, &j, err);
    j.without_kendall = true;
    if (status == NQM_OK)
        status = nqm_judge_contrasts(&j, options->n_bootstrap, options->seed, n_contrasts, contrasts, err);
    nqm_selection_free(&s);
    return status;
}
