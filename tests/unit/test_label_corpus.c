/* SPDX-License-Identifier: MIT
 *
 * Corpora: a small one of analytic materials is made, interrupted, resumed and read back; failed tests; labels of far tests and
 * roundings.
 */
#include "label/corpus.h"
#include "support/check.h"
#include "support/corpus_files.h"
#include "train/train.h"

#include <dirent.h>
#include <jansson.h>
#include <omp.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

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
    options.n_far = 2;
    options.n_roundings = 1;
    options.models = "ward,ggx";
    options.scene.n_points = 256;
    return options;
}

static nqm_dataset *build_from(const char *materials, const nqm_corpus_options *options, const char *name) {
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

static nqm_dataset *build(const nqm_corpus_options *options, const char *name) {
    return build_from(corpus_materials, options, name);
}

/* The training part of the corpus, computed once. */
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
    assert_int_equal(info.n_pairs, 3 * (2 + 3 + 2 + 1) + 2); /* the two forms of `a` are also tests of each other */
    assert_int_equal(info.n_pairs_in[NQM_SPLIT_TEST], 0);
    assert_int_equal(info.n_pairs_in[NQM_SPLIT_VALIDATION], 2 + 3 + 2 + 1);
    assert_non_null(strstr(info.manifest, "\"unseen_kinds\""));
    assert_null(strstr(info.manifest, "nickel"));
    for (size_t i = 0; i < info.n_pairs; ++i) {
        assert_null(strstr(nqm_name(&training->pair_names, i), "nickel"));
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
        const char *kind = nqm_name(&d->kind_names, d->pair_kind[i]), *ref = nqm_name(&d->ref_names, d->pair_ref[i]);
        if (strcmp(ref, "a-ggx") == 0 && strcmp(kind, "ggx") == 0)
            assert_true(d->delta_e[i] < 0.1);
        if (strcmp(ref, "a-ggx") == 0 && strcmp(kind, "ward") == 0)
            assert_true(d->delta_e[i] > 0.5);
    }
    nqm_dataset_free(d);
}

enum { N_HAND = 7 }; /* tests of the corpus below: ward, ggx, and five perturbed copies */

/* A corpus of one group; test t has samples equal to t and a Delta-E of t, or has failed if bit t of `failed` is
 * set. */
static void write_by_hand(unsigned failed, const char *path) {
    static nqm_corpus_item item;
    static float ref_rgb[3 * 50], test_rgb[N_HAND][3 * 50];
    static uint8_t ref_used[50], test_used[N_HAND][50], kept[N_HAND];
    static nqm_label label[N_HAND];
    static double fit_loss[N_HAND];
    static char *names[N_HAND], *failures[N_HAND];
    nqm_corpus_options options = small_corpus(NQM_CORPUS_TRAINING);
    options.n_perturbations = 5;
    options.n_far = options.n_roundings = 0;
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
    memset(kept, 1, sizeof kept);
    item.kept = c.kept = kept;
    for (int t = 0; t < N_HAND; ++t) {
        static char text[N_HAND][16];
        snprintf(text[t], sizeof text[t], "test %d", t);
        names[t] = text[t];
        failures[t] = failed >> t & 1 ? text[t] : NULL;
        label[t] = (nqm_label){.delta_e = t, .shift = {-t, 0, 0}, .structure = 2 * t};
        fit_loss[t] = 0.5;
        for (int i = 0; i < 3 * 50; ++i)
            test_rgb[t][i] = (float)t;
    }
    item.names = c.names = names;
    item.failures = c.failures = failures;
    item.fit_loss = c.fit_loss = fit_loss;
    item.label = c.label = label;
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
        assert_string_equal(nqm_name(&d->pair_names, p), name);
        assert_near(d->delta_e[p], kept[p], 0);
        assert_near(d->parts[p * NQM_LABEL_PARTS], -kept[p], 0);
        assert_near(d->parts[p * NQM_LABEL_PARTS + 4], 2 * kept[p], 0);
        for (size_t i = 0; i < 3 * 50; ++i)
            assert_near(d->test_rgb[150 * p + i], kept[p], 0);
    }
    for (size_t k = 0; k < d->n_kinds; ++k)
        assert_string_not_equal(nqm_name(&d->kind_names, k), "ward");
    assert_string_equal(nqm_name(&d->kind_names, 0), "ggx");
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

/* Sum of the pairs in a manifest's object of counts. */
static size_t sum_of(const json_t *counts) {
    const char *name;
    json_t *n;
    size_t sum = 0;
    json_object_foreach((json_t *)(uintptr_t)counts, name, n) sum += (size_t)json_integer_value(n);
    return sum;
}

