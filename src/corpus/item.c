/* SPDX-License-Identifier: MIT
 *
 * Makes one material group: open its forms, encode each reference by every model, sample and render each BRDF once, label
 * every test by the Delta-E ITP between its picture and that of its reference, and select far tests by their labels. A model
 * that cannot encode a reference fails this test only.
 */
#include "brdf/brdf.h"
#include "corpus/corpus.h"
#include "fit/fit.h"
#include "math/math.h"

#include <math.h>
#include <string.h>

typedef nqm_corpus_view view;

/* State of making a group. */
typedef struct job {
    const nqm_corpus_context *context;
    nqm_corpus_item *item;
    size_t n; /* directions */
    size_t n_fits;
    const view **forms;          /* (n_forms) of the cache, or in `presets` */
    view *presets;               /* (n_forms) forms that are no references of the list; the others are empty */
    nqm_corpus_fit *fits;        /* (n_fits) of the current reference */
    view made;                   /* view of a test whose BRDF is made for it */
    nqm_fit_report report;       /* its spec: of a point on the path of an optimiser, or of a translation */
    double saved_s, save_cost_s; /* time of the last save of the unfinished group, and its duration */
    nqm_error *err;
} job;

static nqm_status open_preset(const job *j, size_t form) {
    view *v = &j->presets[form];
    nqm_status status = nqm_corpus_view_alloc(j->context, v, j->err);
    if (status == NQM_OK)
        status = nqm_corpus_open(j->context, j->item->plan.forms[form].path, &v->brdf, j->err);
    return status == NQM_OK ? nqm_corpus_view_fill(j->context, v, j->err) : status;
}

