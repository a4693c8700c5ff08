/* SPDX-License-Identifier: MIT
 *
 * The tests of each reference of a material group. Encodings, published fits and other forms of the same material are the
 * differences that occur in practice; perturbations cover the range from invisible to strong, one kind of difference at a
 * time; far tests are BRDFs that really differ.
 */
#include "base/names.h"
#include "brdf/brdf.h"
#include "corpus/corpus.h"

#include <string.h>

/* ---- forms of the material --------------------------------------------------------------------------------------- */

static bool is_preset(const char *brdf) {
    for (size_t i = 0; i < nqm_brdf_preset_count(); ++i)
        if (strcmp(nqm_brdf_preset_name(i), brdf) == 0)
            return true;
    return false;
}

/* "published-sgd" of the preset sgd:nickel; "form-rgl" of a reference of the source rgl. */
static nqm_corpus_kind kind_of_form(const char *brdf, const char *source) {
    nqm_corpus_kind kind = {.family = NQM_FAMILY_FORM};
    if (is_preset(brdf)) {
        kind.family = NQM_FAMILY_PUBLISHED;
        snprintf(kind.name, sizeof kind.name, "published-%.*s", (int)strcspn(brdf, ":"), brdf);
    } else {
        snprintf(kind.name, sizeof kind.name, "form-%s", source);
    }
    return kind;
}

/* Whether a preset has the group's name ("sgd:nickel" for nickel) and is not in the list. */
static bool adds_to(const nqm_corpus_plan *plan, const char *preset, const char *group) {
    const char *colon = strchr(preset, ':');
    if (!colon || strcmp(colon + 1, group) != 0)
        return false;
    for (size_t f = 0; f < plan->n_refs; ++f)
        if (strcmp(plan->forms[f].brdf, preset) == 0)
            return false;
    return true;
}

static nqm_status plan_forms(const nqm_corpus_list *list, const nqm_corpus_group *group, nqm_corpus_plan *plan,
                             nqm_error *err) {
    size_t n_presets = nqm_brdf_preset_count(), n_max = plan->n_refs;
    for (size_t i = 0; i < n_presets; ++i) {
        const char *colon = strchr(nqm_brdf_preset_name(i), ':');
        n_max += colon && strcmp(colon + 1, group->name) == 0;
    }
    plan->forms = nqm_alloc(n_max, sizeof *plan->forms);
    if (!plan->forms)
        return nqm_fail_nomem(err, n_max * sizeof *plan->forms);
    for (; plan->n_forms < plan->n_refs; ++plan->n_forms) {
        const nqm_corpus_ref *ref = &list->refs[group->first_ref + plan->n_forms];
        plan->forms[plan->n_forms] = (nqm_corpus_form){ref->brdf, ref->path, kind_of_form(ref->brdf, ref->source)};
    }
    for (size_t i = 0; i < n_presets; ++i) {
        const char *preset = nqm_brdf_preset_name(i);
        if (adds_to(plan, preset, group->name))
            plan->forms[plan->n_forms++] = (nqm_corpus_form){preset, preset, kind_of_form(preset, "")};
    }
    return NQM_OK;
}

/* ---- models ------------------------------------------------------------------------------------------------------ */

static bool listed(const char *list, const char *name) {
    size_t n = strlen(name);
    for (const char *at = list; *at; at += strcspn(at, ","), at += *at == ',')
        if (strcspn(at, ",") == n && strncmp(at, name, n) == 0)
            return true;
    return false;
}

/* The first n characters of `word` must be a model, which does not occur again after them. */
static nqm_status check_model(const char *word, size_t n, nqm_error *err) {
    char name[64];
    snprintf(name, sizeof name, "%.*s", (int)(n < sizeof name ? n : sizeof name - 1), word);
    nqm_nearest nearest = nqm_nearest_begin(name);
    if (strcmp(name, "all") == 0)
        return NQM_OK;
    for (size_t k = 0; nqm_fit_model(k); ++k) {
        if (strcmp(nqm_fit_model(k), name) == 0)
            return listed(word + n + (word[n] == ','), name)
                       ? nqm_fail(err, NQM_ERR_ARG, -1, "the model '%s' is listed twice", name)
                       : NQM_OK;
        nqm_nearest_add(&nearest, nqm_fit_model(k));
    }
    return nqm_fail(err, NQM_ERR_ARG, -1, "a corpus has no model '%s'%s", name, nearest.advice);
}

nqm_status nqm_corpus_models_parse(const char *list, nqm_corpus_models *models_ret, nqm_error *err) {
    nqm_corpus_models models = {0};
    const bool is_all = !list || listed(list, "all");
    for (const char *at = list; at && *at; at += strcspn(at, ","), at += *at == ',') {
        const nqm_status status = check_model(at, strcspn(at, ","), err);
        if (status != NQM_OK)
            return status;
    }
    for (size_t k = 0; nqm_fit_model(k) && models.n < NQM_CORPUS_MAX_MODELS; ++k)
        if (is_all || listed(list, nqm_fit_model(k)))
            models.name[models.n++] = nqm_fit_model(k);
    *models_ret = models;
    return NQM_OK;
}

/* ---- the plan ---------------------------------------------------------------------------------------------------- */

uint64_t nqm_corpus_stream(const char *name) {
    uint64_t h = 0;
    for (; *name; ++name)
        h = nqm_hash_u64(h, (unsigned char)*name);
    return h;
}

