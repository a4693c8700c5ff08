/* SPDX-License-Identifier: MIT
 *
 * Corpora: lists that must be refused; plans that keep unseen kinds out of training and depend on the seed and the
 * names only; forms as they are read; and a small corpus of analytic materials, made, interrupted, resumed and read
 * back.
 */
#include "brdf/brdf.h"
#include "label/corpus.h"
#include "support/check.h"
#include "train/train.h"

#include <dirent.h>
#include <jansson.h>
#include <math.h>
#include <omp.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

static char folder[] = "/tmp/nqm-test-XXXXXX";

static const char *in_folder(const char *name) {
    static char path[2][256];
    static int which;
    which = !which;
    snprintf(path[which], sizeof path[which], "%s/%s", folder, name);
    return path[which];
}

static const char *write_text(const char *name, const char *text) {
    const char *path = in_folder(name);
    FILE *f = fopen(path, "w");
    assert_non_null(f);
    fputs(text, f);
    fclose(f);
    return path;
}

static const char materials[] = "name,group,brdf,source,split\n"
                                "a-ggx,a,ggx:kd=0.2;alpha=0.2,ggx,train\n"
                                "b-ggx,b,ggx:kd=0.1;alpha=0.4,ggx,validation\n"
                                "a-ward,a,ward:kd=0.2;ks=0.04;alpha=0.2,ward,train\n"
                                "nickel-sgd,nickel,sgd:nickel,sgd,test\n";

/* ---- lists ------------------------------------------------------------------------------------------------------- */

