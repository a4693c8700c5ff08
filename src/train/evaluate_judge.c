/* SPDX-License-Identifier: MIT
 *
 * Judging the predictions of an evaluation on the pairs that its options select; agreement.c counts.
 */
#include "train/agreement.h"
#include "train/evaluate.h"

#include <math.h>
#include <string.h>

static bool is(const char *wanted, const char *value) {
    return !wanted || strcmp(wanted, value) == 0;
}

static bool in_range(const nqm_dataset *d, const nqm_eval_options *o, size_t pair) {
    return d->order_only || (d->jod[pair] >= o->jod_from && d->jod[pair] < o->jod_to);
}

static bool selected(const nqm_evaluation *ev, const nqm_eval_options *o, size_t pair) {
    const nqm_dataset *d = ev->dataset;
    size_t kind = d->pair_kind[pair];
    return nqm_evaluation_in_split(d, pair, o->split) && nqm_evaluation_in_split(d, pair, ev->split) &&
           in_range(d, o, pair) && is(o->kind, d->kind_names[kind]) &&
           is(o->family, nqm_dataset_kind_family(d, kind)) &&
           is(o->material_class, nqm_material_class_name(ev->ref_class[d->pair_ref[pair]]));
}

/* Memory of one judgement; the chosen pairs by group. */
typedef struct selection {
    size_t n;
    size_t *group_begin; /* (n_groups + 1) */
    size_t *pairs;       /* (n) */
    double *label;       /* (n) */
    double *prediction;  /* (n_predictors, n) */
} selection;

/* Counting sort of the chosen pairs by group. */
static nqm_status select_pairs(const nqm_evaluation *ev, const nqm_eval_options *o, selection *s, nqm_error *err) {
    const nqm_dataset *d = ev->dataset;
    size_t *next = nqm_alloc(d->n_groups, sizeof *next);
    s->group_begin = nqm_alloc(d->n_groups + 1, sizeof *s->group_begin);
    s->pairs = nqm_alloc(d->n_pairs, sizeof *s->pairs);
    bool ok = next && s->group_begin && s->pairs;
    for (size_t pair = 0; ok && pair < d->n_pairs; ++pair)
        s->group_begin[d->ref_group[d->pair_ref[pair]] + 1] += selected(ev, o, pair);
    for (size_t g = 0; ok && g < d->n_groups; ++g) {
        next[g] = s->group_begin[g];
        s->group_begin[g + 1] += s->group_begin[g];
    }
    for (size_t pair = 0; ok && pair < d->n_pairs; ++pair)
        if (selected(ev, o, pair))
            s->pairs[next[d->ref_group[d->pair_ref[pair]]]++] = pair;
    nqm_free(next);
    s->n = ok ? s->group_begin[d->n_groups] : 0;
    return ok ? NQM_OK : nqm_fail_nomem(err, (2 * d->n_groups + d->n_pairs) * sizeof *next);
}

static nqm_status collect(const nqm_evaluation *ev, selection *s, nqm_error *err) {
    const nqm_dataset *d = ev->dataset;
    s->label = nqm_alloc(s->n, sizeof *s->label);
    s->prediction = nqm_alloc(ev->n_predictors, s->n * sizeof *s->prediction);
    if (!s->label || !s->prediction)
        return nqm_fail_nomem(err, ev->n_predictors * s->n * sizeof *s->prediction);
    for (size_t k = 0; k < s->n; ++k)
        s->label[k] = d->jod[s->pairs[k]];
    for (size_t i = 0; i < ev->n_predictors; ++i) {
        double sign = i < ev->n_models ? 1 : -1; /* a metric is a distance */
        for (size_t k = 0; k < s->n; ++k)
            s->prediction[i * s->n + k] = sign * ev->values[i * d->n_pairs + s->pairs[k]];
    }
    return NQM_OK;
}

static nqm_status begin(const nqm_evaluation *ev, const nqm_eval_options *o, selection *s, nqm_judgement *j,
                        nqm_error *err) {
    if (!(o->order_margin >= 0))
        return nqm_fail(err, NQM_ERR_ARG, -1, "margin of the order: %g is below 0", o->order_margin);
    nqm_status status = select_pairs(ev, o, s, err);
    if (status == NQM_OK && s->n == 0)
        status = nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "no pair is left to judge on");
    if (status == NQM_OK)
        status = collect(ev, s, err);
    *j = (nqm_judgement){.n = s->n,
                         .n_groups = ev->dataset->n_groups,
                         .n_predictors = ev->n_predictors,
                         .group_begin = s->group_begin,
                         .label = s->label,
                         .prediction = s->prediction,
                         .order_margin = o->order_margin};
    return status;
}

static void release(selection *s) {
    nqm_free(s->group_begin);
    nqm_free(s->pairs);
    nqm_free(s->label);
    nqm_free(s->prediction);
}

/* Distances, and predictions of JOD beside labels that are none, have no errors in JOD. */
static void forget_errors(nqm_agreement *a) {
    a->mae = a->rmse = a->r2 = NAN;
    for (size_t k = 0; k < 2; ++k)
        a->mae_ci95[k] = a->rmse_ci95[k] = a->r2_ci95[k] = NAN;
}

nqm_status nqm_evaluation_judge(const nqm_evaluation *ev, const nqm_eval_options *options, nqm_agreement *results,
                                nqm_error *err) {
    nqm_eval_options o = options ? *options : nqm_eval_options_default();
    selection s = {0};
    nqm_judgement j;
    nqm_status status = begin(ev, &o, &s, &j, err);
    if (status == NQM_OK)
        status = nqm_judge(&j, o.n_bootstrap, o.seed, results, err);
    for (size_t i = 0; status == NQM_OK && i < ev->n_predictors; ++i) {
        results[i].name = ev->names[i];
        if (i >= ev->n_models || ev->dataset->order_only)
            forget_errors(&results[i]);
    }
    if (status == NQM_OK)
        nqm_mark_best(results + ev->n_models);
    release(&s);
    return status;
}

nqm_status nqm_evaluation_contrast(const nqm_evaluation *ev, const nqm_eval_options *options, size_t n_contrasts,
                                   nqm_contrast *contrasts, nqm_error *err) {
    nqm_eval_options o = options ? *options : nqm_eval_options_default();
    selection s = {0};
    nqm_judgement j;
    for (size_t i = 0; i < n_contrasts; ++i)
        if (contrasts[i].first >= ev->n_predictors || contrasts[i].second >= ev->n_predictors)
            return nqm_fail(err, NQM_ERR_ARG, -1, "contrast %zu: there are %zu predictors", i, ev->n_predictors);
    nqm_status status = begin(ev, &o, &s, &j, err);
    if (status == NQM_OK)
        status = nqm_judge_contrasts(&j, o.n_bootstrap, o.seed, n_contrasts, contrasts, err);
    release(&s);
    return status;
}

nqm_status nqm_evaluate(const nqm_model *model, const nqm_dataset *dataset, const nqm_eval_options *options,
                        nqm_agreement *results, nqm_error *err) {
    nqm_evaluation *ev;
    nqm_status status = nqm_evaluation_create(dataset, 1, &model, options, &ev, err);
    if (status == NQM_OK)
        status = nqm_evaluation_judge(ev, options, results, err);
    nqm_evaluation_free(ev);
    return status;
}
