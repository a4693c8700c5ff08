/* SPDX-License-Identifier: MIT
 *
 * The work on one material group: open its forms, fit each reference, sample and render everything once, and label
 * every test by the Delta-E ITP between its picture and that of its reference.
 */
#include "brdf/brdf.h"
#include "label/corpus.h"

#include <math.h>
#include <string.h>

/* A BRDF with its samples and its picture. */
typedef struct view {
    nqm_brdf *brdf;
    float *rgb;      /* (n, 3) */
    uint8_t *used;   /* (n) */
    double *picture; /* (n_points, 3) cd/m2 */
} view;

/* A group while it is worked on. */
typedef struct job {
    const nqm_corpus_context *context;
    nqm_corpus_item *item;
    size_t n, n_points; /* directions, pixels */
    view *forms;        /* (n_forms) */
    view fits[NQM_CORPUS_N_FITS];
    char fit_specs[NQM_CORPUS_N_FITS][512];
    view perturbed;
    nqm_error *err;
} job;

static nqm_status alloc_view(const job *j, view *v) {
    v->rgb = nqm_alloc(3 * j->n, sizeof *v->rgb);
    v->used = nqm_alloc(j->n, 1);
    v->picture = nqm_alloc(3 * j->n_points, sizeof *v->picture);
    return v->rgb && v->used && v->picture ? NQM_OK : nqm_fail_nomem(j->err, 13 * j->n + 24 * j->n_points);
}

static void free_view(view *v) {
    nqm_brdf_free(v->brdf);
    nqm_free(v->rgb);
    nqm_free(v->used);
    nqm_free(v->picture);
    *v = (view){0};
}

/* Sample and render v->brdf. */
static nqm_status look(const job *j, view *v) {
    nqm_status status = nqm_sample(v->brdf, j->context->directions, NQM_INVALID_DROP, v->rgb, v->used, NULL, j->err);
    for (size_t i = 0; status == NQM_OK && i < j->n; ++i)
        v->used[i] = v->used[i] == NQM_VALUE_OK || v->used[i] == NQM_VALUE_CLAMPED;
    return status == NQM_OK ? nqm_scene_render(j->context->scene, v->brdf, v->picture, j->err) : status;
}

/* The form as the corpus reads it, as reference, as test and below every perturbation alike: decoders of neural
 * processes as tables, because dozens of copies are rendered; forms that are not reciprocal in one half of their pairs,
 * as the sampling directions and perturbations read them. */
static nqm_status open_form(const char *path, nqm_brdf **brdf_ret, nqm_error *err) {
    nqm_brdf *form;
    nqm_status status = nqm_brdf_open(path, &form, err);
    if (status != NQM_OK)
        return status;
    if (strcmp(nqm_brdf_get_info(form).format, "nps") == 0) {
        status = nqm_corpus_tabulate(form, brdf_ret, err);
        nqm_brdf_free(form);
        return status;
    }
    return nqm_corpus_fold(form, true, brdf_ret, err);
}

static nqm_status open_forms(job *j) {
    const nqm_corpus_plan *plan = &j->item->plan;
    for (size_t f = 0; f < plan->n_forms; ++f) {
        view *v = &j->forms[f];
        nqm_status status = alloc_view(j, v);
        if (status == NQM_OK)
            status = open_form(plan->forms[f].path, &v->brdf, j->err);
        if (status == NQM_OK)
            status = look(j, v);
        if (status != NQM_OK)
            return status;
        if (f < plan->n_refs) {
            memcpy(j->item->ref_rgb + 3 * j->n * f, v->rgb, 3 * j->n * sizeof(float));
            memcpy(j->item->ref_used + j->n * f, v->used, j->n);
        }
    }
    return NQM_OK;
}

static nqm_status make_fits(job *j, size_t ref) {
    for (size_t k = 0; k < NQM_CORPUS_N_FITS; ++k) {
        nqm_fit_options options = nqm_fit_options_default();
        nqm_fit_report report;
        options.loss = nqm_corpus_fits[k].loss;
        options.seed = j->context->options->seed;
        nqm_status status = nqm_fit(j->forms[ref].brdf, nqm_corpus_fits[k].model, &options, &report, NULL, j->err);
        if (status != NQM_OK)
            return status;
        memcpy(j->fit_specs[k], report.spec, sizeof report.spec);
        nqm_brdf_free(j->fits[k].brdf);
        status = nqm_brdf_open(report.spec, &j->fits[k].brdf, j->err);
        if (status == NQM_OK)
            status = look(j, &j->fits[k]);
        if (status != NQM_OK)
            return status;
    }
    return NQM_OK;
}

/* ---- one test ---------------------------------------------------------------------------------------------------- */

static const view *base_view(const job *j, const nqm_corpus_test *test) {
    switch (test->base) {
    case NQM_BASE_FIT:
        return &j->fits[test->which];
    case NQM_BASE_FORM:
        return &j->forms[test->which];
    case NQM_BASE_REF:
        break;
    }
    return &j->forms[test->ref];
}