static void list_goes_by_group(void **state) {
    (void)state;
    nqm_corpus_list list;
    assert_int_equal(nqm_corpus_list_load(write_text("list.csv", materials), NULL, &list, NULL), NQM_OK);
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

/* Other latents beside the same decoder are other references. */
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
        {"name,group,brdf,source,split\na,a,sgd:nickel,sgd,train\na,b,sgd:brass,sgd,train\n", "twice"},
        {"name,group,brdf,source,split\na,m,sgd:nickel,sgd,train\nb,m,ward:nickel,ward,test\n", "one split"},
        {"name,group,brdf,source,split\na,m,sgd:nickel,sgd,training\n", "'training'"},
        {"name,group,brdf,source,split\na,,sgd:nickel,sgd,train\n", "lacks"},
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
    assert_int_equal(nqm_corpus_list_load(write_text("list.csv", materials), NULL, &list, NULL), NQM_OK);
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
    assert_int_equal(plan.n_forms, n_presets); /* the reference is one of them */
    assert_int_equal(plan.n_tests, nqm_fit_model_count() + n_presets - 1 + 26);
    for (size_t k = 0; k < nqm_fit_model_count(); ++k)
        assert_int_equal(count_kind(&plan, nqm_fit_model_name(k), NQM_FAMILY_ENCODING), 1);
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

/* Highlights that are weakened a little, nearly gone and gone, all in one stream of tests. */
static void models_are_chosen_by_name(void **state) {
    (void)state;
    nqm_corpus_models models;
    assert_int_equal(nqm_corpus_models_parse(NULL, &models, NULL), NQM_OK);
    assert_int_equal(models.n, nqm_fit_model_count());
    assert_int_equal(nqm_corpus_models_parse("", &models, NULL), NQM_OK);
    assert_int_equal(models.n, 0);
    assert_int_equal(nqm_corpus_models_parse("ggx,ward", &models, NULL), NQM_OK);
    assert_int_equal(models.n, 2);
    assert_string_equal(models.name[0], "ward");
    assert_string_equal(models.name[1], "ggx");
    static const char *const bad[] = {"gg", "ggxx", "ggx,ggx", ",", "ggx ward"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        nqm_error err = {0};
        assert_int_equal(nqm_corpus_models_parse(bad[i], &models, &err), NQM_ERR_ARG);
        assert_non_null(strstr(err.message, bad[i]));
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
    assert_true(n_different > 40); /* of 2 x 26 */
    nqm_corpus_plan_free(&a);
    nqm_corpus_plan_free(&b);
    nqm_corpus_plan_free(&c);
}

/* ---- forms ------------------------------------------------------------------------------------------------------- */

static void a_table_reads_like_its_source(void **state) {
    (void)state;
    nqm_brdf *source = open_brdf("ggx:kd=0.3,0.1,0;ks=1;alpha=0.1;f0=0.04"), *table;
    assert_int_equal(nqm_corpus_tabulate(source, &table, NULL), NQM_OK);
    nqm_rng rng = nqm_rng_make(7, 0);
    double sum = 0;
    size_t n = 0;
    while (n < 2000) {
        double u = nqm_rng_uniform(&rng), a[3], b[3], wi[3], wo[3];
        const double hd[3] = {1.3 * u * u, 1.3 * nqm_rng_uniform(&rng), 6.28 * nqm_rng_uniform(&rng) - 3.14};
        nqm_half_diff_to_directions(hd, wi, wo);
        if (fmin(wi[2], wo[2]) < cos(75 * acos(-1) / 180)) /* beyond, f_r rises too steeply for the nodes */
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

/* f_r = z of the light: not reciprocal. */
static void lopsided_eval(const void *self, size_t n, const double *wi, const double *wo, double *rgb) {
    (void)self;
    (void)wo;
    for (size_t i = 0; i < 3 * n; ++i)
        rgb[i] = wi[3 * (i / 3) + 2];
}

static void folding_makes_reciprocal(void **state) {
    (void)state;
    static const nqm_brdf_class lopsided = {.format = "lopsided", .eval = lopsided_eval, .free = free_nothing};
    nqm_brdf *brdf, *folded;
    assert_int_equal(nqm_brdf_wrap(&lopsided, NULL, "lopsided", NULL, NULL, &brdf, NULL), NQM_OK);
    assert_int_equal(nqm_corpus_fold(brdf, true, &folded, NULL), NQM_OK);
    nqm_rng rng = nqm_rng_make(3, 0);
    for (int i = 0; i < 200; ++i) {
        const double hd[3] = {0.7 * nqm_rng_uniform(&rng), 0.7 * nqm_rng_uniform(&rng), 3.1 * nqm_rng_uniform(&rng)};
        double wi[3], wo[3], forth[3], back[3];
        nqm_half_diff_to_directions(hd, wi, wo);
        nqm_brdf_eval(folded, 1, wi, wo, forth, NULL);
        nqm_brdf_eval(folded, 1, wo, wi, back, NULL);
        assert_near(forth[0], wi[2], 1e-9); /* phi_d in [0, pi): the half that is read */
        assert_near(back[0], forth[0], 1e-9);
    }
    nqm_brdf_free(folded);
}

/* ---- a corpus ---------------------------------------------------------------------------------------------------- */

static nqm_directions *directions(void) {
    nqm_directions *made;
    nqm_directions_options options = nqm_directions_options_default();
    options.n = 50;
    assert_int_equal(nqm_directions_create(&options, 0, NULL, &made, NULL), NQM_OK);
    return made;
}

static nqm_corpus_options small_corpus(nqm_corpus_part part) {
    nqm_corpus_options options = nqm_corpus_options_default();
    options.part = part;
    options.n_perturbations = 3;
    options.models = "ward,ggx";
    options.scene.n_points = 256;
    return options;
}

static nqm_dataset *build(const nqm_corpus_options *options, const char *name) {
    nqm_error err = {0};
    nqm_dataset *dataset;
    nqm_directions *d = directions();
    char csv[256];
    snprintf(csv, sizeof csv, "%s", write_text("list.csv", materials));
    if (nqm_corpus_build(csv, d, options, in_folder(name), &err) != NQM_OK ||
        nqm_dataset_load(in_folder(name), &dataset, &err) != NQM_OK)
        fail_msg("%s", err.message);
    nqm_directions_free(d);
    return dataset;
}

/* The training part, made once. */
static nqm_dataset *training_part(void) {
    nqm_corpus_options options = small_corpus(NQM_CORPUS_TRAINING);
    nqm_dataset *dataset;
    if (access(in_folder("training.safetensors"), F_OK) != 0)
        return build(&options, "training.safetensors");
    assert_int_equal(nqm_dataset_load(in_folder("training.safetensors"), &dataset, NULL), NQM_OK);
    return dataset;
}

static void parts_hold_their_splits(void **state) {
    (void)state;
    nqm_dataset *training = training_part();
    nqm_dataset_info info = nqm_dataset_get_info(training);
    assert_int_equal(info.n_groups, 2);
    assert_int_equal(info.n_refs, 3);
    assert_int_equal(info.n_pairs, 3 * (2 + 3) + 2); /* and each of the two forms of a as a test of the other */
    assert_int_equal(info.n_pairs_in[NQM_SPLIT_TEST], 0);
    assert_int_equal(info.n_pairs_in[NQM_SPLIT_VALIDATION], 2 + 3);
    assert_non_null(strstr(info.manifest, "\"unseen_kinds\""));
    assert_null(strstr(info.manifest, "nickel"));
    for (size_t i = 0; i < info.n_pairs; ++i) {
        assert_null(strstr(training->pair_names[i], "nickel"));
        nqm_curve curve = nqm_curve_default();
        assert_near(training->jod[i], nqm_curve_jod(&curve, training->delta_e[i]), 0);
    }
    nqm_dataset_free(training);

    nqm_corpus_options options = small_corpus(NQM_CORPUS_TEST);
    nqm_dataset *test = build(&options, "test.safetensors");
    info = nqm_dataset_get_info(test);
    assert_int_equal(info.n_pairs_in[NQM_SPLIT_TEST], info.n_pairs);
    assert_int_equal(info.n_refs, 1);
    nqm_dataset_free(test);
}

static void a_fit_of_its_own_model_is_near_perfect(void **state) {
    (void)state;
    nqm_dataset *d = training_part();
    for (size_t i = 0; i < d->n_pairs; ++i) {
        const char *kind = d->kind_names[d->pair_kind[i]], *ref = d->ref_names[d->pair_ref[i]];
        if (strcmp(ref, "a-ggx") == 0 && strcmp(kind, "ggx") == 0)
            assert_true(d->delta_e[i] < 0.1);
        if (strcmp(ref, "a-ggx") == 0 && strcmp(kind, "ward") == 0)
            assert_true(d->delta_e[i] > 0.5);
    }
    nqm_dataset_free(d);
}

enum { N_HAND = 7 }; /* tests of the corpus below: ward, ggx, and five perturbed copies */

/* A corpus of one group whose test t has samples of t and a Delta-E of t; those whose bit is in `failed` failed. */
static void write_by_hand(unsigned failed, const char *path) {
    static nqm_corpus_item item;
    static float ref_rgb[3 * 50], test_rgb[N_HAND][3 * 50];
    static uint8_t ref_used[50], test_used[N_HAND][50];
    static double delta_e[N_HAND], fit_loss[N_HAND];
    static char *names[N_HAND], *failures[N_HAND];
    nqm_corpus_options options = small_corpus(NQM_CORPUS_TRAINING);
    options.n_perturbations = 5;
    nqm_directions *d = directions();
    nqm_corpus c = {.n_items = 1, .n_refs = 1, .n_tests = N_HAND, .n_directions = 50, .items = &item};
    c.context.options = &options;
    c.context.directions = d;
    c.context.list = &c.list;
    assert_int_equal(nqm_corpus_models_parse(options.models, &c.context.models, NULL), NQM_OK);
    const char *csv = write_text("one.csv", "name,group,brdf,source,split\nb-ggx,b,ggx:kd=0.1;alpha=0.4,ggx,train\n");
    assert_int_equal(nqm_corpus_list_load(csv, NULL, &c.list, NULL), NQM_OK);
    assert_int_equal(nqm_corpus_plan_make(&c.list, 0, &c.context.models, &options, &item.plan, NULL), NQM_OK);
    assert_int_equal(item.plan.n_tests, N_HAND);
    memset(ref_used, 1, sizeof ref_used);
    memset(test_used, 1, sizeof test_used);
    for (int t = 0; t < N_HAND; ++t) {
        static char text[N_HAND][16];
        snprintf(text[t], sizeof text[t], "test %d", t);
        names[t] = text[t];
        failures[t] = failed >> t & 1 ? text[t] : NULL;
        delta_e[t] = t;
        fit_loss[t] = 0.5;
        for (int i = 0; i < 3 * 50; ++i)
            test_rgb[t][i] = (float)t;
    }
    item.names = c.names = names;
    item.failures = c.failures = failures;
    item.fit_loss = c.fit_loss = fit_loss;
    item.delta_e = c.delta_e = delta_e;
    item.ref_rgb = c.ref_rgb = ref_rgb;
    item.ref_used = c.ref_used = ref_used;
    item.test_rgb = c.test_rgb = test_rgb[0];
    item.test_used = c.test_used = test_used[0];
    assert_int_equal(nqm_corpus_write(&c, path, NULL), NQM_OK);
    nqm_corpus_plan_free(&item.plan);
    nqm_corpus_list_free(&c.list);
    nqm_directions_free(d);
}

static void failed_tests_are_left_out_and_named(void **state) {
    (void)state;
    nqm_dataset *d;
    char path[256];
    snprintf(path, sizeof path, "%s", in_folder("hand.safetensors"));
    write_by_hand(1u << 0 | 1u << 4, path);
    assert_int_equal(nqm_dataset_load(path, &d, NULL), NQM_OK);
    static const int kept[] = {1, 2, 3, 5, 6};
    assert_int_equal(d->n_pairs, 5);
    for (size_t p = 0; p < 5; ++p) {
        char name[16];
        snprintf(name, sizeof name, "test %d", kept[p]);
        assert_string_equal(d->pair_names[p], name);
        assert_near(d->delta_e[p], kept[p], 0);
        for (size_t i = 0; i < 3 * 50; ++i)
            assert_near(d->test_rgb[150 * p + i], kept[p], 0);
    }
    for (size_t k = 0; k < d->n_kinds; ++k)
        assert_string_not_equal(d->kind_names[k], "ward");
    assert_string_equal(d->kind_names[0], "ggx");
    assert_string_equal(nqm_dataset_get_pair(d, 0).family, "encoding");
    json_t *manifest = json_loads(d->manifest, 0, NULL);
    json_t *failures = json_object_get(manifest, "failures"), *ward = json_object_get(failures, "ward");
    assert_int_equal(json_object_size(failures), 2);
    assert_int_equal(json_integer_value(json_object_get(ward, "pairs")), 1);
    assert_string_equal(json_string_value(json_object_get(ward, "message")), "test 0");
    assert_string_equal(json_string_value(json_array_get(json_object_get(ward, "references"), 0)), "b-ggx");
    json_t *families = json_object_get(manifest, "families");
    assert_int_equal(json_integer_value(json_object_get(families, "encoding")), 1);
    json_decref(manifest);
    manifest = json_load_file(in_folder("hand.safetensors.json"), 0, NULL);
    assert_string_equal(json_string_value(json_object_get(manifest, "dataset_sha256")), d->sha256);
    json_decref(manifest);
    nqm_dataset_free(d);
}

/* A claim keeps others off until it is released or its process ends. */
static void claims_exclude(void **state) {
    (void)state;
    char path[256];
    int first, second;
    snprintf(path, sizeof path, "%s", in_folder("claimed"));
    assert_int_equal(nqm_corpus_claim(path, &first, NULL), NQM_OK);
    assert_true(first >= 0);
    assert_int_equal(nqm_corpus_claim(path, &second, NULL), NQM_OK);
    assert_int_equal(second, -1);
    nqm_corpus_release(path, first);
    assert_int_not_equal(access(in_folder("claimed.claim"), F_OK), 0);
    pid_t child = fork();
    if (child == 0) {
        bool claimed = nqm_corpus_claim(path, &first, NULL) == NQM_OK && first >= 0;
        raise(claimed ? SIGKILL : SIGTERM);
    }
    int end;
    assert_int_equal(waitpid(child, &end, 0), child);
    assert_int_equal(WTERMSIG(end), SIGKILL);
    assert_int_equal(access(in_folder("claimed.claim"), F_OK), 0);
    assert_int_equal(nqm_corpus_claim(path, &second, NULL), NQM_OK);
    assert_true(second >= 0);
    nqm_corpus_release(path, second);
    assert_int_equal(nqm_corpus_claim("/nowhere/x", &second, NULL), NQM_ERR_IO);
}

/* Stops in the second group, which begins with fits: they take longer than a ticker waits. */
static int stop_in_second_group(void *user, const char *stage, double done, double total) {
    (void)user;
    (void)stage;
    return done > 12 && done < total;
}

static void remove_folder(const char *path) {
    DIR *dir = opendir(path);
    for (struct dirent *entry; dir && (entry = readdir(dir)) != NULL;) {
        char file[512];
        snprintf(file, sizeof file, "%s/%s", path, entry->d_name);
        remove(file);
    }
    if (dir)
        closedir(dir);
    rmdir(path);
}

static size_t count_files(const char *path) {
    DIR *dir = opendir(path);
    size_t n = 0;
    for (struct dirent *entry; dir && (entry = readdir(dir)) != NULL;)
        n += entry->d_name[0] != '.';
    if (dir)
        closedir(dir);
    return n;
}

static void an_interrupted_corpus_goes_on(void **state) {
    (void)state;
    char work[256], csv[256];
    snprintf(work, sizeof work, "%s", in_folder("work"));
    nqm_corpus_options options = small_corpus(NQM_CORPUS_TRAINING);
    nqm_dataset *whole = training_part();
    char sha256[65];
    snprintf(sha256, sizeof sha256, "%s", nqm_dataset_get_info(whole).sha256);
    nqm_dataset_free(whole);

    nqm_directions *d = directions();
    options.checkpoint = work;
    options.progress = stop_in_second_group;
    snprintf(csv, sizeof csv, "%s", write_text("list.csv", materials));
    int n_threads = omp_get_max_threads();
    omp_set_num_threads(1); /* one group after the other */
    assert_int_equal(nqm_corpus_build(csv, d, &options, in_folder("never.safetensors"), NULL), NQM_ERR_CANCELLED);
    omp_set_num_threads(n_threads);
    assert_int_equal(count_files(work), 1);
    assert_int_not_equal(access(in_folder("never.safetensors"), F_OK), 0);
    nqm_directions_free(d);

    options.progress = NULL;
    for (int round = 0; round < 2; ++round) { /* the second takes all from the work files */
        nqm_dataset *resumed = build(&options, "resumed.safetensors");
        assert_string_equal(nqm_dataset_get_info(resumed).sha256, sha256);
        nqm_dataset_free(resumed);
        assert_int_equal(count_files(work), 2);
    }
    remove_folder(work);
}

static void a_part_without_materials_is_refused(void **state) {
    (void)state;
    nqm_error err = {0};
    nqm_directions *d = directions();
    nqm_corpus_options options = small_corpus(NQM_CORPUS_TEST);
    char csv[256];
    snprintf(csv, sizeof csv, "%s", write_text("train.csv", "name,group,brdf,source,split\na,a,sgd:brass,sgd,train\n"));
    assert_int_equal(nqm_corpus_build(csv, d, &options, in_folder("x.safetensors"), &err), NQM_ERR_INCOMPATIBLE);
    assert_non_null(strstr(err.message, "train.csv"));
    nqm_directions_free(d);
}

static int make_folder(void **state) {
    (void)state;
    return mkdtemp(folder) ? 0 : -1;
}

static int clean_up(void **state) {
    (void)state;
    remove_folder(folder);
    return 0;
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
        cmocka_unit_test(folding_makes_reciprocal),
        cmocka_unit_test(parts_hold_their_splits),
        cmocka_unit_test(a_fit_of_its_own_model_is_near_perfect),
        cmocka_unit_test(failed_tests_are_left_out_and_named),
        cmocka_unit_test(claims_exclude),
        cmocka_unit_test(an_interrupted_corpus_goes_on),
        cmocka_unit_test(a_part_without_materials_is_refused),
    };
    return cmocka_run_group_tests_name("label: corpus", tests, make_folder, clean_up);
}
