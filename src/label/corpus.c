/* SPDX-License-Identifier: MIT
 *
 * Making a corpus: plan every material group, work on the groups in parallel (finished ones come from their work
 * files), and write one dataset file with its manifest. What is in a corpus and why: doc/corpus.md.
 */
#include "label/corpus.h"
#include "train/train.h"

#include <pthread.h>
#include <stdatomic.h>
#include <string.h>
#include <sys/stat.h>

/* A corpus in the making. The groups' items are views into its arrays. */
typedef struct corpus {
    nqm_corpus_context context;
    nqm_corpus_list list;
    nqm_scene *scene;
    size_t n_items, n_refs, n_tests, n_directions;
    nqm_corpus_item *items;
    float *ref_rgb, *test_rgb;
    uint8_t *ref_used, *test_used;
    double *delta_e;
    char **names;

    /* shared by the threads */
    atomic_size_t n_done; /* tests finished */
    atomic_bool stopped;
    pthread_mutex_t mutex; /* guards status and *err */
    nqm_status status;
    nqm_error *err;
    pthread_t caller; /* the only thread that may report progress */
    nqm_ticker ticker;
} corpus;

nqm_corpus_options nqm_corpus_options_default(void) {
    return (nqm_corpus_options){.part = NQM_CORPUS_TRAINING, .n_perturbations = 26, .seed = 1};
}

/* ---- preparation ------------------------------------------------------------------------------------------------- */

static nqm_status make_scene(corpus *c, nqm_error *err) {
    nqm_scene_options *scene = &c->context.scene_options;
    *scene = nqm_scene_options_default();
    scene->light = c->context.options->light;
    nqm_status status = scene->light ? nqm_corpus_hash_file(scene->light, c->context.light_sha256, err) : NQM_OK;
    if (status == NQM_OK)
        status = nqm_scene_create(scene, &c->scene, err);
    c->context.scene = c->scene;
    return status;
}

static nqm_status make_plans(corpus *c, const char *materials_csv, nqm_error *err) {
    const nqm_corpus_options *options = c->context.options;
    c->items = nqm_alloc(c->list.n_groups, sizeof *c->items);
    if (!c->items)
        return nqm_fail_nomem(err, c->list.n_groups * sizeof *c->items);
    for (size_t g = 0; g < c->list.n_groups; ++g) {
        if (!nqm_corpus_in_part(&c->list.groups[g], options->part))
            continue;
        nqm_corpus_item *item = &c->items[c->n_items];
        nqm_status status = nqm_corpus_plan_make(&c->list, g, options, &item->plan, err);
        if (status != NQM_OK)
            return status;
        ++c->n_items;
        c->n_refs += item->plan.n_refs;
        c->n_tests += item->plan.n_tests;
    }
    if (c->n_tests == 0)
        return nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "%s: no material of this part (%s)", materials_csv,
                        options->part == NQM_CORPUS_TEST ? "test" : "train, validation");
    return NQM_OK;
}

static nqm_status make_arrays(corpus *c, nqm_error *err) {
    size_t n = c->n_directions, n_refs = c->n_refs, n_tests = c->n_tests;
    c->ref_rgb = nqm_alloc(n_refs * n, 3 * sizeof(float));
    c->ref_used = nqm_alloc(n_refs * n, 1);
    c->test_rgb = nqm_alloc(n_tests * n, 3 * sizeof(float));
    c->test_used = nqm_alloc(n_tests * n, 1);
    c->delta_e = nqm_alloc(n_tests, sizeof(double));
    c->names = nqm_alloc(n_tests, sizeof *c->names);
    if (!c->ref_rgb || !c->ref_used || !c->test_rgb || !c->test_used || !c->delta_e || !c->names)
        return nqm_fail_nomem(err, 13 * (n_refs + n_tests) * n);
    size_t ref = 0, test = 0;
    for (size_t i = 0; i < c->n_items; ++i) {
        nqm_corpus_item *item = &c->items[i];
        item->ref_rgb = c->ref_rgb + 3 * n * ref;
        item->ref_used = c->ref_used + n * ref;
        item->test_rgb = c->test_rgb + 3 * n * test;
        item->test_used = c->test_used + n * test;
        item->delta_e = c->delta_e + test;
        item->names = c->names + test;
        ref += item->plan.n_refs;
        test += item->plan.n_tests;
    }
    return NQM_OK;
}

/* ---- the work ---------------------------------------------------------------------------------------------------- */

/* Count finished tests; from the caller's thread, report them. true: stop. */
static bool advance(corpus *c, size_t n_tests) {
    size_t done = atomic_fetch_add(&c->n_done, n_tests) + n_tests;
    if (pthread_equal(pthread_self(), c->caller) && nqm_tick(&c->ticker, "corpus", (double)done, (double)c->n_tests))
        atomic_store(&c->stopped, true);
    return atomic_load(&c->stopped);
}

