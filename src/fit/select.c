/* SPDX-License-Identifier: MIT
 *
 * The loss "auto": one search under NQM_FIT_LOG gives the starts of candidates under several losses; the best by a judge are
 * polished by the terms of the options; the best of all is simplified. An analytic model has one start, and all its candidates
 * are polished; a shading model, whose steps take longer, has two, and its best is polished, on half of the directions.
 */
#include "fit/fit.h"

#include <stdlib.h>

static const nqm_fit_loss candidate_losses[] = {NQM_FIT_LOG, NQM_FIT_LOG_COS, NQM_FIT_RMS_CRWE, NQM_FIT_LOG_DIFF};
enum { N_LOSSES = sizeof candidate_losses / sizeof *candidate_losses, MAX_STARTS = 2, MAX_POLISHED = N_LOSSES };

typedef struct candidate {
    nqm_fit_point point;
    double difference; /* by the judge */
    nqm_fit_loss loss;
    bool polished, is_start;
} candidate;

typedef struct selection {
    nqm_fit_run run;
    nqm_fit_options options; /* of the run */
    nqm_fit_term judge_term;
    nqm_fit_objective *judge;
    size_t n;
    candidate list[MAX_STARTS * N_LOSSES + 2 * NQM_FIT_N_WIDTHS + MAX_POLISHED + 1];
} selection;

static bool is_analytic(const selection *s) {
    return s->run.space.entry->n_shape > 0;
}

static nqm_status add(selection *s, const nqm_fit_point *point, nqm_fit_loss loss, bool polished) {
    candidate *c = &s->list[s->n++];
    *c = (candidate){.point = *point, .loss = loss, .polished = polished};
    return nqm_fit_objective_value(s->judge, &point->values, &c->difference, s->run.err);
}

/* Fits under each loss from the points of the search; of shading models on a part of the directions. */
static nqm_status make_candidates(selection *s, size_t n, const nqm_fit_point *points) {
    enum { STEPS = 15, THIN = 3000 };
    nqm_fit_run *run = &s->run;
    nqm_fit_target thin = {0};
    nqm_status status = nqm_fit_target_thin(&run->target, is_analytic(s) ? run->target.n : THIN, &thin, run->err);
    for (size_t i = 0; status == NQM_OK && i < N_LOSSES * n; ++i) {
        const nqm_fit_loss loss = candidate_losses[i / n];
        nqm_fit_point point = points[i % n];
        nqm_fit_target target;
        status = nqm_fit_target_under(&thin, loss, &target, run->err);
        if (status == NQM_OK && loss != thin.loss)
            status = nqm_fit_refine(&run->space, &target, STEPS, &run->ticker, &point, run->err);
        nqm_free(target.weight);
        if (status == NQM_OK)
            status = add(s, &point, loss, false);
    }
    nqm_free(thin.wi);
    return status;
}

/* The starts of a shading model as they are: the few directions that see the lobe of a mirror may lead all fits away from it. */
static nqm_status add_starts(selection *s) {
    nqm_fit_run *run = &s->run;
    nqm_fit_point point = {.loss = 0};
    double diffuse[3], albedo[3];
    nqm_status status = nqm_fit_measure_albedos(run->ref, &run->target, diffuse, albedo, run->err);
    for (size_t i = 0; status == NQM_OK && nqm_fit_start(&run->space, i, 0, diffuse, albedo, &point.values); ++i)
        if ((status = add(s, &point, NQM_FIT_LOG, false)) == NQM_OK)
            s->list[s->n - 1].is_start = true;
    return status;
}

static int compare_candidates(const void *a, const void *b) {
    const candidate *x = a, *y = b;
    if (x->difference != y->difference)
        return x->difference < y->difference ? -1 : 1;
    return x->loss != y->loss ? (x->loss > y->loss) - (x->loss < y->loss) : x->polished - y->polished;
}