/* Labels of rounded copies are nearly 0, those of black and white are large; far tests spread over the range; every name opens
 * again; the manifest counts them, and other materials by split. */
static void far_tests_are_labelled(void **state) {
    (void)state;
    static const char materials[] = "name,group,brdf,source,split\n"
                                    "a,a,ggx:kd=0.2;alpha=0.2,x,test\nb,b,ward:kd=0.1;ks=.1;alpha=.1,x,test\n"
                                    "c,c,sgd:nickel,y,test\nd,d,sgd:brass,y,train\ne,e,sgd:chrome,x,validation\n";
    nqm_corpus_options options = small_corpus(NQM_CORPUS_TEST);
    options.models = "";
    options.n_perturbations = 0;
    options.n_far = 35;
    options.n_roundings = 3;
    nqm_dataset *d = build_from(materials, &options, "far.safetensors");
    size_t n = nqm_dataset_get_info(d).n_pairs, n_black = 0, n_white = 0, n_near = 0, n_others = 0;
    assert_int_equal(n, 3 * (35 + 3));
    for (size_t i = 0; i < n; ++i) {
        nqm_dataset_pair pair = nqm_dataset_get_pair(d, i);
        if (strcmp(pair.family, "rounding") == 0)
            assert_true(pair.delta_e < 1);
        n_black += strcmp(pair.kind, "black") == 0;
        n_white += strcmp(pair.kind, "white") == 0;
        if (strcmp(pair.kind, "black") == 0 || strcmp(pair.kind, "white") == 0)
            assert_true(pair.delta_e > 10);
        n_near += strcmp(pair.family, "far") == 0 && pair.jod > 7;
        n_others += strncmp(pair.kind, "other-", 6) == 0 || strncmp(pair.kind, "between", 7) == 0;
        nqm_brdf_free(open_brdf(pair.test));
        assert_null(strstr(pair.test, "brass"));
        assert_null(strstr(pair.test, "chrome"));
    }
    assert_true(n_black > 0 && n_white > 0 && n_near > 5 && n_others > 5);
    json_t *manifest = json_loads(d->manifest, 0, NULL);
    json_t *families = json_object_get(manifest, "families"), *others = json_object_get(manifest, "other_materials");
    assert_int_equal(json_integer_value(json_object_get(families, "far")), 3 * 35);
    assert_int_equal(json_integer_value(json_object_get(families, "rounding")), 3 * 3);
    assert_int_equal(json_object_size(others), 1);
    assert_int_equal(sum_of(json_object_get(others, "test")), n_others);
    json_decref(manifest);
    nqm_dataset_free(d);
}

enum { N_FIRST_GROUP = 2 * (2 + 3 + 2 * NQM_CORPUS_CANDIDATES + 1) + 2 }; /* tests */

/* Stops in the second group: a fit calls without a finished test after all of the first group are. A ticker makes no call for
 * 0.2 s after the last one; a longer wait here makes it call for every test on a machine of any speed. */
static int stop_in_second_group(void *user, const char *stage, double done, double total) {
    static double last = -1;
    const bool is_new = done != last;
    (void)user;
    (void)stage;
    last = done;
    if (done <= N_FIRST_GROUP && is_new)
        nanosleep(&(struct timespec){.tv_nsec = 210 * 1000 * 1000}, NULL);
    return (done > N_FIRST_GROUP || (done == N_FIRST_GROUP && !is_new)) && done < total;
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
    snprintf(csv, sizeof csv, "%s", write_text("list.csv", corpus_materials));
    int n_threads = omp_get_max_threads();
    omp_set_num_threads(1); /* one group after the other */
    assert_int_equal(nqm_corpus_build(csv, d, &options, in_folder("never.safetensors"), NULL), NQM_ERR_CANCELLED);
    omp_set_num_threads(n_threads);
    assert_int_equal(count_files(work), 1);
    assert_int_not_equal(access(in_folder("never.safetensors"), F_OK), 0);
    nqm_directions_free(d);

    options.progress = NULL;
    for (int round = 0; round < 2; ++round) { /* the second round reads all groups from the work files */
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

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(parts_hold_their_splits),
        cmocka_unit_test(a_fit_of_its_own_model_is_near_perfect),
        cmocka_unit_test(failed_tests_are_left_out_and_named),
        cmocka_unit_test(far_tests_are_labelled),
        cmocka_unit_test(an_interrupted_corpus_goes_on),
        cmocka_unit_test(a_part_without_materials_is_refused),
    };
    return cmocka_run_group_tests_name("label: corpus", tests, make_folder, remove_made_folder);
}
