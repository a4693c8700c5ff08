/* SPDX-License-Identifier: MIT
 *
 * Far tests of corpora: numbers of tests, kinds of the test part, other materials of the same split, independence of the rest of
 * the list, random parameters, selection by label.
 */
#include "brdf/core/spec.h"
#include "corpus/corpus.h"
#include "fit/fit.h"
#include "math/math.h"
#include "support/check.h"
#include "support/corpus_files.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A list of n_groups materials of two sources each; every fourth is a validation material, every fifth a test material. */
static void make_list(size_t n_groups, nqm_corpus_list *list) {
    char *text = calloc(n_groups + 1, 200);
    assert_non_null(text);
    size_t used = (size_t)sprintf(text, "name,group,brdf,source,split\n");
    for (size_t g = 0; g < n_groups; ++g) {
        const char *split = g % 5 == 4 ? "test" : g % 4 == 3 ? "validation" : "train";
        used += (size_t)sprintf(text + used, "ward-m%zu,m%zu,ward:ks=.1;alpha=.%zu1,ward,%s\n", g, g, g, split);
        used += (size_t)sprintf(text + used, "ggx-m%zu,m%zu,ggx:alpha=.%zu1,ggx,%s\n", g, g, g, split);
    }
    nqm_error err = {0};
    if (nqm_corpus_list_load(write_text("list.csv", text), NULL, list, &err) != NQM_OK)
        fail_msg("%s", err.message);
    free(text);
}

static size_t find_ref(const nqm_corpus_list *list, const char *name) {
    size_t i = 0;
    while (i < list->n_refs && strcmp(list->refs[i].name, name) != 0)
        ++i;
    assert_true(i < list->n_refs);
    return i;
}

enum { N = 200 };

static void draw(const nqm_corpus_list *list, const char *name, uint64_t seed, nqm_corpus_part part,
                 nqm_corpus_test tests[N]) {
    assert_int_equal(nqm_corpus_draw_far(list, find_ref(list, name), seed, part, N, tests, NULL), NQM_OK);
}

static void drop(nqm_corpus_test tests[N]) {
    for (size_t t = 0; t < N; ++t)
        nqm_free(tests[t].spec);
}

static void others_are_of_the_same_split(void **state) {
    (void)state;
    nqm_corpus_list list;
    nqm_corpus_test tests[N];
    make_list(40, &list);
    for (size_t r = 0; r < list.n_refs; ++r) {
        const nqm_corpus_ref *ref = &list.refs[r];
        nqm_split split = list.groups[ref->group].split;
        size_t n_same = 0, n_source = 0;
        draw(&list, ref->name, 1, split == NQM_SPLIT_TEST ? NQM_CORPUS_TEST : NQM_CORPUS_TRAINING, tests);
        for (size_t t = 0; t < N; ++t) {
            if (!nqm_corpus_uses_other(&tests[t]))
                continue;
            const nqm_corpus_ref *other = &list.refs[tests[t].which];
            assert_int_not_equal(other->group, ref->group);
            assert_int_equal(list.groups[other->group].split, split);
            bool is_same_source = strcmp(other->source, ref->source) == 0;
            bool is_same = strcmp(tests[t].kind.name, "other-same") == 0;
            bool is_source = strcmp(tests[t].kind.name, "other-source") == 0;
            assert_false(is_same && !is_same_source);
            assert_false(is_source && is_same_source);
            n_same += is_same;
            n_source += is_source;
            for (size_t u = 0; u < t && (is_same || is_source); ++u) /* no material twice */
                assert_false(strcmp(tests[u].kind.name, tests[t].kind.name) == 0 && tests[u].which == tests[t].which);
        }
        assert_true(n_same > 5 && n_source > 5);
        drop(tests);
    }
    nqm_corpus_list_free(&list);
}

