/* SPDX-License-Identifier: MIT
 *
 * Fits by perceptual losses, and the selection among several of them.
 */
#include "brdf/formats/listed.h"
#include "fit/fit.h"

#include <math.h>

enum { N_RAYS = 32768, FEW_RAYS = 8192 }; /* of a judge; of a term, which an optimiser evaluates often */

/* ---- one fit ----------------------------------------------------------------------------------------------------- */

/* Arguments of all fits of a match. */
typedef struct setting {
    const nqm_brdf *ref;
    const char *model;
    const nqm_match_loss *loss;
    nqm_fit_options options;
    const nqm_match_visual *judge; /* NULL: transport judges */
} setting;

/* A sum as the terms of a fit. */
typedef struct binding {
    nqm_match_visual metric, transport;
    size_t n;
    nqm_fit_term terms[NQM_MATCH_MAX_TERMS];
} binding;

static nqm_status bind_term(const setting *s, const nqm_match_term *term, binding *b, nqm_error *err) {
    nqm_fit_term *to = &b->terms[b->n++];
    *to = (nqm_fit_term){.weight = term->weight, .loss = term->loss};
    if (term->kind == NQM_MATCH_VALUES)
        return NQM_OK;
    bool is_metric = term->kind == NQM_MATCH_METRIC;
    const nqm_model *model = is_metric ? s->loss->metric : s->loss->transport;
    nqm_match_visual *visual = is_metric ? &b->metric : &b->transport;
    if (!model)
        return nqm_fail(err, NQM_ERR_ARG, -1, "the loss '%s' needs a model", is_metric ? "nqm" : "transport");
    to->visual = &visual->visual;
    if (visual->visual.n)
        return NQM_OK;
    if (!is_metric && s->loss->scene && nqm_brdf_anisotropy(s->ref) > 0) /* whose rays see all azimuths */
        return nqm_match_rays_make(s->loss->scene, s->ref, FEW_RAYS, s->options.seed + 1, visual, err);
    return nqm_match_visual_make(model, s->ref, visual, err);
}

/* The status of a fit with visual losses: a NaN of theirs ends it, and their own reason replaces that of the fit. "auto" survives
 * a candidate without a result, but not one that lacked memory. */
static nqm_status explain(size_t n, const nqm_error *const *failures, nqm_status status, nqm_error *err) {
    for (size_t i = 0; i < n; ++i)
        if (failures[i]->status != NQM_OK &&
            (status == NQM_ERR_NUMERIC || (status == NQM_OK && failures[i]->status != NQM_ERR_NUMERIC)))
            return nqm_fail(err, failures[i]->status, -1, "%s", failures[i]->message);
    return status;
}

/* The value of a visual loss for a BRDF. */
static nqm_status compare(const nqm_match_visual *judge, const nqm_brdf *brdf, double *value, nqm_error *err) {
    const nqm_fit_visual *visual = &judge->visual;
    double *rgb = nqm_alloc(visual->n, 6 * sizeof *rgb);
    if (!rgb)
        return nqm_fail_nomem(err, visual->n * 6 * sizeof *rgb);
    nqm_brdf_eval(brdf, visual->n, visual->wi, visual->wo, rgb, NULL);
    *value = visual->eval(visual->user, rgb, rgb + 3 * visual->n);
    nqm_free(rgb);
    return isnan(*value) ? nqm_fail(err, judge->failure.status, -1, "%s", judge->failure.message) : NQM_OK;
}

/* "auto": `options` has the terms of the polish. */
static nqm_status select_best(const setting *s, const nqm_fit_entry *entry, const nqm_fit_options *options,
                              const nqm_fit_visual *judge, nqm_match_report *report, nqm_brdf **brdf_ret,
                              nqm_error *err) {
    const char *polish = strchr(s->loss->text, ':') ? s->loss->text + 5 : nqm_match_polish;
    nqm_fit_choice choice;
    nqm_status status = nqm_fit_select(s->ref, entry, options, judge, &choice, err);
    if (status != NQM_OK)
        return status;
    report->fit = choice.report;
    report->difference = report->fit.loss;
    snprintf(report->selected, sizeof report->selected, "%s%s%.80s", nqm_fit_loss_words[choice.loss],
             choice.polished ? ", then " : "", choice.polished ? polish : "");
    return nqm_brdf_open(report->fit.spec, brdf_ret, err);
}

