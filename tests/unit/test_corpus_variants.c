/* SPDX-License-Identifier: MIT
 *
 * Variants of references in corpora: changed specs differ in one key and open, draws are functions of seed and name, measured
 * references get no changed specs; plans that keep one test in four; labels of tables, translations and overfitted networks.
 */
#include "brdf/core/spec.h"
#include "corpus/corpus.h"
#include "data/data.h"
#include "fit/fit.h"
#include "math/math.h"
#include "support/check.h"
#include "support/corpus_files.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const specs[] = {"gltf:metallic=1;roughness=0;clearcoat=1",
                                    "open-pbr:coat_weight=1",
                                    "ggx:kd=.2;alpha=1e-4",
                                    "sgd:nickel",
                                    "rough-conductor:alpha=.01",
                                    "pbrt-conductor:roughness=.01;eta=.2;k=3",
                                    "principled:clearcoat=1",
                                    "blinn-phong:kd=.1;ks=.2;n=100",
                                    "disney:",
                                    "usd-preview:clearcoat=1",
                                    "rough-plastic:",
                                    "standard-surface:",
                                    "abc:nickel"};
enum { N_SPECS = sizeof specs / sizeof *specs };

/* Number of settings in which two canonical specs differ. */
static size_t count_changes(const char *before, const char *after) {
    size_t n = 0;
    for (const char *a = before, *b = after; *a && *b;) {
        const size_t n_a = strcspn(a, ";"), n_b = strcspn(b, ";");
        n += n_a != n_b || strncmp(a, b, n_a) != 0;
        a += n_a + (a[n_a] == ';');
        b += n_b + (b[n_b] == ';');
    }
    return n;
}

static void one_key_changes(void **state) {
    (void)state;
    nqm_rng rng = nqm_rng_make(1, 0);
    size_t n_mirrors = 0;
    for (size_t s = 0; s < N_SPECS; ++s)
        for (int i = 0; i < 40; ++i) {
            nqm_brdf *before, *after;
            char *spec;
            assert_int_equal(nqm_brdf_open(specs[s], &before, NULL), NQM_OK);
            const char *canonical = nqm_brdf_get_info(before).spec;
            assert_int_equal(nqm_corpus_change_spec(&rng, canonical, i % 2, &spec, NULL), NQM_OK);
            assert_non_null(spec);
            assert_int_equal(nqm_brdf_open(spec, &after, NULL), NQM_OK);
            if (count_changes(canonical, nqm_brdf_get_info(after).spec) != 1)
                fail_msg("%s\n%s", canonical, spec);
            n_mirrors += i % 2 && strstr(spec, "roughness=0;") != NULL && !strstr(canonical, "roughness=0;");
            nqm_free(spec);
            nqm_brdf_free(before);
            nqm_brdf_free(after);
        }
    assert_true(n_mirrors > 3);
    char *spec;
    assert_int_equal(nqm_corpus_change_spec(&rng, "lambert:kd=0.5", true, &spec, NULL), NQM_OK);
    assert_null(spec); /* it has no width */
    assert_int_equal(nqm_corpus_change_spec(&rng, "perturb:scale=2;of=sgd:nickel", false, &spec, NULL), NQM_OK);
    assert_null(spec);
}

/* The width of a mirror changes by a factor of 0.1 to 10, with another distribution of its square root. */
static void widths_are_those_of_alpha(void **state) {
    (void)state;
    static const struct {
        const char *spec, *key;
        double value, exponent;
    } cases[] = {{"ggx:alpha=0.01", "alpha=", 0.01, 1},
                 {"gltf:roughness=0.1", "roughness=", 0.1, 0.5},
                 {"blinn-phong:kd=0.1;ks=1;n=100", "n=", 100, -2},
                 {"pbrt-conductor:roughness=0.01;eta=.2;k=3", "roughness=", 0.01, 2}};
    for (size_t c = 0; c < sizeof cases / sizeof *cases; ++c) {
        nqm_rng rng = nqm_rng_make(2, c);
        double least = INFINITY, largest = 0;
        for (int i = 0; i < 100; ++i) {
            char *spec;
            assert_int_equal(nqm_corpus_change_spec(&rng, cases[c].spec, true, &spec, NULL), NQM_OK);
            const double value = atof(strstr(spec, cases[c].key) + strlen(cases[c].key));
            const double factor = pow(value / cases[c].value, 1 / cases[c].exponent);
            nqm_free(spec);
            if (value > 1e-4) /* otherwise a perfect mirror */
                least = fmin(least, factor);
            largest = fmax(largest, factor);
        }
        assert_in_range((int)(1000 * least), 99, 200);
        assert_in_range((int)(1000 * largest), 5000, 10010);
    }
}

