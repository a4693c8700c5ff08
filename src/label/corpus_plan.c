/* SPDX-License-Identifier: MIT
 *
 * What is compared with what: the tests of each reference of a material group. Own fits and other forms of the same
 * material are the differences that a metric meets in practice; perturbations fill the range from invisible to gross
 * and take the kinds of fault apart. Strengths are log-uniform, so that faint differences, where metrics fail, are as
 * common as strong ones.
 */
#include "label/corpus.h"

#include <math.h>
#include <string.h>

const nqm_corpus_fit nqm_corpus_fits[NQM_CORPUS_N_FITS] = {{"ward", NQM_FIT_LOG, NQM_KIND_WARD},
                                                           {"ggx", NQM_FIT_LOG, NQM_KIND_GGX},
                                                           {"ward", NQM_FIT_CUBE_ROOT, NQM_KIND_WARD},
                                                           {"ggx", NQM_FIT_CUBE_ROOT, NQM_KIND_GGX}};

static const char *const kind_names[NQM_KIND_COUNT] = {
    [NQM_KIND_WARD] = "ward",         [NQM_KIND_GGX] = "ggx",       [NQM_KIND_MEASURED] = "measured",
    [NQM_KIND_NBRDF] = "nbrdf",       [NQM_KIND_NPS] = "nps",       [NQM_KIND_PRESET] = "preset",
    [NQM_KIND_GLOSS] = "gloss",       [NQM_KIND_TINT] = "tint",     [NQM_KIND_SCALE] = "scale",
    [NQM_KIND_FRESNEL] = "fresnel",   [NQM_KIND_SMOOTH] = "smooth", [NQM_KIND_MIX] = "mix",
    [NQM_KIND_NOISE] = "noise",       [NQM_KIND_PEAK] = "peak",     [NQM_KIND_DESATURATE] = "desaturate",
    [NQM_KIND_QUANTISE] = "quantise", [NQM_KIND_SHIFT] = "shift",   [NQM_KIND_COMPOSED] = "composed",
    [NQM_KIND_REFIT] = "refit",
};

const char *nqm_corpus_kind_name(nqm_corpus_kind kind) {
    return kind_names[kind];
}

bool nqm_corpus_kind_unseen(nqm_corpus_kind kind) {
    return kind == NQM_KIND_QUANTISE || kind == NQM_KIND_SHIFT;
}

/* ---- forms of the material --------------------------------------------------------------------------------------- */

static nqm_corpus_kind kind_of_source(const char *source) {
    if (strcmp(source, "nbrdf") == 0)
        return NQM_KIND_NBRDF;
    if (strcmp(source, "nps") == 0)
        return NQM_KIND_NPS;
    if (strcmp(source, "sgd") == 0 || strcmp(source, "ward") == 0)
        return NQM_KIND_PRESET;
    return NQM_KIND_MEASURED;
}

/* Presets of the group's name ("sgd:nickel" for nickel) that the list itself does not hold. */
static void add_presets(const char *group, nqm_corpus_plan *plan) {
    for (size_t i = 0; i < nqm_brdf_preset_count(); ++i) {
        const char *preset = nqm_brdf_preset_name(i), *colon = strchr(preset, ':');
        bool known = !colon || strcmp(colon + 1, group) != 0 || plan->n_forms == plan->n_refs + NQM_CORPUS_MAX_PRESETS;
        for (size_t f = 0; f < plan->n_refs; ++f)
            known |= strcmp(plan->forms[f].brdf, preset) == 0;
        if (!known)
            plan->forms[plan->n_forms++] = (nqm_corpus_form){preset, preset, NQM_KIND_PRESET};
    }
}

/* ---- perturbations ----------------------------------------------------------------------------------------------- */

/* How strong a kind is: a size log-uniform in [faint, strong]. */
typedef struct strength {
    const char *key;
    double faint, strong;
    enum {
        PLAIN,  /* the value is the size */
        SIGNED, /* ... with a random sign */
        FACTOR  /* exp(+-size) */
    } form;
} strength;

