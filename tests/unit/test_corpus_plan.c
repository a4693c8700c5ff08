/* SPDX-License-Identifier: MIT
 *
 * Lists and plans of corpora: invalid lists are refused; plans have no unseen kinds in training and depend only on the
 * seed and the names; tabulated forms.
 */
#include "brdf/brdf.h"
#include "corpus/corpus.h"
#include "support/check.h"
#include "support/corpus_files.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- lists ------------------------------------------------------------------------------------------------------- */

static size_t count_models(void) {
    size_t n = 0;
    while (nqm_fit_model(n))
        ++n;
    return n;
}

static void list_goes_by_group(void **state) {
    (void)state;
    nqm_corpus_list list;
    assert_int_equal(nqm_corpus_list_load(write_text("list.csv", corpus_materials), NULL, &list, NULL), NQM_OK);
    assert_int_equal(list.n_refs, 4);
    assert_int_equal(list.n_groups, 3);
    assert_string_equal(list.refs[0].name, "a-ggx");
    assert_string_equal(list.refs[1].name, "a-ward");
    assert_string_equal(list.refs[2].name, "b-ggx");
    assert_int_equal(list.groups[0].n_refs, 2);
    assert_int_equal(list.groups[1].first_ref, 2);
    assert_int_equal(list.groups[2].split, NQM_SPLIT_TEST);
    assert_true(nqm_corpus_in_part(&list.groups[0], NQM_CORPUS_TRAINING));
    assert_true(nqm_corpus_in_part(&list.groups[1], NQM_CORPUS_TRAINING));
    assert_false(nqm_corpus_in_part(&list.groups[2], NQM_CORPUS_TRAINING));
    nqm_corpus_list_free(&list);
}

static void paths_start_at_the_root(void **state) {
    (void)state;
    nqm_corpus_list list;
    write_text("one.bsdf", "content");
    const char *csv = write_text("list.csv", "name,group,brdf,source,split\n"
                                             "m,m,one.bsdf,rgl,train\n"
                                             "n,m,one.bsdf:inside,nbrdf,train\n");
    assert_int_equal(nqm_corpus_list_load(csv, NULL, &list, NULL), NQM_OK);
    assert_string_equal(list.refs[0].path, in_folder("one.bsdf"));
    /* sha256sum of the seven bytes "content" */
    static const char sha[] = "ed7002b439e9ac845f22357d822bac1444730fbdb6016d3ec9432297b9ec9f73";
    assert_string_equal(list.refs[0].file_sha256, sha);
    assert_string_equal(list.refs[1].file_sha256, sha);
    nqm_corpus_list_free(&list);
    assert_int_equal(nqm_corpus_list_load(csv, "/nowhere", &list, NULL), NQM_ERR_IO);
    assert_null(list.refs);
}

/* The hash of a reference covers the latents as well as the decoder. */
static void a_decoder_is_hashed_with_its_latents(void **state) {
    (void)state;
    enum { N_BYTES = 808003 * 4 };
    char csv[256], hex[2][65];
    FILE *f = fopen(in_folder("decoder.bin"), "wb");
    assert_non_null(f);
    assert_int_equal(fseek(f, N_BYTES - 1, SEEK_SET), 0);
    fputc(0, f);
    fclose(f);
    snprintf(csv, sizeof csv, "%s",
             write_text("list.csv", "name,group,brdf,source,split\nm,m,decoder.bin:m,nps,train\n"));
    for (int k = 0; k < 2; ++k) {
        nqm_corpus_list list;
        write_text("nps_latents.csv", k ? "material,mean0\nm,1\n" : "material,mean0\nm,0\n");
        assert_int_equal(nqm_corpus_list_load(csv, NULL, &list, NULL), NQM_OK);
        strcpy(hex[k], list.refs[0].file_sha256);
        nqm_corpus_list_free(&list);
    }
    assert_string_not_equal(hex[0], hex[1]);
    remove(in_folder("nps_latents.csv"));
    nqm_corpus_list list;
    assert_int_equal(nqm_corpus_list_load(csv, NULL, &list, NULL), NQM_ERR_IO);
}