static void unseen_kinds_are_in_the_test_part_only(void **state) {
    (void)state;
    nqm_corpus_list list;
    nqm_corpus_test tests[N];
    make_list(40, &list);
    for (int part = 0; part < 2; ++part) {
        size_t n_unseen = 0, n_kinds = 0;
        draw(&list, "ward-m0", 3, (nqm_corpus_part)part, tests);
        for (size_t k = 0; nqm_corpus_far_kind(k); ++k, ++n_kinds) {
            size_t n = 0;
            for (size_t t = 0; t < N; ++t)
                n += strcmp(tests[t].kind.name, nqm_corpus_far_kind(k)) == 0;
            bool unseen = nqm_corpus_far_unseen(nqm_corpus_far_kind(k));
            assert_int_equal(nqm_corpus_kind_unseen(nqm_corpus_far_kind(k)), unseen);
            if (unseen && part == NQM_CORPUS_TRAINING)
                assert_int_equal(n, 0);
            else
                assert_true(n >= 3); /* in three rounds and more */
            n_unseen += unseen;
        }
        assert_int_equal(n_unseen, 4); /* between-log, white, two random models */
        for (size_t t = 0; t < N; ++t) {
            assert_int_equal(tests[t].kind.family, NQM_FAMILY_FAR);
            assert_false(part == NQM_CORPUS_TRAINING && strstr(tests[t].between, "log"));
        }
        drop(tests);
    }
    nqm_corpus_list_free(&list);
}

/* The parameters of a kind are in its range, and come near both of its ends. */
static void parameters_fill_their_ranges(void **state) {
    (void)state;
    static const struct {
        const char *kind, *format;
        double low, high; /* of the magnitude of the logarithm to base 10 */
    } cases[] = {{"scaled", "scale=%lf", 0.5, 3},
                 {"white", "lambert:kd=%lf", 0, -log10(0.7)},
                 {"black", "lambert:kd=%lf", -log10(0.005), 4},
                 {"mirror", "ggx:ks=1;alpha=%lf", -log10(0.05), 3}};
    enum { N_CASES = sizeof cases / sizeof *cases };
    nqm_corpus_list list;
    nqm_corpus_test tests[N];
    double least[N_CASES], most[N_CASES];
    size_t n_dark = 0, n_bright = 0;
    for (size_t k = 0; k < N_CASES; ++k)
        least[k] = INFINITY, most[k] = 0;
    make_list(40, &list);
    for (uint64_t seed = 0; seed < 10; ++seed) {
        draw(&list, "ward-m4", seed, NQM_CORPUS_TEST, tests);
        for (size_t i = 0; i < N * N_CASES; ++i) {
            const nqm_corpus_test *t = &tests[i / N_CASES];
            const size_t k = i % N_CASES;
            double v;
            if (strcmp(t->kind.name, cases[k].kind) != 0)
                continue;
            assert_int_equal(sscanf(t->spec ? t->spec : t->perturbation[0], cases[k].format, &v), 1);
            n_dark += k == 0 && v < 1;
            n_bright += k == 0 && v > 1;
            if (v > 0) /* entirely black */
                least[k] = fmin(least[k], fabs(log10(v))), most[k] = fmax(most[k], fabs(log10(v)));
        }
        drop(tests);
    }
    for (size_t k = 0; k < N_CASES; ++k) {
        const double part = 0.2 * (cases[k].high - cases[k].low), rounding = 1e-3;
        if (!(least[k] >= cases[k].low - rounding && least[k] < cases[k].low + part &&
              most[k] <= cases[k].high + rounding && most[k] > cases[k].high - part))
            fail_msg("%s: %g to %g", cases[k].kind, least[k], most[k]);
    }
    assert_true(n_dark > 10 && n_bright > 10);
    nqm_corpus_list_free(&list);
}

#define NAME_OF(MODEL) (MODEL).schema.model,

static void every_model_has_its_kinds(void **state) {
    (void)state;
    static char name[80];
    const char *const analytic[] = {NQM_ANALYTIC_MODELS(NAME_OF) NULL};
    for (size_t m = 0; analytic[m]; ++m) {
        size_t k = 0;
        snprintf(name, sizeof name, "random-%s", analytic[m]);
        while (nqm_corpus_far_kind(k) && strcmp(nqm_corpus_far_kind(k), name) != 0)
            ++k;
        assert_non_null(nqm_corpus_far_kind(k));
    }
    for (size_t m = 0; nqm_fit_model(m); ++m) {
        const nqm_fit_entry *entry;
        size_t k = 0;
        assert_int_equal(nqm_fit_entry_find(nqm_fit_model(m), &entry, NULL), NQM_OK);
        snprintf(name, sizeof name, "path-%s", nqm_fit_model(m));
        while (!entry->encode && nqm_corpus_far_kind(k) && strcmp(nqm_corpus_far_kind(k), name) != 0)
            ++k;
        assert_true(entry->encode || nqm_corpus_far_kind(k));
    }
}