static size_t draw(const char *path, uint64_t seed, nqm_corpus_test tests[16]) {
    nqm_rng rng = nqm_rng_make(seed, 0);
    size_t n;
    assert_int_equal(nqm_corpus_draw_variants(&rng, path, 16, &n, tests, NULL), NQM_OK);
    return n;
}

static void draws_depend_on_the_seed(void **state) {
    (void)state;
    nqm_corpus_test tests[3][16];
    size_t n_different = 0;
    assert_int_equal(draw(specs[0], 1, tests[0]), 15); /* one table */
    assert_int_equal(draw(specs[0], 1, tests[1]), 15);
    assert_int_equal(draw(specs[0], 2, tests[2]), 15);
    for (size_t t = 0; t < 15; ++t) {
        const nqm_corpus_test *a = &tests[0][t], *b = &tests[1][t], *c = &tests[2][t];
        assert_string_equal(a->kind.name, b->kind.name);
        assert_int_equal(a->base, b->base);
        assert_int_equal(a->kind.family, NQM_FAMILY_VARIANT);
        assert_true(a->path.seed == b->path.seed && a->path.n_steps == b->path.n_steps && a->which == b->which);
        if (a->spec) {
            assert_string_equal(a->spec, b->spec);
            n_different += strcmp(a->spec, c->spec) != 0;
        }
        if (a->base == NQM_BASE_OVERFIT)
            assert_in_range(a->path.n_steps, 50, 500);
        if (a->base == NQM_BASE_TRANSLATED)
            assert_string_not_equal(a->path.model, "gltf");
    }
    assert_true(n_different > 6);
    for (size_t k = 0; k < 3; ++k)
        for (size_t t = 0; t < 15; ++t)
            nqm_free(tests[k][t].spec);
}

static void files_have_no_changed_specs(void **state) {
    (void)state;
    nqm_corpus_test tests[16];
    const char *path = write_text("samples.csv", "theta_h,theta_d,phi_d,r,g,b\n0,0,0,1,1,1\n10,20,30,1,1,1\n");
    assert_int_equal(draw(path, 1, tests), 5);
    for (size_t t = 0; t < 5; ++t)
        assert_null(tests[t].spec);
}

/* ---- plans and labels -------------------------------------------------------------------------------------------- */

static void plan(const nqm_corpus_options *options, nqm_corpus_plan *plan_ret) {
    nqm_corpus_list list;
    nqm_corpus_models models;
    assert_int_equal(nqm_corpus_list_load(write_text("list.csv", corpus_materials), NULL, &list, NULL), NQM_OK);
    assert_int_equal(nqm_corpus_models_parse(options->models, &models, NULL), NQM_OK);
    assert_int_equal(nqm_corpus_plan_make(&list, 0, &models, options, plan_ret, NULL), NQM_OK);
    nqm_corpus_list_free(&list);
}

static void one_test_in_four_is_kept(void **state) {
    (void)state;
    nqm_corpus_plan all, few;
    nqm_corpus_options options = nqm_corpus_options_default();
    options.n_perturbations = 200;
    options.n_far = 21;
    plan(&options, &all);
    options.every = 4;
    plan(&options, &few);
    size_t n[2][NQM_FAMILY_COUNT] = {{0}}, at = 0;
    for (size_t t = 0; t < all.n_tests; ++t)
        ++n[0][all.tests[t].kind.family];
    for (size_t t = 0; t < few.n_tests; ++t) {
        const nqm_corpus_test *test = &few.tests[t];
        ++n[1][test->kind.family];
        if (test->kind.family == NQM_FAMILY_FAR)
            continue;
        while (at < all.n_tests && (strcmp(all.tests[at].kind.name, test->kind.name) != 0 ||
                                    strcmp(all.tests[at].perturbation[0], test->perturbation[0]) != 0))
            ++at;
        assert_true(at < all.n_tests); /* in the same order */
    }
    assert_int_equal(n[0][NQM_FAMILY_FAR], 2 * (21 + 11));
    assert_int_equal(n[1][NQM_FAMILY_FAR], 2 * (6 + 3));
    assert_in_range(n[1][NQM_FAMILY_PERTURBATION], n[0][NQM_FAMILY_PERTURBATION] / 6,
                    n[0][NQM_FAMILY_PERTURBATION] / 3);
    assert_in_range(n[1][NQM_FAMILY_ENCODING], 4, 22);
    nqm_corpus_plan_free(&all);
    nqm_corpus_plan_free(&few);
}