static bool step(void *user) {
    return advance(user, 1);
}

/* The first failure counts, and stops the others. */
static void keep_failure(corpus *c, nqm_status status, const nqm_error *err) {
    pthread_mutex_lock(&c->mutex);
    if (c->status == NQM_OK) {
        c->status = status;
        if (c->err)
            *c->err = *err;
    }
    pthread_mutex_unlock(&c->mutex);
    atomic_store(&c->stopped, true);
}

static void work_on_item(void *user, size_t i) {
    corpus *c = user;
    nqm_corpus_item *item = &c->items[i];
    nqm_error err = {0};
    char *path = NULL;
    nqm_status status = NQM_OK;
    if (atomic_load(&c->stopped))
        return;
    if (c->context.options->checkpoint) {
        status = nqm_corpus_item_path(&c->context, item, &path, &err);
        if (status == NQM_OK && nqm_corpus_item_load(path, c->n_directions, item)) {
            advance(c, item->plan.n_tests);
            goto done;
        }
    }
    if (status == NQM_OK)
        status = nqm_corpus_item_make(&c->context, item, &err);
    if (status == NQM_OK && path)
        status = nqm_corpus_item_save(path, c->n_directions, item, &err);
    if (status != NQM_OK)
        keep_failure(c, status, &err);
done:
    nqm_free(path);
}

static nqm_status work(corpus *c, nqm_error *err) {
    c->context.step = step;
    c->context.step_user = c;
    c->caller = pthread_self();
    c->err = err;
    pthread_mutex_init(&c->mutex, NULL);
    nqm_parallel_for(c->n_items, work_on_item, c);
    pthread_mutex_destroy(&c->mutex);
    if (c->status == NQM_OK && atomic_load(&c->stopped))
        return nqm_fail(err, NQM_ERR_CANCELLED, -1, "corpus: stopped");
    return c->status;
}

/* ---- the dataset ------------------------------------------------------------------------------------------------- */

/* Index tables and names of the dataset, in one place to free them. */
typedef struct tables {
    uint32_t *pair_ref, *pair_kind, *ref_group;
    uint8_t *group_split;
    double *jod;
    const char **ref_names, **group_names, *kind_names[NQM_KIND_COUNT];
    size_t n_kinds; /* that occur */
    char *manifest, *manifest_path;
} tables;

static nqm_status alloc_tables(const corpus *c, tables *t, nqm_error *err) {
    t->pair_ref = nqm_alloc(c->n_tests, sizeof *t->pair_ref);
    t->pair_kind = nqm_alloc(c->n_tests, sizeof *t->pair_kind);
    t->jod = nqm_alloc(c->n_tests, sizeof *t->jod);
    t->ref_group = nqm_alloc(c->n_refs, sizeof *t->ref_group);
    t->ref_names = nqm_alloc(c->n_refs, sizeof *t->ref_names);
    t->group_split = nqm_alloc(c->n_items, sizeof *t->group_split);
    t->group_names = nqm_alloc(c->n_items, sizeof *t->group_names);
    t->manifest = nqm_corpus_manifest(&c->context, c->n_items, c->items);
    if (!t->pair_ref || !t->pair_kind || !t->jod || !t->ref_group || !t->ref_names || !t->group_split ||
        !t->group_names)
        return nqm_fail_nomem(err, 16 * c->n_tests);
    if (!t->manifest)
        return nqm_fail(err, NQM_ERR_ARG, -1, "manifest: a name is not UTF-8, or memory is short");
    return NQM_OK;
}

static void free_tables(tables *t) {
    nqm_free(t->pair_ref);
    nqm_free(t->pair_kind);
    nqm_free(t->jod);
    nqm_free(t->ref_group);
    nqm_free(t->ref_names);
    nqm_free(t->group_split);
    nqm_free(t->group_names);
    nqm_free(t->manifest);
    nqm_free(t->manifest_path);
}

/* Number the kinds that occur. */
static void fill_kinds(const corpus *c, tables *t, uint32_t index[NQM_KIND_COUNT]) {
    bool occurs[NQM_KIND_COUNT] = {false};
    for (size_t i = 0; i < c->n_items; ++i)
        for (size_t k = 0; k < c->items[i].plan.n_tests; ++k)
            occurs[c->items[i].plan.tests[k].kind] = true;
    for (int k = 0; k < NQM_KIND_COUNT; ++k) {
        index[k] = (uint32_t)t->n_kinds;
        if (occurs[k])
            t->kind_names[t->n_kinds++] = nqm_corpus_kind_name((nqm_corpus_kind)k);
    }
}