static bool same_test(const nqm_corpus_list *a_list, const nqm_corpus_test *a, const nqm_corpus_list *b_list,
                      const nqm_corpus_test *b) {
    return strcmp(a->kind.name, b->kind.name) == 0 && strcmp(a->between, b->between) == 0 &&
           strcmp(a->perturbation[0], b->perturbation[0]) == 0 && !a->spec == !b->spec &&
           (!a->spec || strcmp(a->spec, b->spec) == 0) && a->path.seed == b->path.seed &&
           a->path.n_steps == b->path.n_steps && a->path.loss == b->path.loss &&
           (!nqm_corpus_uses_other(a) || strcmp(a_list->refs[a->which].name, b_list->refs[b->which].name) == 0);
}

/* Further materials change only which other materials are used, and few of them. */
static void tests_hardly_depend_on_the_list(void **state) {
    (void)state;
    enum { N_FIRST = 52 };
    nqm_corpus_list small, large;
    nqm_corpus_test a[N], b[N];
    size_t n_changed = 0, n_others = 0;
    make_list(100, &small);
    make_list(105, &large);
    for (size_t g = 0; g < 20; ++g) {
        char name[32];
        snprintf(name, sizeof name, "ward-m%zu", g);
        draw(&small, name, 1, NQM_CORPUS_TRAINING, a);
        draw(&large, name, 1, NQM_CORPUS_TRAINING, b);
        for (size_t t = 0; t < N_FIRST; ++t) {
            bool uses_other = nqm_corpus_uses_other(&a[t]);
            n_others += uses_other;
            if (!same_test(&small, &a[t], &large, &b[t])) {
                assert_true(uses_other);
                ++n_changed;
            }
        }
        drop(a);
        draw(&small, name, 2, NQM_CORPUS_TRAINING, a);
        assert_false(same_test(&small, &a[0], &large, &b[0]) && same_test(&small, &a[1], &large, &b[1]) &&
                     same_test(&small, &a[2], &large, &b[2]));
        drop(a);
        drop(b);
    }
    assert_true(n_changed < n_others / 2);
    nqm_corpus_list_free(&small);
    nqm_corpus_list_free(&large);
}

/* Without other materials the other kinds take their turns. */
static void a_single_material_has_far_tests(void **state) {
    (void)state;
    nqm_corpus_list list;
    nqm_corpus_test tests[N];
    make_list(1, &list);
    draw(&list, "ward-m0", 1, NQM_CORPUS_TRAINING, tests);
    for (size_t t = 0; t < N; ++t)
        assert_false(nqm_corpus_uses_other(&tests[t]));
    drop(tests);
    nqm_corpus_list_free(&list);
}

static void plans_hold_candidates(void **state) {
    (void)state;
    nqm_corpus_list list;
    nqm_corpus_plan plan;
    nqm_corpus_models models;
    nqm_corpus_options options = nqm_corpus_options_default();
    make_list(20, &list);
    options.n_far = 10;
    options.n_roundings = 4;
    options.n_perturbations = 5;
    assert_int_equal(nqm_corpus_models_parse("ward", &models, NULL), NQM_OK);
    assert_int_equal(nqm_corpus_plan_make(&list, 0, &models, &options, &plan, NULL), NQM_OK);
    size_t n_family[NQM_FAMILY_COUNT] = {0};
    for (size_t t = 0; t < plan.n_tests; ++t)
        ++n_family[plan.tests[t].kind.family];
    assert_int_equal(plan.n_refs, 2);
    assert_int_equal(n_family[NQM_FAMILY_ENCODING], 2);
    assert_int_equal(n_family[NQM_FAMILY_FORM], 2);
    assert_int_equal(n_family[NQM_FAMILY_FAR], 2 * 15);
    assert_int_equal(n_family[NQM_FAMILY_ROUNDING], 2 * 4);
    assert_int_equal(n_family[NQM_FAMILY_PERTURBATION] + n_family[NQM_FAMILY_COMPOSED], 2 * 5);
    nqm_corpus_plan_free(&plan);
    nqm_corpus_list_free(&list);
}

