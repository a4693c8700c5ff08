/* SPDX-License-Identifier: MIT
 *
 * Corpora: a small one of analytic materials is made, interrupted, resumed and read back; failed tests; labels of far tests and
 * roundings.
 */
#include "corpus/corpus.h"
#include "support/check.h"
#include "support/corpus_files.h"
#include "support/scenes.h"
#include "train/train.h"

#include <dirent.h>
#include <jansson.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
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
    options.n_variants = 0;
    options.models = "ward,ggx";
    options.scene.n_points = 256;
    return options;
}

static nqm_dataset *build_from(const char *materials, const nqm_corpus_options *options, const char *name) {
    nqm_error err = {0};
    nqm_dataset *dataset = NULL;
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
    options.n_far = options.n_roundings = options.n_variants = 0;
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
        label[t] = (nqm_label){.delta_e = t, .shift = {-t, 0, 0}, .structure = 2 * t, .error = 0.5 * t};
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
        assert_near(d->delta_e_error[p], 0.5 * kept[p], 0);
        assert_string_equal(nqm_dataset_get_pair(d, p).source, "ggx");
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

/* Stops at the second report of the corpus. */
static int stop_soon(void *user, const char *stage, double done, double total) {
    static int calls_left = 2;
    (void)user;
    return strcmp(stage, "corpus") == 0 && --calls_left <= 0 && done < total;
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
    options.progress = stop_soon;
    snprintf(csv, sizeof csv, "%s", write_text("list.csv", corpus_materials));
    assert_int_equal(nqm_corpus_build(csv, d, &options, in_folder("never.safetensors"), NULL), NQM_ERR_CANCELLED);
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

/* A group whose making is stopped: counts units, and stops when `stop` of them are done. */
typedef struct making {
    nqm_corpus_context context;
    nqm_corpus_options options;
    nqm_corpus_list list;
    nqm_scene *scene;
    nqm_directions *directions;
    nqm_corpus_item item;
    size_t n_done, stop, resumed; /* resumed: units of the first call */
} making;

static bool count_units(void *user, size_t n_units) {
    making *m = user;
    m->resumed = m->resumed == SIZE_MAX ? n_units : m->resumed;
    m->n_done += n_units;
    return m->n_done >= m->stop;
}

static void free_strings(nqm_corpus_item *item) {
    for (size_t t = 0; t < item->plan.n_tests; ++t) {
        nqm_free(item->names[t]);
        nqm_free(item->failures[t]);
        item->names[t] = item->failures[t] = NULL;
    }
}

static void begin_making(making *m, const char *path, const char *models) {
    *m = (making){.options = small_corpus(NQM_CORPUS_TRAINING), .directions = directions()};
    nqm_corpus_item *item = &m->item;
    m->options.scene.n_points = 64;
    const char *csv = write_text("list.csv", corpus_materials);
    assert_int_equal(nqm_corpus_list_load(csv, NULL, &m->list, NULL), NQM_OK);
    m->scene = make_scene(&m->options.scene);
    m->context = (nqm_corpus_context){.list = &m->list,
                                      .options = &m->options,
                                      .directions = m->directions,
                                      .scene = m->scene,
                                      .step = count_units,
                                      .step_user = m};
    assert_int_equal(nqm_corpus_models_parse(models, &m->context.models, NULL), NQM_OK);
    assert_int_equal(nqm_corpus_cache_create(m->list.n_refs, &m->context.cache, NULL), NQM_OK);
    assert_int_equal(nqm_corpus_plan_make(&m->list, 0, &m->context.models, &m->options, &item->plan, NULL), NQM_OK);
    const size_t n = item->plan.n_tests, n_refs = item->plan.n_refs;
    assert_int_equal(
        nqm_alloc_arrays(NQM_ARRAYS({&item->ref_rgb, n_refs * 50, 3 * sizeof(float)}, {&item->ref_used, n_refs * 50, 1},
                                    {&item->test_rgb, n * 50, 3 * sizeof(float)}, {&item->test_used, n * 50, 1},
                                    {&item->label, n, sizeof *item->label}, {&item->fit_loss, n, sizeof(double)},
                                    {&item->kept, n, 1}, {&item->names, n, sizeof *item->names},
                                    {&item->failures, n, sizeof *item->failures}),
                         NULL),
        NQM_OK);
    item->path = (char *)(uintptr_t)path;
}

static void end_making(making *m) {
    free_strings(&m->item);
    nqm_free(m->item.ref_rgb);
    nqm_corpus_plan_free(&m->item.plan);
    nqm_corpus_cache_free(m->context.cache);
    nqm_scene_free(m->scene);
    nqm_corpus_list_free(&m->list);
    nqm_directions_free(m->directions);
}

/* Make the group until `stop` units are done, as a process would that finds the files of the one before. */
static nqm_status make_until(making *m, size_t stop) {
    m->n_done = 0;
    m->resumed = SIZE_MAX;
    m->stop = stop;
    return nqm_corpus_item_make(&m->context, &m->item, NULL);
}

static void an_interrupted_group_goes_on_where_it_stopped(void **state) {
    (void)state;
    enum { MORE = 11 }; /* tests until the next stop, which is within the second reference */
    char path[256], progress[280];
    snprintf(path, sizeof path, "%s", in_folder("group.safetensors"));
    snprintf(progress, sizeof progress, "%s.progress", path);
    making whole, parts;
    begin_making(&whole, NULL, "ward,ggx");
    begin_making(&parts, path, "ward,ggx");
    assert_int_equal(make_until(&whole, SIZE_MAX), NQM_OK);
    assert_int_equal(whole.item.plan.n_refs, 2);
    const size_t n_fits = 2 * NQM_CORPUS_FIT_UNITS, n_tests = parts.item.plan.n_tests;
    assert_int_equal(whole.n_done, n_tests + 2 * n_fits);

    assert_int_equal(make_until(&parts, n_fits + 4), NQM_ERR_CANCELLED); /* after four tests of the first reference */
    assert_int_equal(parts.resumed, 0);
    assert_int_equal(access(progress, F_OK), 0);
    for (size_t n_done = 4; n_done < n_tests; n_done += MORE) {
        end_making(&parts);
        begin_making(&parts, path, "ward,ggx");
        const size_t n_refs = parts.item.plan.tests[n_done].ref;
        const bool is_last = n_done + MORE >= n_tests;
        const size_t crosses = !is_last && parts.item.plan.tests[n_done + MORE - 1].ref > n_refs;
        assert_int_equal(make_until(&parts, is_last ? SIZE_MAX : n_done + MORE + (n_refs + 1 + crosses) * n_fits),
                         is_last ? NQM_OK : NQM_ERR_CANCELLED);
        assert_int_equal(parts.resumed, n_done + n_refs * n_fits);
    }
    const nqm_corpus_item *a = &whole.item, *b = &parts.item;
    assert_memory_equal(a->test_rgb, b->test_rgb, n_tests * 50 * 3 * sizeof(float));
    assert_memory_equal(a->test_used, b->test_used, n_tests * 50);
    assert_memory_equal(a->ref_rgb, b->ref_rgb, (size_t)2 * 50 * 3 * sizeof(float));
    assert_memory_equal(a->label, b->label, n_tests * sizeof *a->label);
    assert_memory_equal(a->fit_loss, b->fit_loss, n_tests * sizeof(double));
    assert_memory_equal(a->kept, b->kept, n_tests);
    for (size_t t = 0; t < n_tests; ++t)
        assert_string_equal(a->names[t], b->names[t]);
    assert_int_equal(nqm_corpus_item_save(50, b, n_tests, NULL), NQM_OK);
    assert_int_not_equal(access(progress, F_OK), 0); /* the finished group replaces it */
    remove(path);
    end_making(&whole);
    end_making(&parts);
}

static size_t inode_of(const char *path) {
    struct stat st;
    assert_int_equal(stat(path, &st), 0);
    return (size_t)st.st_ino;
}

static void assert_equal_items(const nqm_corpus_item *a, const nqm_corpus_item *b) {
    const size_t n = a->plan.n_tests;
    assert_memory_equal(a->test_rgb, b->test_rgb, n * 50 * 3 * sizeof(float));
    assert_memory_equal(a->test_used, b->test_used, n * 50);
    assert_memory_equal(a->label, b->label, n * sizeof *a->label);
    assert_memory_equal(a->fit_loss, b->fit_loss, n * sizeof(double));
    assert_memory_equal(a->kept, b->kept, n);
    for (size_t t = 0; t < n; ++t) {
        assert_string_equal(a->names[t], b->names[t]);
        assert_string_equal(a->failures[t] ? a->failures[t] : "", b->failures[t] ? b->failures[t] : "");
    }
}

/* Change the digit after `key` in the header of a file. */
static void damage(const char *path, const char *key) {
    char text[4096];
    FILE *f = fopen(path, "r+b");
    assert_non_null(f);
    const size_t n = fread(text, 1, sizeof text - 1, f);
    text[n] = 0;
    const char *found = strstr(text + 8, key);
    assert_non_null(found);
    const char *digit = found + strcspn(found, "123456789");
    assert_int_equal(fseek(f, digit - text, SEEK_SET), 0);
    assert_true(fputc(*digit == '9' ? '8' : *digit + 1, f) != EOF && fclose(f) == 0);
}

/* Each finished fit is saved, and a file that was damaged or has another name is made again: the group stays the same. */
static void an_interrupted_group_keeps_its_fits(void **state) {
    (void)state;
    enum { N_MODELS = 4 };
    static const char models[] = "ward,sparse-2,hyper-2,blinn-phong";
    static const char *const file[N_MODELS] = {"0-ward", "0-sparse-2", "0-hyper-2", "0-blinn-phong"};
    char path[256], fits[280], saved[N_MODELS][300];
    snprintf(path, sizeof path, "%s", in_folder("group.safetensors"));
    snprintf(fits, sizeof fits, "%s.fits", path);
    for (size_t k = 0; k < N_MODELS; ++k)
        snprintf(saved[k], sizeof saved[k], "%s/%s", fits, file[k]);
    making whole, parts;
    begin_making(&whole, NULL, models);
    assert_int_equal(make_until(&whole, SIZE_MAX), NQM_OK);
    size_t inode[N_MODELS];
    for (size_t k = 0; k < N_MODELS; ++k) {
        begin_making(&parts, path, models);
        assert_int_equal(make_until(&parts, (k + 1) * NQM_CORPUS_FIT_UNITS), NQM_ERR_CANCELLED);
        end_making(&parts);
        assert_int_equal(count_files(fits), k + 1);
        for (size_t i = 0; i < k; ++i)
            assert_int_equal(inode_of(saved[i]), inode[i]);
        inode[k] = inode_of(saved[k]);
    }
    damage(saved[0], "kd=");
    damage(saved[1], "loss");
    assert_int_equal(rename(saved[2], saved[3]), 0);
    begin_making(&parts, path, models);
    assert_int_equal(make_until(&parts, SIZE_MAX), NQM_OK);
    assert_int_equal(whole.n_done, parts.n_done);
    assert_equal_items(&whole.item, &parts.item);
    assert_int_equal(nqm_corpus_item_save(50, &parts.item, parts.item.plan.n_tests, NULL), NQM_OK);
    assert_int_not_equal(access(fits, F_OK), 0);
    remove(path);
    end_making(&whole);
    end_making(&parts);
}

/* A failed fit is not tried again, and has the same message. */
static void a_failed_fit_is_kept(void **state) {
    (void)state;
    char path[256];
    snprintf(path, sizeof path, "%s", in_folder("group.safetensors"));
    const nqm_corpus_item item = {.path = path};
    nqm_corpus_fit fit = {.report = {.spec = "of another reference", .loss = 2}}, loaded = {.report = {.loss = 1}};
    (void)!nqm_fail(&fit.fault, NQM_ERR_NUMERIC, -1, "\"%s\": it diverged", "b");
    assert_int_equal(nqm_corpus_fit_save(&item, 1, "nbrdf", &fit, NULL), NQM_OK);
    assert_false(nqm_corpus_fit_load(&item, 0, "nbrdf", &loaded));
    assert_false(nqm_corpus_fit_load(&item, 1, "ward", &loaded));
    assert_int_equal(loaded.fault.status, NQM_OK);
    assert_true(nqm_corpus_fit_load(&item, 1, "nbrdf", &loaded));
    assert_int_equal(loaded.fault.status, NQM_ERR_NUMERIC);
    assert_string_equal(loaded.fault.message, "\"b\": it diverged");
    assert_null(loaded.view.brdf);
    nqm_corpus_fits_remove(&item);
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
        cmocka_unit_test(an_interrupted_group_goes_on_where_it_stopped),
        cmocka_unit_test(an_interrupted_group_keeps_its_fits),
        cmocka_unit_test(a_failed_fit_is_kept),
        cmocka_unit_test(a_part_without_materials_is_refused),
    };
    return cmocka_run_group_tests_name("label: corpus", tests, make_folder, remove_made_folder);
}