static const strength strengths[NQM_KIND_COUNT] = {
    [NQM_KIND_GLOSS] = {"gloss", 0.02, 1.6, FACTOR},
    [NQM_KIND_SCALE] = {"scale", 0.01, 1.2, FACTOR},
    [NQM_KIND_FRESNEL] = {"fresnel", 0.3, 4.5, FACTOR},
    [NQM_KIND_SMOOTH] = {"smooth", 0.4, 15, PLAIN}, /* degrees */
    [NQM_KIND_MIX] = {"mix", 0.01, 0.9, PLAIN},
    [NQM_KIND_PEAK] = {"peak", 0.03, 2, FACTOR},
    [NQM_KIND_DESATURATE] = {"desaturate", 0.03, 1, SIGNED},
    [NQM_KIND_QUANTISE] = {"quantise", 1, 40, PLAIN}, /* steps a decade: fewer are worse */
    [NQM_KIND_SHIFT] = {"shift", 0.2, 12, SIGNED},    /* degrees */
    [NQM_KIND_TINT] = {"tint", 0.01, 0.8, FACTOR},
    [NQM_KIND_NOISE] = {"noise", 0.02, 1.2, PLAIN}, /* of log f_r */
};

static size_t put_number(char *text, size_t n_text, double value) {
    char number[32];
    nqm_format_double(number, sizeof number, nqm_round_digits(value, 4));
    return (size_t)snprintf(text, n_text, "%s", number);
}

/* Three factors about 1 that change the colour and leave their geometric mean. */
static void put_tint(nqm_rng *rng, double size, char *text, size_t n_text) {
    double d[3], mean = 0, largest = 0;
    for (int c = 0; c < 3; ++c) {
        d[c] = nqm_rng_normal(rng);
        mean += d[c] / 3;
    }
    for (int c = 0; c < 3; ++c)
        largest = fmax(largest, fabs(d[c] - mean));
    size_t used = 0;
    for (int c = 0; c < 3; ++c) {
        if (c > 0)
            used += (size_t)snprintf(text + used, n_text - used, ",");
        used += put_number(text + used, n_text - used, exp(size * (d[c] - mean) / fmax(largest, 1e-9)));
    }
}

/* A setting of `kind` for a perturbation spec. */
static void draw_perturbation(nqm_rng *rng, nqm_corpus_kind kind, char text[80]) {
    const strength *s = &strengths[kind];
    double size = s->faint * pow(s->strong / s->faint, nqm_rng_uniform(rng));
    double sign = nqm_rng_uniform(rng) < 0.5 ? -1 : 1;
    size_t used = (size_t)snprintf(text, 80, "%s=", s->key);
    if (kind == NQM_KIND_TINT) {
        put_tint(rng, size, text + used, 80 - used);
        return;
    }
    used += put_number(text + used, 80 - used,
                       s->form == FACTOR   ? exp(sign * size)
                       : s->form == SIGNED ? sign * size
                                           : size);
    if (kind == NQM_KIND_NOISE)
        snprintf(text + used, 80 - used, ";seed=%u;cells=%u", (unsigned)nqm_rng_below(rng, 1000000),
                 6 + (unsigned)nqm_rng_below(rng, 19));
}

/* Kinds that are one perturbation and that this part may hold. */
static size_t single_kinds(bool with_unseen, nqm_corpus_kind *kinds) {
    size_t n = 0;
    for (int k = NQM_KIND_GLOSS; k <= NQM_KIND_SHIFT; ++k)
        if (with_unseen || !nqm_corpus_kind_unseen((nqm_corpus_kind)k))
            kinds[n++] = (nqm_corpus_kind)k;
    return n;
}

/* Kinds for compositions and perturbed fits: smoothing reads its base 27 times a value and stays alone. */
static size_t quick_kinds(nqm_corpus_kind *kinds) {
    size_t n_single = single_kinds(false, kinds), n = 0;
    for (size_t k = 0; k < n_single; ++k)
        if (kinds[k] != NQM_KIND_SMOOTH)
            kinds[n++] = kinds[k];
    return n;
}

static nqm_corpus_test draw_test(nqm_rng *rng, size_t ref, nqm_corpus_kind kind) {
    nqm_corpus_test test = {.ref = ref, .kind = kind, .base = NQM_BASE_REF};
    nqm_corpus_kind quick[NQM_KIND_COUNT];
    size_t n_quick = quick_kinds(quick), first = (size_t)nqm_rng_below(rng, n_quick);
    if (kind == NQM_KIND_REFIT) {
        test.base = NQM_BASE_FIT;
        test.which = (size_t)nqm_rng_below(rng, NQM_CORPUS_N_FITS);
        draw_perturbation(rng, quick[first], test.perturbation[0]);
    } else if (kind == NQM_KIND_COMPOSED) {
        size_t second = (first + 1 + (size_t)nqm_rng_below(rng, n_quick - 1)) % n_quick;
        draw_perturbation(rng, quick[first], test.perturbation[0]);
        draw_perturbation(rng, quick[second], test.perturbation[1]);
    } else {
        draw_perturbation(rng, kind, test.perturbation[0]);
    }
    return test;
}