/* The labels of a smooth material: its table and its translation are near. */
static void variants_have_labels(void **state) {
    (void)state;
    nqm_corpus_options options = nqm_corpus_options_default();
    nqm_directions_options some = nqm_directions_options_default();
    nqm_directions *directions;
    nqm_dataset *d = NULL;
    nqm_error err = {0};
    char csv[256];
    options.n_perturbations = options.n_far = options.n_roundings = 0;
    options.n_variants = 8;
    options.models = "ward";
    options.every = 1;
    options.scene.n_points = 64;
    some.n = 60;
    snprintf(csv, sizeof csv, "%s",
             write_text("one.csv", "name,group,brdf,source,split\n"
                                   "c,c,\"gltf:base_color=.5,.3,.1;metallic=0;roughness=.5\",renderer,train\n"));
    assert_int_equal(nqm_directions_create(&some, 0, NULL, &directions, NULL), NQM_OK);
    if (nqm_corpus_build(csv, directions, &options, in_folder("variants.safetensors"), &err) != NQM_OK ||
        nqm_dataset_load(in_folder("variants.safetensors"), &d, &err) != NQM_OK)
        fail_msg("%s", err.message);
    assert_int_equal(d->n_pairs, 9);
    for (size_t i = 0; i < d->n_pairs; ++i) {
        const char *kind = nqm_name(&d->kind_names, d->pair_kind[i]), *name = nqm_name(&d->pair_names, i);
        print_message("%-12s %6.2f %s\n", kind, d->jod[i], name);
        if (strcmp(kind, "folded") == 0) {
            assert_true(d->jod[i] > 9.5);
            assert_non_null(strstr(name, "table of gltf:"));
        }
        if (strcmp(kind, "translated") == 0)
            assert_true(d->jod[i] > 8);
        if (strcmp(kind, "overfit") == 0) {
            assert_true(d->delta_e[i] > 0);
            assert_non_null(strstr(name, " directions of gltf:"));
        }
    }
    nqm_dataset_free(d);
    nqm_directions_free(directions);
}

/* A network that is fitted to few directions has their values, and others elsewhere. */
static void few_directions_are_overfitted(void **state) {
    (void)state;
    enum { N = 60 };
    nqm_brdf *ref, *fit, *again;
    double hd[3 * N], rgb[2][3 * N], error = 0, other = 0;
    nqm_rng rng = nqm_rng_make(5, 0);
    assert_int_equal(nqm_brdf_open("ggx:kd=.3,.1,.05;ks=1;alpha=.2", &ref, NULL), NQM_OK);
    for (size_t i = 0; i < N; ++i)
        nqm_encode_draw_dense(&rng, 1.4, NQM_PI / 2, NQM_PI, hd + 3 * i);
    assert_int_equal(nqm_encode_nbrdf_at(ref, N, hd, 1, &fit, NULL), NQM_OK);
    for (int fresh = 0; fresh < 2; ++fresh) {
        nqm_brdf_eval_half_diff(ref, N, hd, rgb[0], NULL);
        nqm_brdf_eval_half_diff(fit, N, hd, rgb[1], NULL);
        for (size_t i = 0; i < 3 * N; ++i)
            *(fresh ? &other : &error) += fabs(log1p(rgb[1][i]) - log1p(rgb[0][i])) / (3 * N);
        if (fresh == 0)
            assert_int_equal(nqm_encode_nbrdf_at(ref, N, hd, 1, &again, NULL), NQM_OK);
        for (size_t i = 0; i < N; ++i)
            nqm_encode_draw_dense(&rng, 1.4, NQM_PI / 2, NQM_PI, hd + 3 * i);
    }
    print_message("error %g, elsewhere %g\n", error, other);
    assert_true(other > 3 * error);
    assert_memory_equal(nqm_nbrdf_weights(fit), nqm_nbrdf_weights(again), NQM_NBRDF_WEIGHTS * sizeof(float));
    nqm_brdf_free(ref);
    nqm_brdf_free(fit);
    nqm_brdf_free(again);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_key_changes),          cmocka_unit_test(widths_are_those_of_alpha),
        cmocka_unit_test(draws_depend_on_the_seed), cmocka_unit_test(files_have_no_changed_specs),
        cmocka_unit_test(one_test_in_four_is_kept), cmocka_unit_test(few_directions_are_overfitted),
        cmocka_unit_test(variants_have_labels),
    };
    return cmocka_run_group_tests_name("label: variants of references", tests, make_folder, remove_made_folder);
}