static nqm_status open_forms(job *j) {
    const nqm_corpus_plan *plan = &j->item->plan;
    size_t first_ref = j->context->list->groups[plan->group].first_ref;
    nqm_status status = NQM_OK;
    for (size_t f = 0; status == NQM_OK && f < plan->n_refs; ++f) {
        status = nqm_corpus_cached(j->context, first_ref + f, &j->forms[f], j->err);
        if (status != NQM_OK)
            return status;
        memcpy(j->item->ref_rgb + 3 * j->n * f, j->forms[f]->rgb, 3 * j->n * sizeof(float));
        memcpy(j->item->ref_used + j->n * f, j->forms[f]->used, j->n);
    }
    for (size_t f = plan->n_refs; status == NQM_OK && f < plan->n_forms; ++f) {
        j->forms[f] = &j->presets[f];
        status = open_preset(j, f);
    }
    return status;
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

/* Whether a test of the reference is made from its encoding by model k. */
static bool is_needed(const job *j, size_t ref, size_t k) {
    const nqm_corpus_plan *plan = &j->item->plan;
    for (size_t t = 0; t < plan->n_tests; ++t)
        if (plan->tests[t].ref == ref && plan->tests[t].base == NQM_BASE_FIT && plan->tests[t].which == k)
            return true;
    return false;
}

static nqm_status make_fit(const job *j, size_t ref, size_t k) {
    const char *model = j->context->models.name[k];
    nqm_corpus_fit *fit = &j->fits[k];
    nqm_fit_options options = nqm_fit_options_default();
    options.seed = j->context->options->seed;
    options.progress = fit_progress;
    options.progress_user = (void *)j->context;
    nqm_brdf_free(fit->view.brdf);
    fit->view.brdf = NULL;
    fit->fault = (nqm_error){0};
    fit->is_viewed = false;
    if (!is_needed(j, ref, k)) { /* nqm_corpus_options.every has left out its tests */
        fit->fault.status = NQM_ERR_INCOMPATIBLE;
        return NQM_OK;
    }
    if (nqm_corpus_fit_load(j->item, ref, model, fit))
        return NQM_OK;
    nqm_status status = nqm_fit(j->forms[ref]->brdf, model, &options, &fit->report, &fit->view.brdf, &fit->fault);
    if (status == NQM_OK)
        status = nqm_corpus_view_fill(j->context, &fit->view, &fit->fault);
    fit->is_viewed = true;
    fit->fault.status = status;
    if (!is_fatal(status))
        return nqm_corpus_fit_save(j->item, ref, model, fit, j->err);
    if (j->err)
        *j->err = fit->fault;
    return status;
}

static nqm_status make_fits(const job *j, size_t ref) {
    nqm_status status = NQM_OK;
    for (size_t k = 0; status == NQM_OK && k < j->n_fits; ++k) {
        status = make_fit(j, ref, k);
        if (status == NQM_OK && j->context->step(j->context->step_user, NQM_CORPUS_FIT_UNITS))
            status = nqm_fail(j->err, NQM_ERR_CANCELLED, -1, "corpus: stopped");
    }
    return status;
}

/* ---- one test ---------------------------------------------------------------------------------------------------- */

/* The encoding of a test; a perturbed test uses the next encoding that succeeded. */
static const nqm_corpus_fit *fit_of(const job *j, const nqm_corpus_test *test) {
    const nqm_corpus_fit *fit = &j->fits[test->which];
    for (size_t k = 1; *test->perturbation[0] && fit->fault.status != NQM_OK && k < j->n_fits; ++k)
        fit = &j->fits[(test->which + k) % j->n_fits];
    return fit;
}

static const view *base_view(const job *j, const nqm_corpus_test *test) {
    switch (test->base) {
    case NQM_BASE_FIT:
        return &fit_of(j, test)->view;
    case NQM_BASE_FORM:
        return j->forms[test->which];
    default:
        return j->forms[test->ref];
    }
}

/* Directions of an overfitted network: those of the corpus may be fewer than planned. */
static size_t overfitted_directions(const job *j, const nqm_corpus_test *test) {
    return test->which ? nqm_smaller(test->path.n_steps, j->n) : test->path.n_steps;
}

/* The name of the BRDF that a test is derived from. `before` receives "nbrdf of " when that is an encoding without a spec,
 * and so on; it is then the name of the reference. */
static const char *base_name(const job *j, const nqm_corpus_test *test, char before[64]) {
    const nqm_corpus_form *forms = j->item->plan.forms;
    const nqm_corpus_ref *refs = j->context->list->refs;
    const nqm_corpus_fit *fit;
    *before = 0;
    switch (test->base) {
    case NQM_BASE_FIT:
        fit = fit_of(j, test);
        if (fit->fault.status == NQM_OK && *fit->report.spec)
            return fit->report.spec;
        snprintf(before, 64, "%s of ", j->context->models.name[fit - j->fits]);
        break;
    case NQM_BASE_FORM:
        return forms[test->which].brdf;
    case NQM_BASE_OTHER:
        return refs[test->which].brdf;
    case NQM_BASE_SPEC:
        return test->spec;
    case NQM_BASE_PATH:
    case NQM_BASE_TRANSLATED:
        return j->report.spec;
    case NQM_BASE_TABLE:
        snprintf(before, 64, "table of ");
        break;
    case NQM_BASE_OVERFIT:
        snprintf(before, 64, "nbrdf at %zu directions of ", overfitted_directions(j, test));
        break;
    case NQM_BASE_BETWEEN:
    case NQM_BASE_REF:
        break;
    }
    return forms[test->ref].brdf;
}

/* "perturb:OUTER;of=perturb:INNER;of=BASE"; encodings without a spec are "nbrdf of BASE". */
static char *test_name(const job *j, const nqm_corpus_test *test) {
    char before[64];
    const char *base = base_name(j, test, before), *with = "";
    if (test->base == NQM_BASE_BETWEEN)
        with = j->context->list->refs[test->which].brdf;
    size_t n = strlen(base) + strlen(with) + sizeof before + sizeof test->perturbation + sizeof test->between + 60,
           used = 0;
    char *name = nqm_alloc(n, 1);
    if (!name)
        return NULL;
    for (int k = 1; k >= 0; --k)
        if (*test->perturbation[k])
            used += (size_t)snprintf(name + used, n - used, "perturb:%s;of=", test->perturbation[k]);
    if (*with)
        used += (size_t)snprintf(name + used, n - used, "between:%s;with=(%s);of=", test->between, with);
    snprintf(name + used, n - used, "%s%s", before, base);
    return name;
}

/* Apply the test's perturbations to its base, which is borrowed. */
static nqm_status perturb(const nqm_corpus_test *test, nqm_brdf *base, nqm_brdf **brdf_ret, nqm_error *err) {
    nqm_brdf *brdf = base;
    nqm_status status = NQM_OK;
    *brdf_ret = NULL;
    for (int k = 0; status == NQM_OK && k < 2 && *test->perturbation[k]; ++k)
        status = nqm_perturb_wrap(test->perturbation[k], brdf, k > 0, &brdf, err);
    if (status == NQM_OK)
        *brdf_ret = brdf;
    return status;
}

/* A BRDF between the reference and another material. */
static nqm_status between(const job *j, const nqm_corpus_test *test, nqm_brdf **brdf_ret, nqm_error *err) {
    const view *other;
    *brdf_ret = NULL;
    nqm_status status = nqm_corpus_cached(j->context, test->which, &other, err);
    return status == NQM_OK ? nqm_between_wrap(test->between, j->forms[test->ref]->brdf, other->brdf, brdf_ret, err)
                            : status;
}

/* Directions of the fits whose paths are followed: the loss need not be exact, and every step evaluates them ten times. */
enum { N_PATH_DIRECTIONS = 1000 };

static nqm_status follow_path(job *j, const nqm_corpus_test *test, nqm_brdf **brdf_ret, nqm_error *err) {
    nqm_fit_options options = nqm_fit_options_default();
    options.loss = test->path.loss;
    options.n_directions = N_PATH_DIRECTIONS;
    options.seed = test->path.seed;
    *brdf_ret = NULL;
    *j->report.spec = 0;
    nqm_status status = nqm_fit_path(j->forms[test->ref]->brdf, test->path.model, &options, test->path.seed,
                                     test->path.n_steps, j->report.spec, err);
    return status == NQM_OK ? nqm_brdf_open(j->report.spec, brdf_ret, err) : status;
}

static nqm_status translate(job *j, const nqm_corpus_test *test, nqm_brdf **brdf_ret, nqm_error *err) {
    nqm_fit_options options = nqm_fit_options_default();
    options.n_directions = N_PATH_DIRECTIONS;
    options.seed = test->path.seed;
    options.progress = fit_progress;
    options.progress_user = (void *)j->context;
    *j->report.spec = 0;
    return nqm_fit(j->forms[test->ref]->brdf, test->path.model, &options, &j->report, brdf_ret, err);
}

/* A network that is fitted to few directions, random ones or some of the corpus's own. */
static nqm_status overfit(const job *j, const nqm_corpus_test *test, nqm_brdf **brdf_ret, nqm_error *err) {
    const double *degrees = nqm_directions_degrees(j->context->directions), degree = NQM_PI / 180;
    const size_t n_own = test->which ? j->n : 0, n = overfitted_directions(j, test);
    nqm_rng rng = nqm_rng_make(test->path.seed, 0);
    double *hd;
    size_t *own;
    nqm_status status = nqm_alloc_arrays(NQM_ARRAYS({&hd, n, 3 * sizeof *hd}, {&own, n_own, sizeof *own}), err);
    if (status != NQM_OK)
        return status;
    for (size_t i = 0; i < n_own; ++i)
        own[i] = i;
    nqm_rng_shuffle(&rng, n_own, own);
    for (size_t i = 0; i < n; ++i)
        if (!n_own)
            nqm_encode_draw_dense(&rng, 80 * degree, NQM_PI / 2, NQM_PI, hd + 3 * i);
        else
            for (size_t k = 0; k < 3; ++k)
                hd[3 * i + k] = degrees[3 * own[i] + k] * degree;
    status = nqm_encode_nbrdf_at(j->forms[test->ref]->brdf, n, hd, test->path.seed, brdf_ret, err);
    nqm_free(hd);
    return status;
}

/* The BRDF of a test that has one of its own. */
static nqm_status make_brdf(job *j, const nqm_corpus_test *test, nqm_brdf **brdf_ret, nqm_error *err) {
    switch (test->base) {
    case NQM_BASE_BETWEEN:
        return between(j, test, brdf_ret, err);
    case NQM_BASE_SPEC:
        return nqm_brdf_open(test->spec, brdf_ret, err);
    case NQM_BASE_PATH:
        return follow_path(j, test, brdf_ret, err);
    case NQM_BASE_TRANSLATED:
        return translate(j, test, brdf_ret, err);
    case NQM_BASE_TABLE:
        return nqm_brdf_tabulate(j->forms[test->ref]->brdf, nqm_table_general, NULL, brdf_ret, err);
    case NQM_BASE_OVERFIT:
        return overfit(j, test, brdf_ret, err);
    default:
        return perturb(test, base_view(j, test)->brdf, brdf_ret, err);
    }
}

static bool has_own_brdf(const nqm_corpus_test *test) {
    return *test->perturbation[0] || test->base >= NQM_BASE_BETWEEN;
}

static nqm_status view_fit(const job *j, nqm_corpus_fit *fit, nqm_error *err) {
    const nqm_status status = fit->is_viewed ? NQM_OK : nqm_corpus_view_fill(j->context, &fit->view, err);
    fit->is_viewed = status == NQM_OK;
    return status;
}

static nqm_status test_view(job *j, const nqm_corpus_test *test, const view **view_ret, nqm_error *err) {
    const nqm_corpus_fit *fit = test->base == NQM_BASE_FIT ? fit_of(j, test) : NULL;
    if (fit && fit->fault.status != NQM_OK) {
        *err = fit->fault;
        return err->status;
    }
    if (test->base == NQM_BASE_OTHER)
        return nqm_corpus_cached(j->context, test->which, view_ret, err);
    if (!has_own_brdf(test)) {
        *view_ret = base_view(j, test);
        return fit ? view_fit(j, &j->fits[fit - j->fits], err) : NQM_OK;
    }
    *view_ret = &j->made;
    nqm_brdf_free(j->made.brdf);
    j->made.brdf = NULL;
    nqm_status status = make_brdf(j, test, &j->made.brdf, err);
    return status == NQM_OK ? nqm_corpus_view_fill(j->context, &j->made, err) : status;
}

static nqm_status label_test(job *j, size_t t, nqm_error *err) {
    nqm_corpus_item *item = j->item;
    const nqm_corpus_test *test = &item->plan.tests[t];
    const view *v;
    nqm_status status = test_view(j, test, &v, err);
    if (status != NQM_OK)
        return status;
    const nqm_label label = nqm_scene_compare_halves(j->context->scene, j->forms[test->ref]->picture, v->picture);
    if (!isfinite(label.delta_e))
        return nqm_fail(err, NQM_ERR_NUMERIC, -1, "Delta-E is not finite");
    item->label[t] = label;
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
    item->kept[t] = 1;
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

/* Keep n_far of the far tests of a reference. */
static nqm_status select_far(const job *j, size_t ref) {
    nqm_corpus_item *item = j->item;
    const nqm_corpus_options *options = j->context->options;
    const nqm_curve curve = nqm_curve_default();
    const size_t n_kept = nqm_corpus_far_kept(options), n = nqm_corpus_candidates(n_kept);
    size_t first = 0;
    while (first < item->plan.n_tests &&
           !(item->plan.tests[first].ref == ref && item->plan.tests[first].kind.family == NQM_FAMILY_FAR))
        ++first;
    double *jod = nqm_alloc(n, sizeof *jod);
    if (!jod)
        return nqm_fail_nomem(j->err, n * sizeof *jod);
    for (size_t i = 0; i < n; ++i)
        jod[i] = item->failures[first + i] ? NAN : nqm_curve_jod(&curve, item->label[first + i].delta_e);
    nqm_status status = nqm_corpus_spread(n, jod, n_kept, item->kept + first, j->err);
    nqm_free(jod);
    return status;
}

/* Save the first n_done tests for a later run. Saving takes at most a twentieth of the time unless the run ends here. */
static nqm_status save_tests(job *j, size_t n_done, bool ends, nqm_error *err) {
    const double begin_s = nqm_clock_s();
    if (!j->item->path || n_done == 0 || n_done == j->item->plan.n_tests ||
        (!ends && begin_s - j->saved_s < 20 * j->save_cost_s))
        return NQM_OK;
    nqm_status status = nqm_corpus_item_save(j->n, j->item, n_done, err);
    j->saved_s = nqm_clock_s();
    j->save_cost_s = j->saved_s - begin_s;
    return status;
}

/* Make tests [first, n_tests); *n_done: those that are finished, also after a failure. */
static nqm_status make_tests(job *j, size_t first, size_t *n_done) {
    const nqm_corpus_plan *plan = &j->item->plan;
    nqm_status status = NQM_OK;
    for (size_t t = *n_done = first; status == NQM_OK && t < plan->n_tests; ++t) {
        if (t == first || plan->tests[t].ref != plan->tests[t - 1].ref)
            status = make_fits(j, plan->tests[t].ref);
        if (status == NQM_OK)
            status = make_test(j, t);
        *n_done += status == NQM_OK;
        if (status == NQM_OK)
            status = save_tests(j, t + 1, false, j->err);
        if (status == NQM_OK && j->context->step(j->context->step_user, 1))
            status = nqm_fail(j->err, NQM_ERR_CANCELLED, -1, "corpus: stopped");
    }
    return status;
}

/* The tests of an interrupted run, with the encodings of their references that are not made again. */
static size_t resume(const job *j) {
    const nqm_corpus_item *item = j->item;
    const size_t n_done = item->path ? nqm_corpus_item_resume(j->n, j->item) : 0;
    const size_t n_refs = n_done ? item->plan.tests[nqm_smaller(n_done, item->plan.n_tests - 1)].ref : 0;
    j->context->step(j->context->step_user, n_done + n_refs * j->n_fits * NQM_CORPUS_FIT_UNITS);
    return n_done;
}

static nqm_status run(job *j) {
    const nqm_corpus_plan *plan = &j->item->plan;
    size_t n_done = 0;
    nqm_status status = open_forms(j);
    for (size_t k = 0; status == NQM_OK && k < j->n_fits; ++k)
        status = nqm_corpus_view_alloc(j->context, &j->fits[k].view, j->err);
    if (status == NQM_OK)
        status = nqm_corpus_view_alloc(j->context, &j->made, j->err);
    if (status == NQM_OK)
        status = make_tests(j, resume(j), &n_done);
    if (status == NQM_ERR_CANCELLED)
        (void)!save_tests(j, n_done, true, NULL); /* a failure costs the next run this time only */
    for (size_t ref = 0; status == NQM_OK && j->context->options->n_far > 0 && ref < plan->n_refs; ++ref)
        status = select_far(j, ref);
    return status;
}

nqm_status nqm_corpus_item_make(const nqm_corpus_context *context, nqm_corpus_item *item, nqm_error *err) {
    job j = {.context = context,
             .item = item,
             .n = nqm_directions_count(context->directions),
             .n_fits = context->models.n,
             .err = err};
    nqm_status status = nqm_alloc_arrays(NQM_ARRAYS({&j.forms, item->plan.n_forms, sizeof *j.forms},
                                                    {&j.presets, item->plan.n_forms, sizeof *j.presets},
                                                    {&j.fits, j.n_fits, sizeof *j.fits}),
                                         err);
    if (status != NQM_OK)
        return status;
    status = run(&j);
    for (size_t f = 0; f < item->plan.n_forms; ++f)
        nqm_corpus_view_free(&j.presets[f]);
    for (size_t k = 0; k < j.n_fits; ++k)
        nqm_corpus_view_free(&j.fits[k].view);
    nqm_corpus_view_free(&j.made);
    nqm_free(j.forms);
    return status;
}