/* A round of kinds, each once; smoothing, the slowest by far, every other round; twice the two that mix all kinds. */
static size_t make_round(const nqm_corpus_options *options, size_t round, nqm_corpus_kind *kinds) {
    size_t n_single = single_kinds(options->part == NQM_CORPUS_TEST, kinds), n = 0;
    for (size_t k = 0; k < n_single; ++k)
        if (kinds[k] != NQM_KIND_SMOOTH || round % 2 == 0)
            kinds[n++] = kinds[k];
    for (int k = 0; k < 2; ++k) {
        kinds[n++] = NQM_KIND_COMPOSED;
        kinds[n++] = NQM_KIND_REFIT;
    }
    return n;
}

/* Perturbed copies that go through all kinds in turn, in a new order each round. */
static size_t draw_tests(nqm_rng *rng, size_t ref, const nqm_corpus_options *options, nqm_corpus_test *tests) {
    nqm_corpus_kind kinds[NQM_KIND_COUNT + 4];
    size_t order[NQM_KIND_COUNT + 4], n_round = 0, at = 0, round = 0;
    for (size_t i = 0; i < options->n_perturbations; ++i, ++at) {
        if (at == n_round) {
            n_round = make_round(options, round++, kinds);
            for (size_t k = 0; k < n_round; ++k)
                order[k] = k;
            nqm_rng_shuffle(rng, n_round, order);
            at = 0;
        }
        tests[i] = draw_test(rng, ref, kinds[order[at]]);
    }
    return options->n_perturbations;
}

/* ---- the plan ---------------------------------------------------------------------------------------------------- */

/* A stream of random numbers for each reference's name: other materials in the list change nothing. */
static uint64_t stream_of(const char *name) {
    uint64_t h = 0;
    for (; *name; ++name)
        h = nqm_hash_u64(h, (unsigned char)*name);
    return h;
}

static void plan_ref(const nqm_corpus_list *list, size_t ref, const nqm_corpus_options *options,
                     nqm_corpus_plan *plan) {
    nqm_rng rng = nqm_rng_make(options->seed, stream_of(list->refs[list->groups[plan->group].first_ref + ref].name));
    for (size_t k = 0; k < NQM_CORPUS_N_FITS; ++k)
        plan->tests[plan->n_tests++] =
            (nqm_corpus_test){.ref = ref, .kind = nqm_corpus_fits[k].kind, .base = NQM_BASE_FIT, .which = k};
    for (size_t f = 0; f < plan->n_forms; ++f)
        if (f != ref)
            plan->tests[plan->n_tests++] =
                (nqm_corpus_test){.ref = ref, .kind = plan->forms[f].kind, .base = NQM_BASE_FORM, .which = f};
    plan->n_tests += draw_tests(&rng, ref, options, plan->tests + plan->n_tests);
}

nqm_status nqm_corpus_plan_make(const nqm_corpus_list *list, size_t group, const nqm_corpus_options *options,
                                nqm_corpus_plan *plan_ret, nqm_error *err) {
    const nqm_corpus_group *g = &list->groups[group];
    nqm_corpus_plan plan = {.group = group, .n_refs = g->n_refs, .n_forms = g->n_refs};
    size_t n_forms_max = g->n_refs + NQM_CORPUS_MAX_PRESETS;
    size_t n_tests_max = g->n_refs * (NQM_CORPUS_N_FITS + n_forms_max + options->n_perturbations);
    *plan_ret = (nqm_corpus_plan){0};
    plan.forms = nqm_alloc(n_forms_max, sizeof *plan.forms);
    plan.tests = nqm_alloc(n_tests_max, sizeof *plan.tests);
    if (!plan.forms || !plan.tests) {
        nqm_corpus_plan_free(&plan);
        return nqm_fail_nomem(err, n_tests_max * sizeof *plan.tests);
    }
    for (size_t f = 0; f < g->n_refs; ++f) {
        const nqm_corpus_ref *ref = &list->refs[g->first_ref + f];
        plan.forms[f] = (nqm_corpus_form){ref->brdf, ref->path, kind_of_source(ref->source)};
    }
    add_presets(g->name, &plan);
    for (size_t ref = 0; ref < g->n_refs; ++ref)
        plan_ref(list, ref, options, &plan);
    *plan_ret = plan;
    return NQM_OK;
}

void nqm_corpus_plan_free(nqm_corpus_plan *plan) {
    nqm_free(plan->forms);
    nqm_free(plan->tests);
    *plan = (nqm_corpus_plan){0};
}