/* Fit by the sum, or select by it. */
static nqm_status fit_by(const setting *s, const nqm_fit_entry *entry, const nqm_match_sum *sum,
                         nqm_match_report *report, nqm_brdf **brdf_ret, nqm_error *err) {
    binding b = {.n = 0};
    nqm_match_visual transport = {.scorer = NULL};
    const bool has_judge = s->judge || s->loss->transport;
    const nqm_match_visual *judge = s->judge ? s->judge : &transport;
    const nqm_error *failures[] = {&b.metric.failure, &b.transport.failure, &judge->failure};
    nqm_fit_options options = s->options;
    nqm_status status = NQM_OK;
    for (size_t i = 0; status == NQM_OK && i < sum->n; ++i)
        status = bind_term(s, &sum->terms[i], &b, err);
    nqm_status judged = status; /* a fit that is no selection does without a judge */
    if (status == NQM_OK && has_judge && !s->judge)
        judged = nqm_match_visual_make(s->loss->transport, s->ref, &transport, err);
    if (sum->is_auto || judged != NQM_ERR_INCOMPATIBLE)
        status = judged;
    options.terms = b.terms;
    options.n_terms = b.n;
    int n_threads = nqm_limit_threads(1); /* of a score of one pair */
    if (status == NQM_OK && sum->is_auto)
        status = select_best(s, entry, &options, &judge->visual, report, brdf_ret, err);
    else if (status == NQM_OK)
        status = nqm_fit(s->ref, s->model, &options, &report->fit, brdf_ret, err);
    status = explain(3, failures, status, err);
    if (status == NQM_OK && !sum->is_auto && has_judge && judged == NQM_OK)
        status = compare(judge, *brdf_ret, &report->difference, err);
    nqm_limit_threads(n_threads);
    nqm_match_visual_free(&transport);
    nqm_match_visual_free(&b.metric);
    nqm_match_visual_free(&b.transport);
    return status;
}

/* ---- references with few values ---------------------------------------------------------------------------------- */

const char *const nqm_match_uncovered =
    "ma_crwe, as too few directions of transport see the reference, which is anisotropic or a list";

/* Whether the directions of a model have values: of a list of measured ones, those of near rows. */
static bool is_covered(const nqm_brdf *ref, const nqm_model *model) {
    const double near = NQM_PI / 180;
    const nqm_directions *directions = nqm_model_get_info(model).directions;
    const double *wi = nqm_directions_get_info(directions).wi, *wo = nqm_directions_get_info(directions).wo;
    const size_t n = nqm_directions_get_info(directions).n;
    size_t n_near = 0;
    for (size_t i = 0; i < n; ++i) {
        double rgb[3];
        uint8_t flag;
        nqm_brdf_eval(ref, 1, wi + 3 * i, wo + 3 * i, rgb, &flag);
        n_near += nqm_has_value(flag) && nqm_scattered_distance(ref, wi + 3 * i, wo + 3 * i) < near;
    }
    return (double)n_near >= nqm_score_options_default().min_valid_fraction * (double)n;
}

/* ---- public entry ------------------------------------------------------------------------------------------------ */

static nqm_status match(const setting *s, const nqm_fit_entry *entry, const nqm_match_sum *sum,
                        nqm_match_report *report, nqm_brdf **brdf_ret, nqm_error *err) {
    if (entry->encode) {
        const nqm_status own = nqm_fit(s->ref, s->model, &s->options, &report->fit, brdf_ret, err);
        if (own != NQM_ERR_INCOMPATIBLE || !nqm_scattered_rows(s->ref, NULL, NULL))
            return own;
        return nqm_fail(err, own, -1, "%s: a list of directions; only analytic and shading models can be fitted to it",
                        nqm_brdf_get_info(s->ref).name);
    }
    if (sum->is_auto && !s->judge && !s->loss->transport)
        return nqm_fail(err, NQM_ERR_ARG, -1, "the loss 'auto' needs a scene or a model for transport");
    return fit_by(s, entry, sum, report, brdf_ret, err);
}

nqm_status nqm_match(const nqm_brdf *ref, const char *model, const nqm_match_loss *loss,
                     const nqm_fit_options *options_or_null, nqm_match_report *report_ret, nqm_brdf **brdf_ret,
                     nqm_error *err) {
    if (brdf_ret)
        *brdf_ret = NULL;
    NQM_REQUIRE(err, ref, model, report_ret);
    if (!loss) {
        *report_ret = (nqm_match_report){.difference = NAN};
        return nqm_fit(ref, model, options_or_null, &report_ret->fit, brdf_ret, err);
    }
    setting s = {.ref = ref, .model = model, .loss = loss};
    s.options = options_or_null ? *options_or_null : nqm_fit_options_default();
    nqm_match_report report = {.difference = NAN};
    nqm_match_visual judge = {.scorer = NULL};
    nqm_brdf *brdf = NULL;
    nqm_match_sum sum;
    const nqm_fit_entry *entry;
    const nqm_match_loss values = {.text = "ma_crwe"};
    nqm_status status = nqm_match_parse(loss->text, &sum, err);
    if (status == NQM_OK)
        status = nqm_fit_entry_find(model, &entry, err);
    if (status == NQM_OK && sum.is_auto && loss->transport && !entry->encode &&
        (!is_covered(ref, loss->transport) || (!loss->scene && nqm_brdf_anisotropy(ref) > 0))) {
        s.loss = &values;
        status = nqm_match_parse(values.text, &sum, err);
        snprintf(report.selected, sizeof report.selected, "%s", nqm_match_uncovered);
    }
    /* A list has values at its own directions only, not on rays. */
    if (status == NQM_OK && s.loss->scene && !entry->encode && !nqm_scattered_rows(ref, NULL, NULL)) {
        status = nqm_match_rays_make(loss->scene, ref, N_RAYS, s.options.seed, &judge, err);
        s.judge = &judge;
    }
    if (status == NQM_OK)
        status = match(&s, entry, &sum, &report, &brdf, err);
    nqm_match_visual_free(&judge);
    if (status == NQM_OK)
        *report_ret = report;
    if (status == NQM_OK && brdf_ret)
        *brdf_ret = brdf;
    else
        nqm_brdf_free(brdf);
    return status;
}