static void fill_tables(const corpus *c, tables *t) {
    nqm_curve curve = nqm_curve_default();
    size_t ref = 0, pair = 0;
    uint32_t kind_index[NQM_KIND_COUNT];
    fill_kinds(c, t, kind_index);
    for (size_t i = 0; i < c->n_items; ++i) {
        const nqm_corpus_plan *plan = &c->items[i].plan;
        const nqm_corpus_group *group = &c->list.groups[plan->group];
        t->group_names[i] = group->name;
        t->group_split[i] = (uint8_t)group->split;
        for (size_t k = 0; k < plan->n_tests; ++k, ++pair) {
            t->pair_ref[pair] = (uint32_t)(ref + plan->tests[k].ref);
            t->pair_kind[pair] = kind_index[plan->tests[k].kind];
            t->jod[pair] = nqm_curve_jod(&curve, c->delta_e[pair]);
        }
        for (size_t r = 0; r < plan->n_refs; ++r, ++ref) {
            t->ref_names[ref] = c->list.refs[group->first_ref + r].name;
            t->ref_group[ref] = (uint32_t)i;
        }
    }
}

static nqm_status write_manifest(const char *path, tables *t, nqm_error *err) {
    size_t n = strlen(path) + 8;
    t->manifest_path = nqm_alloc(n, 1);
    if (!t->manifest_path)
        return nqm_fail_nomem(err, n);
    snprintf(t->manifest_path, n, "%s.json", path);
    nqm_outfile out = {0};
    nqm_status status = nqm_outfile_open(t->manifest_path, &out, err);
    if (status != NQM_OK)
        return status;
    fprintf(out.stream, "%s\n", t->manifest);
    return nqm_outfile_commit(&out, err);
}

static nqm_status write_dataset(const corpus *c, const char *path, nqm_error *err) {
    tables t = {0};
    nqm_status status = alloc_tables(c, &t, err);
    if (status == NQM_OK) {
        fill_tables(c, &t);
        nqm_dataset dataset = {
            .n_directions = c->n_directions,
            .n_refs = c->n_refs,
            .n_groups = c->n_items,
            .n_kinds = t.n_kinds,
            .n_pairs = c->n_tests,
            .directions_deg = nqm_directions_degrees(c->context.directions),
            .ref_rgb = c->ref_rgb,
            .test_rgb = c->test_rgb,
            .ref_used = c->ref_used,
            .test_used = c->test_used,
            .pair_ref = t.pair_ref,
            .pair_kind = t.pair_kind,
            .delta_e = c->delta_e,
            .jod = t.jod,
            .ref_group = t.ref_group,
            .group_split = t.group_split,
            .ref_names = t.ref_names,
            .group_names = t.group_names,
            .kind_names = t.kind_names,
            .pair_names = (const char *const *)c->names,
            .manifest = t.manifest,
        };
        status = nqm_dataset_write(&dataset, path, NULL, err);
    }
    if (status == NQM_OK)
        status = write_manifest(path, &t, err);
    free_tables(&t);
    return status;
}

static void free_corpus(corpus *c) {
    for (size_t t = 0; c->names && t < c->n_tests; ++t)
        nqm_free(c->names[t]);
    for (size_t i = 0; i < c->n_items; ++i)
        nqm_corpus_plan_free(&c->items[i].plan);
    nqm_free(c->names);
    nqm_free(c->items);
    nqm_free(c->ref_rgb);
    nqm_free(c->ref_used);
    nqm_free(c->test_rgb);
    nqm_free(c->test_used);
    nqm_free(c->delta_e);
    nqm_scene_free(c->scene);
    nqm_corpus_list_free(&c->list);
}

static nqm_status make_folder(const char *folder, nqm_error *err) {
    struct stat st;
    if (!folder || mkdir(folder, 0777) == 0 || (stat(folder, &st) == 0 && S_ISDIR(st.st_mode)))
        return NQM_OK;
    return nqm_fail(err, NQM_ERR_IO, -1, "%s: cannot be made a folder for finished work", folder);
}

nqm_status nqm_corpus_build(const char *materials_csv, const nqm_directions *directions,
                            const nqm_corpus_options *options_or_null, const char *path, nqm_error *err) {
    nqm_corpus_options options = options_or_null ? *options_or_null : nqm_corpus_options_default();
    corpus c = {.n_directions = nqm_directions_count(directions),
                .ticker = {.fn = options.progress, .user = options.progress_user}};
    c.context.options = &options;
    c.context.directions = directions;
    c.context.list = &c.list;
    nqm_status status = make_folder(options.checkpoint, err);
    if (status == NQM_OK)
        status = nqm_corpus_list_load(materials_csv, options.root, &c.list, err);
    if (status == NQM_OK)
        status = make_plans(&c, materials_csv, err);
    if (status == NQM_OK)
        status = make_arrays(&c, err);
    if (status == NQM_OK)
        status = make_scene(&c, err);
    if (status == NQM_OK)
        status = work(&c, err);
    if (status == NQM_OK)
        status = write_dataset(&c, path, err);
    free_corpus(&c);
    return status;
}