/* The candidates of the far tests of a reference. */
static nqm_status plan_far(const nqm_corpus_list *list, size_t ref, const nqm_corpus_options *options,
                           nqm_corpus_plan *plan, nqm_error *err) {
    size_t n = nqm_corpus_candidates(nqm_corpus_far_kept(options)),
           list_ref = list->groups[plan->group].first_ref + ref;
    nqm_corpus_test *tests = plan->tests + plan->n_tests;
    plan->n_tests += n;
    nqm_status status = nqm_corpus_draw_far(list, list_ref, options->seed, options->part, n, tests, err);
    for (size_t i = 0; i < n; ++i)
        tests[i].ref = ref;
    return status;
}

static nqm_status plan_variants(const nqm_corpus_list *list, size_t ref, const nqm_corpus_options *options,
                                nqm_corpus_plan *plan, nqm_error *err) {
    const nqm_corpus_ref *r = &list->refs[list->groups[plan->group].first_ref + ref];
    nqm_corpus_test *tests = plan->tests + plan->n_tests;
    nqm_rng rng = nqm_rng_make(options->seed, nqm_hash_u64(nqm_corpus_stream(r->name), 3));
    size_t n = 0;
    nqm_status status = nqm_corpus_draw_variants(&rng, r->path, options->n_variants, &n, tests, err);
    for (size_t i = 0; i < n; ++i)
        tests[i].ref = ref;
    plan->n_tests += n;
    return status;
}

/* Keep one in `every` of the tests from `first` on, by a hash of their position. */
static void thin(size_t first, uint64_t stream, uint64_t every, nqm_corpus_plan *plan) {
    size_t n = first;
    for (size_t t = first; t < plan->n_tests; ++t)
        if (nqm_hash_u64(stream, t - first) % every == 0)
            plan->tests[n++] = plan->tests[t];
        else
            nqm_free(plan->tests[t].spec);
    for (size_t t = n; t < plan->n_tests; ++t)
        plan->tests[t] = (nqm_corpus_test){0};
    plan->n_tests = n;
}

/* All random numbers of a reference are functions of its name and the seed. */
static nqm_status plan_ref(const nqm_corpus_list *list, size_t ref, const nqm_corpus_models *models,
                           const nqm_corpus_options *options, nqm_corpus_plan *plan, nqm_error *err) {
    const size_t first = plan->n_tests;
    uint64_t stream = nqm_corpus_stream(list->refs[list->groups[plan->group].first_ref + ref].name);
    nqm_rng rng = nqm_rng_make(options->seed, stream), rounding = nqm_rng_make(options->seed, nqm_hash_u64(stream, 2));
    for (size_t k = 0; k < models->n; ++k) {
        nqm_corpus_test *test = &plan->tests[plan->n_tests++];
        *test = (nqm_corpus_test){.ref = ref, .base = NQM_BASE_FIT, .which = k, .kind.family = NQM_FAMILY_ENCODING};
        snprintf(test->kind.name, sizeof test->kind.name, "%s", models->name[k]);
    }
    for (size_t f = 0; f < plan->n_forms; ++f)
        if (f != ref)
            plan->tests[plan->n_tests++] =
                (nqm_corpus_test){.ref = ref, .kind = plan->forms[f].kind, .base = NQM_BASE_FORM, .which = f};
    nqm_corpus_draw_tests(&rng, ref, models->n, options->part, options->n_perturbations, plan->tests + plan->n_tests);
    plan->n_tests += options->n_perturbations;
    nqm_corpus_draw_roundings(&rounding, ref, options->n_roundings, plan->tests + plan->n_tests);
    plan->n_tests += options->n_roundings;
    nqm_status status = plan_variants(list, ref, options, plan, err);
    if (status != NQM_OK)
        return status;
    thin(first, nqm_hash_u64(stream, options->seed), options->every, plan);
    return plan_far(list, ref, options, plan, err);
}

nqm_status nqm_corpus_plan_make(const nqm_corpus_list *list, size_t group, const nqm_corpus_models *models,
                                const nqm_corpus_options *options, nqm_corpus_plan *plan_ret, nqm_error *err) {
    const nqm_corpus_group *g = &list->groups[group];
    nqm_corpus_plan plan = {.group = group, .n_refs = g->n_refs};
    *plan_ret = (nqm_corpus_plan){0};
    nqm_status status = plan_forms(list, g, &plan, err);
    if (status != NQM_OK)
        return status;
    size_t n_tests = g->n_refs * (models->n + plan.n_forms - 1 + options->n_perturbations + options->n_roundings +
                                  options->n_variants + nqm_corpus_candidates(nqm_corpus_far_kept(options)));
    plan.tests = nqm_alloc(n_tests, sizeof *plan.tests);
    if (!plan.tests)
        status = nqm_fail_nomem(err, n_tests * sizeof *plan.tests);
    for (size_t ref = 0; status == NQM_OK && ref < g->n_refs; ++ref)
        status = plan_ref(list, ref, models, options, &plan, err);
    if (status != NQM_OK)
        nqm_corpus_plan_free(&plan);
    *plan_ret = plan;
    return status;
}

void nqm_corpus_plan_free(nqm_corpus_plan *plan) {
    for (size_t t = 0; t < plan->n_tests; ++t)
        nqm_free(plan->tests[t].spec);
    nqm_free(plan->forms);
    nqm_free(plan->tests);
    *plan = (nqm_corpus_plan){0};
}
