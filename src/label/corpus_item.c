/* SPDX-License-Identifier: MIT
 *
 * Makes one material group: open its forms, encode each reference by every model, sample and render each BRDF once, and
 * label every test by the Delta-E ITP between its picture and that of its reference. A model that cannot encode a
 * reference fails this test only.
 */
#include "brdf/brdf.h"
#include "label/corpus.h"

#include <math.h>
#include <string.h>

/* A BRDF with its samples and its picture; rgb owns the block of the arrays. */
typedef struct view {
    nqm_brdf *brdf;
    float *rgb;      /* (n, 3) */
    uint8_t *used;   /* (n) */
    double *picture; /* (n_points, 3) cd/m2 */
} view;

/* An encoding of the current reference. */
typedef struct encoding {
    view view;
    nqm_fit_report report;
    nqm_error fault; /* status NQM_OK: the encoding succeeded */
} encoding;

/* State of making a group. */
typedef struct job {
    const nqm_corpus_context *context;
    nqm_corpus_item *item;
    size_t n, n_points; /* directions, surface points */
    size_t n_fits;
    view *forms;    /* (n_forms) */
    encoding *fits; /* (n_fits) */
    view perturbed;
    nqm_error *err;
} job;

static nqm_status alloc_view(const job *j, view *v) {
    return nqm_alloc_arrays(NQM_ARRAYS({&v->rgb, j->n, 3 * sizeof *v->rgb}, {&v->used, j->n, 1},
                                       {&v->picture, j->n_points, 3 * sizeof *v->picture}),
                            j->err);
}

static void free_view(view *v) {
    nqm_brdf_free(v->brdf);
    nqm_free(v->rgb);
}

/* Sample and render v->brdf. */
static nqm_status sample_and_render(const job *j, view *v, nqm_error *err) {
    nqm_status status = nqm_sample(v->brdf, j->context->directions, NQM_INVALID_DROP, v->rgb, v->used, NULL, err);
    for (size_t i = 0; status == NQM_OK && i < j->n; ++i)
        v->used[i] = nqm_has_value(v->used[i]);
    return status == NQM_OK ? nqm_scene_render(j->context->scene, v->brdf, v->picture, err) : status;
}

/* Open a form as the corpus uses it, as reference, test and base of perturbations: decoders of neural processes as tables,
 * because dozens of copies are rendered; other forms folded, because sampling directions and perturbations use one half
 * of the pairs. */
static nqm_status open_form(const char *path, nqm_brdf **brdf_ret, nqm_error *err) {
    nqm_brdf *form;
    nqm_status status = nqm_brdf_open(path, &form, err);
    if (status != NQM_OK)
        return status;
    if (strcmp(nqm_brdf_get_info(form).format, "nps") == 0) {
        status = nqm_brdf_tabulate(form, brdf_ret, err);
        nqm_brdf_free(form);
        return status;
    }
    return nqm_brdf_fold(form, true, brdf_ret, err);
}

static nqm_status open_forms(job *j) {
    const nqm_corpus_plan *plan = &j->item->plan;
    for (size_t f = 0; f < plan->n_forms; ++f) {
        view *v = &j->forms[f];
        nqm_status status = alloc_view(j, v);
        if (status == NQM_OK)
            status = open_form(plan->forms[f].path, &v->brdf, j->err);
        if (status == NQM_OK)
            status = sample_and_render(j, v, j->err);
        if (status != NQM_OK)
            return status;
        if (f < plan->n_refs) {
            memcpy(j->item->ref_rgb + 3 * j->n * f, v->rgb, 3 * j->n * sizeof(float));
            memcpy(j->item->ref_used + j->n * f, v->used, j->n);
        }
    }
    return NQM_OK;
}

/* Errors that are not errors of a test. */
static bool is_fatal(nqm_status status) {
    return status == NQM_ERR_CANCELLED || status == NQM_ERR_NOMEM;
}

static int fit_progress(void *user, const char *stage, double done, double total) {
    const nqm_corpus_context *context = user;
    (void)stage, (void)done, (void)total;
    return context->step(context->step_user, 0);
}