/* A candidate whose polish diverges stays as it is. */
static nqm_status polish(selection *s, const candidate *c) {
    nqm_fit_point point = c->point;
    nqm_error err = {0};
    nqm_status status = nqm_fit_descend(s->run.objective, &s->run.space, NQM_FIT_STEPS, &s->run.ticker, &point, &err);
    if (status == NQM_ERR_NUMERIC)
        return NQM_OK;
    return status == NQM_OK ? add(s, &point, c->loss, true) : nqm_fail(s->run.err, status, -1, "%s", err.message);
}

static nqm_status polish_best(selection *s) {
    const double hopeless = 3, exact = 0.02; /* relative; Delta-E ITP that nobody sees */
    qsort(s->list, s->n, sizeof *s->list, compare_candidates);
    nqm_status status = NQM_OK;
    const double best = s->list->difference;
    const size_t n_polished = is_analytic(s) ? MAX_POLISHED : 1;
    for (size_t i = 0; status == NQM_OK && i < n_polished && best > exact && s->list[i].difference < hopeless * best;
         ++i)
        status = polish(s, &s->list[i]);
    size_t i = 0; /* if that was a start, which may lead nowhere: the best fit, too */
    while (i < s->n && s->list[i].is_start)
        ++i;
    if (status == NQM_OK && i > 0 && i < s->n && best > exact)
        status = polish(s, &s->list[i]);
    qsort(s->list, s->n, sizeof *s->list, compare_candidates);
    return status;
}

/* The simplified winner, unless the judge sees the difference. */
static nqm_status simplify_best(selection *s) {
    const double visible = 0.1; /* Delta-E ITP; 1 is one just noticeable step */
    const double tolerance = s->run.options->simplify;
    candidate simple = s->list[0];
    nqm_status status = nqm_fit_simplify(&s->run, &simple.point);
    if (status == NQM_OK)
        status = nqm_fit_objective_value(s->judge, &simple.point.values, &simple.difference, s->run.err);
    if (status == NQM_OK && simple.difference <= (1 + 2 * tolerance) * s->list[0].difference + visible)
        s->list[0] = simple;
    return status;
}

static nqm_status begin(selection *s, const nqm_brdf *ref, const nqm_fit_entry *entry, const nqm_fit_options *options,
                        const nqm_fit_visual *judge, nqm_error *err) {
    const size_t n = options->n_directions, few = 1000;
    s->options = *options;
    s->options.n_directions = entry->n_shape ? n : nqm_larger(n / 2, nqm_smaller(n, few));
    nqm_status status = nqm_fit_begin(&s->run, ref, entry, &s->options, NQM_FIT_LOG, err);
    s->judge_term = (nqm_fit_term){.weight = 1, .visual = judge};
    if (status == NQM_OK)
        status = nqm_fit_objective_make(&s->run.space, &s->run.target, 1, &s->judge_term, &s->judge, err);
    return status;
}

nqm_status nqm_fit_select(const nqm_brdf *ref, const nqm_fit_entry *entry, const nqm_fit_options *options,
                          const nqm_fit_visual *judge, nqm_fit_choice *choice, nqm_error *err) {
    nqm_fit_point points[NQM_FIT_MAX_POINTS] = {{.loss = 0}};
    size_t n = 0;
    selection *s = nqm_alloc(1, sizeof *s);
    if (!s)
        return nqm_fail_nomem(err, sizeof *s);
    nqm_status status = begin(s, ref, entry, options, judge, err);
    if (status == NQM_OK)
        status = nqm_fit_search(&s->run, points, &n);
    if (status == NQM_OK)
        status = make_candidates(s, nqm_smaller(n, is_analytic(s) ? 1 : MAX_STARTS), points);
    if (status == NQM_OK && !is_analytic(s))
        status = add_starts(s);
    if (status == NQM_OK)
        status = polish_best(s);
    if (status == NQM_OK)
        status = simplify_best(s);
    if (status == NQM_OK)
        status = nqm_fit_write_report(&s->run, &s->list[0].point, &choice->report);
    if (status == NQM_OK)
        status = nqm_fit_objective_value(s->judge, &s->list[0].point.values, &choice->report.loss, err);
    choice->loss = s->list[0].loss;
    choice->polished = s->list[0].polished;
    nqm_fit_objective_free(s->judge);
    nqm_fit_end(&s->run);
    nqm_free(s);
    return status;
}