static const char *base_text(const job *j, const nqm_corpus_test *test) {
    if (test->base == NQM_BASE_FIT)
        return j->fit_specs[test->which];
    return j->item->plan.forms[test->base == NQM_BASE_REF ? test->ref : test->which].brdf;
}

/* "perturb:OUTER;of=perturb:INNER;of=BASE" */
static char *test_name(const job *j, const nqm_corpus_test *test) {
    const char *base = base_text(j, test);
    size_t n = strlen(base) + sizeof test->perturbation + 40, used = 0;
    char *name = nqm_alloc(n, 1);
    if (!name)
        return NULL;
    for (int k = 1; k >= 0; --k)
        if (*test->perturbation[k])
            used += (size_t)snprintf(name + used, n - used, "perturb:%s;of=", test->perturbation[k]);
    snprintf(name + used, n - used, "%s", base);
    return name;
}

/* Put the test's perturbations over its base, which is lent. */
static nqm_status perturb(const nqm_corpus_test *test, nqm_brdf *base, nqm_brdf **brdf_ret, nqm_error *err) {
    nqm_brdf *brdf;
    *brdf_ret = NULL;
    nqm_status status = nqm_corpus_fold(base, false, &brdf, err);
    for (int k = 0; status == NQM_OK && k < 2 && *test->perturbation[k]; ++k)
        status = nqm_perturb_wrap(test->perturbation[k], brdf, &brdf, err);
    if (status == NQM_OK)
        *brdf_ret = brdf;
    return status;
}

/* The view of a test: its base's own, or the perturbed one. */
static nqm_status test_view(job *j, const nqm_corpus_test *test, const view **view_ret) {
    const view *base = base_view(j, test);
    *view_ret = base;
    if (!*test->perturbation[0])
        return NQM_OK;
    *view_ret = &j->perturbed;
    nqm_brdf_free(j->perturbed.brdf);
    j->perturbed.brdf = NULL;
    nqm_status status = perturb(test, base->brdf, &j->perturbed.brdf, j->err);
    return status == NQM_OK ? look(j, &j->perturbed) : status;
}

static nqm_status make_test(job *j, size_t t) {
    nqm_corpus_item *item = j->item;
    const nqm_corpus_test *test = &item->plan.tests[t];
    const view *v;
    nqm_status status = test_view(j, test, &v);
    if (status != NQM_OK)
        return status;
    item->names[t] = test_name(j, test);
    if (!item->names[t])
        return nqm_fail_nomem(j->err, 512);
    memcpy(item->test_rgb + 3 * j->n * t, v->rgb, 3 * j->n * sizeof(float));
    memcpy(item->test_used + j->n * t, v->used, j->n);
    item->delta_e[t] = nqm_scene_delta_e(j->context->scene, j->forms[test->ref].picture, v->picture);
    if (!isfinite(item->delta_e[t]))
        return nqm_fail(j->err, NQM_ERR_NUMERIC, -1, "%s: Delta-E against %s is not finite", item->names[t],
                        item->plan.forms[test->ref].brdf);
    return NQM_OK;
}

static nqm_status run(job *j) {
    const nqm_corpus_plan *plan = &j->item->plan;
    nqm_status status = open_forms(j);
    for (size_t k = 0; status == NQM_OK && k < NQM_CORPUS_N_FITS; ++k)
        status = alloc_view(j, &j->fits[k]);
    if (status == NQM_OK)
        status = alloc_view(j, &j->perturbed);
    for (size_t t = 0; status == NQM_OK && t < plan->n_tests; ++t) {
        if (t == 0 || plan->tests[t].ref != plan->tests[t - 1].ref)
            status = make_fits(j, plan->tests[t].ref);
        if (status == NQM_OK)
            status = make_test(j, t);
        if (status == NQM_OK && j->context->step(j->context->step_user))
            status = nqm_fail(j->err, NQM_ERR_CANCELLED, -1, "corpus: stopped");
    }
    return status;
}

nqm_status nqm_corpus_item_make(const nqm_corpus_context *context, nqm_corpus_item *item, nqm_error *err) {
    job j = {.context = context,
             .item = item,
             .n = nqm_directions_count(context->directions),
             .n_points = nqm_scene_count(context->scene),
             .err = err};
    j.forms = nqm_alloc(item->plan.n_forms, sizeof *j.forms);
    if (!j.forms)
        return nqm_fail_nomem(err, item->plan.n_forms * sizeof *j.forms);
    nqm_status status = run(&j);
    for (size_t f = 0; f < item->plan.n_forms; ++f)
        free_view(&j.forms[f]);
    for (size_t k = 0; k < NQM_CORPUS_N_FITS; ++k)
        free_view(&j.fits[k]);
    free_view(&j.perturbed);
    nqm_free(j.forms);
    return status;
}