static nqm_status make_fit(const job *j, const nqm_brdf *ref, size_t k) {
    encoding *fit = &j->fits[k];
    nqm_fit_options options = nqm_fit_options_default();
    options.seed = j->context->options->seed;
    options.progress = fit_progress;
    options.progress_user = (void *)j->context;
    nqm_brdf_free(fit->view.brdf);
    fit->view.brdf = NULL;
    fit->fault = (nqm_error){0};
    nqm_status status = nqm_fit(ref, j->context->models.name[k], &options, &fit->report, &fit->view.brdf, &fit->fault);
    if (status == NQM_OK)
        status = sample_and_render(j, &fit->view, &fit->fault);
    fit->fault.status = status;
    if (!is_fatal(status))
        return NQM_OK;
    if (j->err)
        *j->err = fit->fault;
    return status;
}

static nqm_status make_fits(const job *j, size_t ref) {
    nqm_status status = NQM_OK;
    for (size_t k = 0; status == NQM_OK && k < j->n_fits; ++k)
        status = make_fit(j, j->forms[ref].brdf, k);
    return status;
}

/* ---- one test ---------------------------------------------------------------------------------------------------- */

/* The encoding of a test; a perturbed test uses the next encoding that succeeded. */
static const encoding *fit_of(const job *j, const nqm_corpus_test *test) {
    const encoding *fit = &j->fits[test->which];
    for (size_t k = 1; *test->perturbation[0] && fit->fault.status != NQM_OK && k < j->n_fits; ++k)
        fit = &j->fits[(test->which + k) % j->n_fits];
    return fit;
}

static const view *base_view(const job *j, const nqm_corpus_test *test) {
    switch (test->base) {
    case NQM_BASE_FIT:
        return &fit_of(j, test)->view;
    case NQM_BASE_FORM:
        return &j->forms[test->which];
    case NQM_BASE_REF:
        break;
    }
    return &j->forms[test->ref];
}

/* "perturb:OUTER;of=perturb:INNER;of=BASE"; encodings without a spec are "nbrdf of BASE". */
static char *test_name(const job *j, const nqm_corpus_test *test) {
    const nqm_corpus_form *forms = j->item->plan.forms;
    const encoding *fit = test->base == NQM_BASE_FIT ? fit_of(j, test) : NULL;
    const char *base = forms[test->base == NQM_BASE_FORM ? test->which : test->ref].brdf, *model = "", *of = "";
    if (fit && fit->fault.status == NQM_OK && *fit->report.spec) {
        base = fit->report.spec;
    } else if (fit) {
        model = j->context->models.name[fit - j->fits];
        of = " of ";
    }
    size_t n = strlen(base) + strlen(model) + sizeof test->perturbation + 40, used = 0;
    char *name = nqm_alloc(n, 1);
    if (!name)
        return NULL;
    for (int k = 1; k >= 0; --k)
        if (*test->perturbation[k])
            used += (size_t)snprintf(name + used, n - used, "perturb:%s;of=", test->perturbation[k]);
    snprintf(name + used, n - used, "%s%s%s", model, of, base);
    return name;
}

/* Apply the test's perturbations to its base, which is borrowed. */
static nqm_status perturb(const nqm_corpus_test *test, nqm_brdf *base, nqm_brdf **brdf_ret, nqm_error *err) {
    nqm_brdf *brdf;
    *brdf_ret = NULL;
    nqm_status status = nqm_brdf_fold(base, false, &brdf, err);
    for (int k = 0; status == NQM_OK && k < 2 && *test->perturbation[k]; ++k)
        status = nqm_perturb_wrap(test->perturbation[k], brdf, &brdf, err);
    if (status == NQM_OK)
        *brdf_ret = brdf;
    return status;
}

