/* SPDX-License-Identifier: MIT
 *
 * The loss "auto" of shading models. One search under NQM_FIT_LOG gives the starts of the candidates; the best two by the
 * judge are polished by the whole sum; the best of all is simplified.
 */
#include "fit/shading.h"
#include "match/match.h"

#include <math.h>
#include <stdlib.h>

static const nqm_fit_loss candidate_losses[] = {NQM_FIT_LOG, NQM_FIT_LOG_COS, NQM_FIT_RMS_CRWE, NQM_FIT_LOG_DIFF};
enum { N_LOSSES = sizeof candidate_losses / sizeof *candidate_losses, N_POLISHED = 2 };

typedef struct candidate {
    nqm_shading_point point;
    double difference; /* by the judge */
    nqm_fit_loss loss;
    bool polished;
} candidate;

typedef struct selection {
    nqm_shading_space space;
    nqm_fit_target target; /* under NQM_FIT_LOG */
    nqm_fit_term judge_term;
    nqm_shading_objective *judge, *polish;
    size_t n_terms; /* of the polish */
    const nqm_fit_term *terms;
    nqm_ticker ticker;
    size_t n;
    candidate list[2 * N_LOSSES + N_POLISHED];
    nqm_error *err;
} selection;

static nqm_status add(selection *s, const nqm_shading_point *point, nqm_fit_loss loss, bool polished) {
    candidate *c = &s->list[s->n++];
    *c = (candidate){.point = *point, .loss = loss, .polished = polished};
    return nqm_shading_objective_value(s->judge, &point->values, &c->difference, s->err);
}

/* Fits under each loss from the points of the search. */
static nqm_status make_candidates(selection *s, size_t n, const nqm_shading_point *points) {
    nqm_status status = NQM_OK;
    for (size_t i = 0; status == NQM_OK && i < N_LOSSES * n; ++i) {
        const nqm_fit_loss loss = candidate_losses[i / n];
        nqm_shading_point point = points[i % n];
        nqm_fit_target target;
        status = nqm_fit_target_under(&s->target, loss, &target, s->err);
        if (status == NQM_OK && loss != NQM_FIT_LOG)
            status = nqm_shading_refine(&s->space, &target, 15, &s->ticker, &point, s->err);
        nqm_free(target.weight);
        if (status == NQM_OK)
            status = add(s, &point, loss, false);
    }
    return status;
}

static int compare_candidates(const void *a, const void *b) {
    const candidate *x = a, *y = b;
    if (x->difference != y->difference)
        return x->difference < y->difference ? -1 : 1;
    return x->loss != y->loss ? (x->loss > y->loss) - (x->loss < y->loss) : x->polished - y->polished;
}

static nqm_status polish_best(selection *s) {
    const double hopeless = 3, exact = 0.02; /* relative; Delta-E ITP that nobody sees */
    qsort(s->list, s->n, sizeof *s->list, compare_candidates);
    nqm_status status = NQM_OK;
    const double best = s->list->difference;
    for (size_t i = 0; status == NQM_OK && i < N_POLISHED && best > exact && s->list[i].difference < hopeless * best;
         ++i) {
        nqm_shading_point point = s->list[i].point;
        status = nqm_shading_descend(s->polish, &s->space, NQM_SHADING_STEPS, &s->ticker, &point, s->err);
        if (status == NQM_OK)
            status = add(s, &point, s->list[i].loss, true);
    }
    qsort(s->list, s->n, sizeof *s->list, compare_candidates);
    return status;
}

/* The simplified winner, unless the judge sees the difference. */
static nqm_status simplify_best(selection *s, double tolerance) {
    const double visible = 0.1; /* Delta-E ITP; 1 is one just noticeable step */
    candidate simple = s->list[0];
    if (tolerance <= 0)
        return NQM_OK;
    nqm_status status = nqm_shading_finish(&s->space, &s->target, s->n_terms, s->terms, s->polish, tolerance,
                                           &s->ticker, &simple.point, s->err);
    if (status == NQM_OK)
        status = nqm_shading_objective_value(s->judge, &simple.point.values, &simple.difference, s->err);
    if (status == NQM_OK && simple.difference <= (1 + 2 * tolerance) * s->list[0].difference + visible)
        s->list[0] = simple;
    return status;
}

static nqm_status begin(selection *s, const nqm_brdf *ref, const nqm_analytic_model *model,
                        const nqm_fit_options *options, size_t n_terms, const nqm_fit_term *terms,
                        const nqm_fit_visual *judge) {
    nqm_fit_options first = *options;
    first.loss = NQM_FIT_LOG;
    s->judge_term = (nqm_fit_term){.weight = 1, .visual = judge};
    nqm_status status = nqm_shading_space_make(model, options, &s->space, s->err);
    if (status == NQM_OK)
        status = nqm_fit_target_make(ref, &first, &s->target, s->err);
    if (status == NQM_OK)
        status = nqm_shading_objective_make(&s->space, &s->target, 1, &s->judge_term, &s->judge, s->err);
    if (status == NQM_OK)
        status = nqm_shading_objective_make(&s->space, &s->target, n_terms, terms, &s->polish, s->err);
    return status;
}

nqm_status nqm_match_shading(const nqm_brdf *ref, const nqm_analytic_model *model, const nqm_fit_options *options,
                             size_t n_terms, const nqm_fit_term *terms, const nqm_fit_visual *judge,
                             const char *sum_text, nqm_match_report *report, nqm_error *err) {
    nqm_shading_point points[NQM_SHADING_MAX_STARTS] = {{.loss = 0}};
    size_t n = 0;
    selection *s = nqm_alloc(1, sizeof *s);
    if (!s)
        return nqm_fail_nomem(err, sizeof *s);
    s->err = err;
    s->n_terms = n_terms;
    s->terms = terms;
    s->ticker = (nqm_ticker){.fn = options->progress, .user = options->progress_user};
    nqm_status status = begin(s, ref, model, options, n_terms, terms, judge);
    if (status == NQM_OK)
        status = nqm_shading_search(&s->space, ref, &s->target, options, false, &s->ticker, points, &n, err);
    if (status == NQM_OK)
        status = make_candidates(s, nqm_smaller(n, 2), points);
    if (status == NQM_OK)
        status = polish_best(s);
    if (status == NQM_OK)
        status = simplify_best(s, options->simplify);
    if (status == NQM_OK)
        status = nqm_shading_report(&s->space, s->judge, s->target.n, &s->list[0].point, &report->fit, err);
    report->difference = report->fit.loss;
    if (status == NQM_OK)
        snprintf(report->selected, sizeof report->selected, "%s%s%.80s", nqm_fit_loss_words[s->list[0].loss],
                 s->list[0].polished ? ", then " : "", s->list[0].polished ? sum_text : "");
    nqm_shading_objective_free(s->judge);
    nqm_shading_objective_free(s->polish);
    nqm_free(s->target.wi);
    nqm_free(s);
    return status;
}