static void bad_lists_are_refused(void **state) {
    (void)state;
    static const struct {
        const char *text, *message;
    } cases[] = {
        {"name,group,brdf,source,split\n", "no material"},
        {"name,group,brdf,split\na,a,sgd:nickel,train\n", "'source'"},
        {"name,group,brdf,source,split\na,a,sgd:nickel,sgd,train\na,b,sgd:brass,sgd,train\n", "not unique"},
        {"name,group,brdf,source,split\na,m,sgd:nickel,sgd,train\nb,m,ward:nickel,ward,test\n", "one split"},
        {"name,group,brdf,source,split\na,m,sgd:nickel,sgd,training\n", "'training'"},
        {"name,group,brdf,source,split\na,,sgd:nickel,sgd,train\n", "has no name"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        nqm_corpus_list list;
        nqm_error err = {0};
        assert_int_equal(nqm_corpus_list_load(write_text("bad.csv", cases[i].text), NULL, &list, &err), NQM_ERR_FORMAT);
        if (!strstr(err.message, cases[i].message) || !strstr(err.message, "bad.csv"))
            fail_msg("case %zu: %s", i, err.message);
    }
}

/* ---- plans ------------------------------------------------------------------------------------------------------- */

static void plan_of(nqm_corpus_part part, uint64_t seed, size_t group, nqm_corpus_plan *plan) {
    nqm_corpus_list list;
    nqm_corpus_options options = nqm_corpus_options_default();
    options.part = part;
    options.seed = seed;
    options.n_far = options.n_roundings = options.n_variants = 0;
    assert_int_equal(nqm_corpus_list_load(write_text("list.csv", corpus_materials), NULL, &list, NULL), NQM_OK);
    nqm_corpus_models models;
    assert_int_equal(nqm_corpus_models_parse(NULL, &models, NULL), NQM_OK);
    assert_int_equal(nqm_corpus_plan_make(&list, group, &models, &options, plan, NULL), NQM_OK);
    nqm_corpus_list_free(&list);
}

static void training_never_sees_the_unseen_kinds(void **state) {
    (void)state;
    for (uint64_t seed = 1; seed <= 20; ++seed) {
        nqm_corpus_plan plan;
        plan_of(NQM_CORPUS_TRAINING, seed, 0, &plan);
        for (size_t t = 0; t < plan.n_tests; ++t) {
            assert_false(nqm_corpus_kind_unseen(plan.tests[t].kind.name));
            for (int k = 0; k < 2; ++k) {
                assert_null(strstr(plan.tests[t].perturbation[k], "clamp"));
                assert_null(strstr(plan.tests[t].perturbation[k], "ripple"));
                assert_null(strstr(plan.tests[t].perturbation[k], "hue"));
            }
        }
        nqm_corpus_plan_free(&plan);
    }
}

static size_t count_kind(const nqm_corpus_plan *plan, const char *name, nqm_corpus_family family) {
    size_t n = 0;
    for (size_t t = 0; t < plan->n_tests; ++t)
        if (strcmp(plan->tests[t].kind.name, name) == 0) {
            assert_int_equal(plan->tests[t].kind.family, family);
            ++n;
        }
    return n;
}

static void every_kind_gets_its_turn(void **state) {
    (void)state;
    nqm_corpus_plan plan;
    plan_of(NQM_CORPUS_TEST, 1, 2, &plan);
    size_t n_presets = 0;
    for (size_t i = 0; i < nqm_brdf_preset_count(); ++i)
        n_presets += strcmp(strchr(nqm_brdf_preset_name(i), ':'), ":nickel") == 0;
    assert_true(n_presets >= 2);
    assert_int_equal(plan.n_forms, n_presets); /* including the reference */
    assert_int_equal(plan.n_tests, count_models() + n_presets - 1 + 26);
    for (size_t k = 0; nqm_fit_model(k); ++k)
        assert_int_equal(count_kind(&plan, nqm_fit_model(k), NQM_FAMILY_ENCODING), 1);
    assert_int_equal(count_kind(&plan, "published-ward", NQM_FAMILY_PUBLISHED), 1);
    assert_int_equal(count_kind(&plan, "published-sgd", NQM_FAMILY_PUBLISHED), 0);
    for (size_t i = 0; nqm_corpus_perturbation(i); ++i)
        assert_in_range(count_kind(&plan, nqm_corpus_perturbation(i), NQM_FAMILY_PERTURBATION), 1, 2);
    assert_in_range(count_kind(&plan, "composed", NQM_FAMILY_COMPOSED), 2, 4);
    assert_in_range(count_kind(&plan, "refit", NQM_FAMILY_COMPOSED), 2, 4);
    nqm_corpus_plan_free(&plan);

    plan_of(NQM_CORPUS_TRAINING, 1, 0, &plan);
    assert_true(count_kind(&plan, "quantise", NQM_FAMILY_PERTURBATION) >= 2);
    assert_true(count_kind(&plan, "shift", NQM_FAMILY_PERTURBATION) >= 2);
    assert_int_equal(count_kind(&plan, "form-ward", NQM_FAMILY_FORM), 1);
    nqm_corpus_plan_free(&plan);
}

/* Highlights that are slightly weakened, nearly removed and removed, all in one sequence of tests. */
static void models_are_chosen_by_name(void **state) {
    (void)state;
    nqm_corpus_models models;
    assert_int_equal(nqm_corpus_models_parse(NULL, &models, NULL), NQM_OK);
    assert_int_equal(models.n, count_models());
    assert_int_equal(nqm_corpus_models_parse("all", &models, NULL), NQM_OK);
    assert_int_equal(models.n, count_models());
    assert_int_equal(nqm_corpus_models_parse("ggx,all", &models, NULL), NQM_OK);
    assert_int_equal(models.n, count_models());
    assert_int_equal(nqm_corpus_models_parse("", &models, NULL), NQM_OK);
    assert_int_equal(models.n, 0);
    assert_int_equal(nqm_corpus_models_parse("ggx,ward", &models, NULL), NQM_OK);
    assert_int_equal(models.n, 2);
    assert_string_equal(models.name[0], "ward");
    assert_string_equal(models.name[1], "ggx");
    static const char *const bad[][2] = {{"gg", "no model 'gg'"},
                                         {"ward,ggxx", "no model 'ggxx' (did you mean 'ggx'?)"},
                                         {"all,wrad", "no model 'wrad' (did you mean 'ward'?)"},
                                         {"ggx,ward,ggx", "'ggx' is listed twice"},
                                         {",", "no model ''"},
                                         {"ggx ward", "no model 'ggx ward'"}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        nqm_error err = {0};
        assert_int_equal(nqm_corpus_models_parse(bad[i][0], &models, &err), NQM_ERR_ARG);
        assert_non_null(strstr(err.message, bad[i][1]));
    }
}

static void highlights_go_missing(void **state) {
    (void)state;
    enum { N = 2000 };
    static nqm_corpus_test tests[N];
    nqm_rng rng = nqm_rng_make(1, 0);
    nqm_corpus_draw_tests(&rng, 0, 9, NQM_CORPUS_TRAINING, N, tests);
    size_t n = 0, n_none = 0, n_little = 0;
    for (size_t t = 0; t < N; ++t) {
        if (strcmp(tests[t].kind.name, "peak") != 0)
            continue;
        double peak = atof(tests[t].perturbation[0] + strlen("peak="));
        ++n;
        n_none += peak == 0;
        n_little += peak > 0 && peak <= 0.1;
    }
    assert_in_range(n, 130, 145);
    assert_in_range(n_none, 10, 40);
    assert_in_range(n_little, 10, 40);
}

static void a_seed_is_a_plan(void **state) {
    (void)state;
    nqm_corpus_plan a, b, c;
    plan_of(NQM_CORPUS_TRAINING, 1, 0, &a);
    plan_of(NQM_CORPUS_TRAINING, 1, 0, &b);
    plan_of(NQM_CORPUS_TRAINING, 2, 0, &c);
    size_t n_different = 0;
    assert_int_equal(a.n_tests, b.n_tests);
    for (size_t t = 0; t < a.n_tests; ++t) {
        assert_string_equal(a.tests[t].perturbation[0], b.tests[t].perturbation[0]);
        assert_string_equal(a.tests[t].perturbation[1], b.tests[t].perturbation[1]);
        n_different += strcmp(a.tests[t].perturbation[0], c.tests[t].perturbation[0]) != 0;
    }
    assert_true(n_different > 40); /* out of 2 x 26 */
    nqm_corpus_plan_free(&a);
    nqm_corpus_plan_free(&b);
    nqm_corpus_plan_free(&c);
}

/* ---- forms ------------------------------------------------------------------------------------------------------- */

static void a_table_reads_like_its_source(void **state) {
    (void)state;
    nqm_brdf *source = open_brdf("ggx:kd=0.3,0.1,0;ks=1;alpha=0.1;f0=0.04"), *table;
    assert_int_equal(nqm_brdf_tabulate(source, nqm_table_general, NULL, &table, NULL), NQM_OK);
    nqm_rng rng = nqm_rng_make(7, 0);
    double sum = 0;
    size_t n = 0;
    while (n < 2000) {
        double u = nqm_rng_uniform(&rng), a[3], b[3], wi[3], wo[3];
        const double hd[3] = {1.3 * u * u, 1.3 * nqm_rng_uniform(&rng), 6.28 * nqm_rng_uniform(&rng) - 3.14};
        nqm_half_diff_to_directions(hd, wi, wo);
        if (fmin(wi[2], wo[2]) < cos(75 * acos(-1) / 180)) /* at larger angles f_r is too steep for the nodes */
            continue;
        nqm_brdf_eval_half_diff(source, 1, hd, a, NULL);
        nqm_brdf_eval_half_diff(table, 1, hd, b, NULL);
        assert_near(b[0], a[0], 0.08 * a[0] + 1e-4);
        sum += fabs(b[0] / a[0] - 1);
        ++n;
    }
    assert_true(sum / (double)n < 0.005);
    nqm_brdf_free(table);
    nqm_brdf_free(source);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(list_goes_by_group),
        cmocka_unit_test(paths_start_at_the_root),
        cmocka_unit_test(a_decoder_is_hashed_with_its_latents),
        cmocka_unit_test(bad_lists_are_refused),
        cmocka_unit_test(training_never_sees_the_unseen_kinds),
        cmocka_unit_test(every_kind_gets_its_turn),
        cmocka_unit_test(models_are_chosen_by_name),
        cmocka_unit_test(highlights_go_missing),
        cmocka_unit_test(a_seed_is_a_plan),
        cmocka_unit_test(a_table_reads_like_its_source),
    };
    return cmocka_run_group_tests_name("label: corpus plans", tests, make_folder, remove_made_folder);
}