/* The view of a test: that of its base, or the perturbed one. */
static nqm_status test_view(job *j, const nqm_corpus_test *test, const view **view_ret, nqm_error *err) {
    const view *base = base_view(j, test);
    const encoding *fit = test->base == NQM_BASE_FIT ? fit_of(j, test) : NULL;
    *view_ret = base;
    if (fit && fit->fault.status != NQM_OK) {
        *err = fit->fault;
        return err->status;
    }
    if (!*test->perturbation[0])
        return NQM_OK;
    *view_ret = &j->perturbed;
    nqm_brdf_free(j->perturbed.brdf);
    j->perturbed.brdf = NULL;
    nqm_status status = perturb(test, base->brdf, &j->perturbed.brdf, err);
    return status == NQM_OK ? sample_and_render(j, &j->perturbed, err) : status;
}

static nqm_status label_test(job *j, size_t t, nqm_error *err) {
    nqm_corpus_item *item = j->item;
    const nqm_corpus_test *test = &item->plan.tests[t];
    const view *v;
    nqm_status status = test_view(j, test, &v, err);
    if (status != NQM_OK)
        return status;
    double delta_e = nqm_scene_compare(j->context->scene, j->forms[test->ref].picture, v->picture).delta_e;
    if (!isfinite(delta_e))
        return nqm_fail(err, NQM_ERR_NUMERIC, -1, "Delta-E is not finite");
    item->delta_e[t] = delta_e;
    memcpy(item->test_rgb + 3 * j->n * t, v->rgb, 3 * j->n * sizeof(float));
    memcpy(item->test_used + j->n * t, v->used, j->n);
    if (test->kind.family == NQM_FAMILY_ENCODING)
        item->fit_loss[t] = j->fits[test->which].report.loss;
    return NQM_OK;
}

static nqm_status make_test(job *j, size_t t) {
    nqm_corpus_item *item = j->item;
    nqm_error err = {0};
    nqm_status status = label_test(j, t, &err);
    item->names[t] = test_name(j, &item->plan.tests[t]);
    if (status != NQM_OK && !is_fatal(status)) {
        item->failures[t] = nqm_strdup(*err.message ? err.message : nqm_status_text(status));
        status = item->failures[t] ? NQM_OK : NQM_ERR_NOMEM;
    }
    if (status == NQM_OK && !item->names[t])
        status = NQM_ERR_NOMEM;
    if (status == NQM_ERR_NOMEM)
        return nqm_fail_nomem(j->err, 512);
    if (status != NQM_OK && j->err)
        *j->err = err;
    return status;
}

static nqm_status run(job *j) {
    const nqm_corpus_plan *plan = &j->item->plan;
    nqm_status status = open_forms(j);
    for (size_t k = 0; status == NQM_OK && k < j->n_fits; ++k)
        status = alloc_view(j, &j->fits[k].view);
    if (status == NQM_OK)
        status = alloc_view(j, &j->perturbed);
    for (size_t t = 0; status == NQM_OK && t < plan->n_tests; ++t) {
        if (t == 0 || plan->tests[t].ref != plan->tests[t - 1].ref)
            status = make_fits(j, plan->tests[t].ref);
        if (status == NQM_OK)
            status = make_test(j, t);
        if (status == NQM_OK && j->context->step(j->context->step_user, 1))
            status = nqm_fail(j->err, NQM_ERR_CANCELLED, -1, "corpus: stopped");
    }
    return status;
}

nqm_status nqm_corpus_item_make(const nqm_corpus_context *context, nqm_corpus_item *item, nqm_error *err) {
    job j = {.context = context,
             .item = item,
             .n = nqm_directions_count(context->directions),
             .n_points = nqm_scene_count(context->scene),
             .n_fits = context->models.n,
             .err = err};
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&j.forms, item->plan.n_forms, sizeof *j.forms}, {&j.fits, j.n_fits, sizeof *j.fits}), err);
    if (status != NQM_OK)
        return status;
    status = run(&j);
    for (size_t f = 0; f < item->plan.n_forms; ++f)
        free_view(&j.forms[f]);
    for (size_t k = 0; k < j.n_fits; ++k)
        free_view(&j.fits[k].view);
    free_view(&j.perturbed);
    nqm_free(j.forms);
    return status;
}