/* ---- random parameters ------------------------------------------------------------------------------------------- */

/* Specs open, reflect neither nothing nor more than twice the light, and differ. */
static void random_parameters_are_plausible(void **state) {
    (void)state;
    const char *const models[] = {NQM_ANALYTIC_MODELS(NAME_OF) NULL};
    nqm_rng rng = nqm_rng_make(5, 0);
    for (size_t m = 0; models[m]; ++m) {
        char *last = NULL;
        for (int i = 0; i < 40; ++i) {
            char *spec;
            double rgb[3];
            assert_int_equal(nqm_corpus_random_spec(&rng, models[m], &spec, NULL), NQM_OK);
            assert_true(strncmp(spec, models[m], strlen(models[m])) == 0);
            assert_false(last && strcmp(last, spec) == 0);
            nqm_brdf *brdf = open_brdf(spec);
            nqm_brdf_albedo(brdf, NQM_PI / 4, 1, rgb);
            if (!(rgb[1] > 1e-4 && rgb[1] < 2))
                fail_msg("%s: albedo %g", spec, rgb[1]);
            nqm_brdf_free(brdf);
            nqm_free(last);
            last = spec;
        }
        nqm_free(last);
    }
}

/* ---- selection --------------------------------------------------------------------------------------------------- */

static void selections_are_spread(void **state) {
    (void)state;
    enum { N_JOD = 60, N_KEPT = 20 };
    double jod[N_JOD];
    uint8_t kept[N_JOD], again[N_JOD];
    nqm_rng rng = nqm_rng_make(1, 0);
    for (size_t i = 0; i < N_JOD; ++i) /* most are near 0 */
        jod[i] = 10 * pow(nqm_rng_uniform(&rng), 3);
    jod[7] = NAN;
    assert_int_equal(nqm_corpus_spread(N_JOD, jod, N_KEPT, kept, NULL), NQM_OK);
    assert_int_equal(nqm_corpus_spread(N_JOD, jod, N_KEPT, again, NULL), NQM_OK);
    assert_memory_equal(kept, again, sizeof kept);
    assert_int_equal(kept[7], 0);
    size_t n = 0, n_low = 0, n_low_kept = 0, n_high = 0, n_high_kept = 0;
    for (size_t i = 0; i < N_JOD; ++i) {
        n += kept[i];
        n_low += jod[i] < 1;
        n_low_kept += jod[i] < 1 && kept[i];
        n_high += jod[i] > 3;
        n_high_kept += jod[i] > 3 && kept[i];
    }
    assert_int_equal(n, N_KEPT);
    assert_true(n_low > 20 && n_low_kept < 6);
    assert_true(n_high_kept >= nqm_smaller(n_high, 10));
}

static void small_selections(void **state) {
    (void)state;
    const double jod[] = {1, 1, 1, NAN, 9};
    uint8_t kept[5];
    assert_int_equal(nqm_corpus_spread(5, jod, 10, kept, NULL), NQM_OK);
    assert_memory_equal(kept, ((const uint8_t[]){1, 1, 1, 0, 1}), 5);
    assert_int_equal(nqm_corpus_spread(5, jod, 2, kept, NULL), NQM_OK);
    assert_int_equal(kept[0] + kept[1] + kept[2], 1);
    assert_int_equal(kept[4], 1);
    assert_int_equal(nqm_corpus_spread(5, jod, 0, kept, NULL), NQM_OK);
    assert_memory_equal(kept, ((const uint8_t[]){0, 0, 0, 0, 0}), 5);
    assert_int_equal(nqm_corpus_spread(0, NULL, 3, NULL, NULL), NQM_OK);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(others_are_of_the_same_split),    cmocka_unit_test(unseen_kinds_are_in_the_test_part_only),
        cmocka_unit_test(parameters_fill_their_ranges),    cmocka_unit_test(every_model_has_its_kinds),
        cmocka_unit_test(tests_hardly_depend_on_the_list), cmocka_unit_test(a_single_material_has_far_tests),
        cmocka_unit_test(plans_hold_candidates),           cmocka_unit_test(random_parameters_are_plausible),
        cmocka_unit_test(selections_are_spread),           cmocka_unit_test(small_selections),
    };
    return cmocka_run_group_tests_name("label: far tests", tests, make_folder, remove_made_folder);
}
