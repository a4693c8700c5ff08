/* SPDX-License-Identifier: MIT
 *
 * The fraction of people's choices between two tests that predictors reproduce.
 */
#include "data/data.h"
#include "judge/judge.h"

#include <math.h>
#include <string.h>

/* ---- reproduced choices ------------------------------------------------------------------------------------------ */

/* Counts of choices per group, and their fractions over resamples of the groups. */
typedef struct tally {
    const nqm_human *human;
    const nqm_evaluation *ev;
    size_t n_groups, n_resamples; /* n_groups: with choices */
    double *choices;              /* (n_groups) number of choices; owns the block of all arrays */
    double *met;                  /* (n_groups, n_predictors) number of choices that the predictor reproduces */
    double *weight;               /* (n_groups) scratch */
    double *share;                /* (n_predictors, n_resamples) fraction of choices reproduced */
    double *scratch;              /* (n_resamples) */
} tally;

/* 1: the predictor rates a better; 0: b; 0.5: both equal. */
static double prefers_a(const nqm_evaluation *ev, size_t predictor, const nqm_triplet *t) {
    const double *value = nqm_evaluation_values(ev, predictor);
    double better = predictor < ev->n_models ? value[t->a] - value[t->b] : value[t->b] - value[t->a];
    return better > 0 ? 1 : better < 0 ? 0 : 0.5;
}

static double majority_share(const tally *w, size_t predictor) {
    double n = 0, met = 0;
    for (size_t i = 0; i < w->human->n_triplets; ++i) {
        const nqm_triplet *t = &w->human->triplets[i];
        if (t->n_a == t->n_b)
            continue;
        double a = prefers_a(w->ev, predictor, t);
        met += t->n_a > t->n_b ? a : 1 - a;
        n += 1;
    }
    return n > 0 ? met / n : NAN;
}

static double share_of(const tally *w, size_t predictor, const double *weight) {
    return nqm_share_of(w->n_groups, w->ev->n_predictors, w->met + predictor, w->choices, weight);
}

static nqm_status check(const nqm_human *human, const nqm_evaluation *ev, nqm_error *err) {
    if (human->kind != NQM_HUMAN_CHOICE)
        return nqm_fail(err, NQM_ERR_ARG, -1, "these answers are scores, not choices");
    if (ev->dataset != human->dataset)
        return nqm_fail(err, NQM_ERR_ARG, -1, "the evaluation is of another dataset");
    for (size_t i = 0; i < ev->n_predictors * ev->dataset->n_pairs; ++i)
        if (isnan(ev->values[i]))
            return nqm_fail(err, NQM_ERR_ARG, -1, "the evaluation has not predicted every pair");
    return NQM_OK;
}

static nqm_status begin(tally *w, const nqm_eval_options *options, nqm_error *err) {
    nqm_status status = check(w->human, w->ev, err);
    if (status != NQM_OK)
        return status;
    const size_t n_groups = w->human->dataset->n_groups, n_predictors = w->ev->n_predictors;
    status = nqm_alloc_arrays(NQM_ARRAYS({&w->choices, n_groups, sizeof *w->choices},
                                         {&w->met, n_groups, n_predictors * sizeof *w->met},
                                         {&w->weight, n_groups, sizeof *w->weight},
                                         {&w->share, n_predictors, options->n_bootstrap * sizeof *w->share},
                                         {&w->scratch, options->n_bootstrap, sizeof *w->scratch}),
                              err);
    if (status != NQM_OK)
        return status;
    for (size_t i = 0; i < w->human->n_triplets; ++i) {
        const nqm_triplet *t = &w->human->triplets[i];
        w->choices[t->group] += t->n_a + t->n_b;
        for (size_t p = 0; p < n_predictors; ++p) {
            const double a = prefers_a(w->ev, p, t);
            w->met[t->group * n_predictors + p] += a * t->n_a + (1 - a) * t->n_b;
        }
    }
    for (size_t g = 0; g < n_groups; ++g)
        if (w->choices[g] > 0) { /* leave out the groups without choices */
            w->choices[w->n_groups] = w->choices[g];
            memmove(w->met + w->n_groups++ * n_predictors, w->met + g * n_predictors, n_predictors * sizeof *w->met);
        }
    w->n_resamples = nqm_bootstrap_count(w->n_groups, options->n_bootstrap);
    for (size_t i = 0; i < w->n_resamples; ++i) {
        nqm_bootstrap_draw(options->seed, i, w->n_groups, w->weight);
        for (size_t p = 0; p < n_predictors; ++p)
            w->share[p * w->n_resamples + i] = share_of(w, p, w->weight);
    }
    return NQM_OK;
}

/* ---- results ----------------------------------------------------------------------------------------------------- */

static void mark_best(size_t n_models, nqm_choice_agreement *results) {
    nqm_agreement metrics[NQM_METRIC_COUNT] = {0};
    for (size_t m = 0; m < NQM_METRIC_COUNT; ++m)
        metrics[m].spearman = results[n_models + m].agreement;
    nqm_mark_best(metrics);
    for (size_t m = 0; m < NQM_METRIC_COUNT; ++m) {
        results[n_models + m].best_of_family = metrics[m].best_of_family;
        results[n_models + m].best_baseline = metrics[m].best_baseline;
    }
}

nqm_status nqm_human_judge_choices(const nqm_human *human, const nqm_evaluation *evaluation,
                                   const nqm_eval_options *options, nqm_choice_agreement *results, nqm_error *err) {
    tally w = {.human = human, .ev = evaluation};
    nqm_status status = begin(&w, options, err);
    for (size_t p = 0; status == NQM_OK && p < evaluation->n_predictors; ++p) {
        results[p] = (nqm_choice_agreement){
            .name = evaluation->names[p], .agreement.value = share_of(&w, p, NULL), .majority = majority_share(&w, p)};
        nqm_interval95(w.n_resamples, w.share + p * w.n_resamples, results[p].agreement.ci95);
    }
    if (status == NQM_OK)
        mark_best(evaluation->n_models, results);
    nqm_free(w.choices);
    return status;
}

nqm_status nqm_human_contrast_choices(const nqm_human *human, const nqm_evaluation *evaluation,
                                      const nqm_eval_options *options, size_t first, size_t second,
                                      nqm_difference *difference_ret, nqm_error *err) {
    if (first >= evaluation->n_predictors || second >= evaluation->n_predictors)
        return nqm_fail(err, NQM_ERR_ARG, -1, "contrast: there are %zu predictors", evaluation->n_predictors);
    tally w = {.human = human, .ev = evaluation};
    nqm_status status = begin(&w, options, err);
    if (status == NQM_OK)
        *difference_ret =
            nqm_difference_of(share_of(&w, first, NULL) - share_of(&w, second, NULL), w.n_resamples,
                              w.share + first * w.n_resamples, w.share + second * w.n_resamples, w.scratch);
    nqm_free(w.choices);
    return status;
}
