/* SPDX-License-Identifier: MIT
 *
 * Datasets of pairs: labels are those of single pairs, pairs that fail are named, fits are shared, interrupted work
 * continues, other files in the work folder are not used.
 */
#include "corpus/corpus.h"
#include "data/data.h"
#include "fit/fit.h"
#include "label/label.h"
#include "metric/metric.h"
#include "support/check.h"
#include "support/scenes.h"
#include "support/scratch.h"

#include <dirent.h>
#include <jansson.h>
#include <nqm/train.h>

#define REF "ggx:kd=0.2;alpha=0.2"

static const nqm_corpus_pair pairs[] = {
    {.reference = REF, .test = "fit:model=ward;samples=500;of=" REF, .name = "a", .kind = "ward", .family = "encoding"},
    {.reference = REF, .test = "perturb:scale=1.5;of=fit:model=ward;samples=500;of=" REF, .name = "a", .kind = "refit"},
    {.reference = REF, .test = "perturb:scale=1.5;of=" REF, .name = "a", .kind = "scale"},
    {.reference = REF, .test = "between:t=0.5;with=(sgd:brass);of=" REF, .name = "a", .kind = "between", .other = "b"},
    {.reference = REF, .test = "sgd:brass", .name = "a", .kind = "other", .other = "b"},
    {.reference = REF, .test = "missing.bsdf", .name = "a", .kind = "form"},
    {.reference = REF, .test = "fit:model=nothing;of=" REF, .name = "a", .kind = "ward", .family = "encoding"},
    {.reference = "sgd:brass", .test = "perturb:gloss=0.5;of=sgd:brass", .name = "b", .kind = "gloss"},
    {.reference = "sgd:brass", .test = "sgd:brass", .name = "b", .kind = "same"},
    {.reference = "sgd:gold", .test = "x", .name = "c", .split = NQM_SPLIT_TEST},
};
enum { N_PAIRS = sizeof pairs / sizeof *pairs, N_TRAINING = N_PAIRS - 1, N_GOOD = N_TRAINING - 2 };

static nqm_directions *directions(void) {
    nqm_directions *made;
    nqm_directions_options options = nqm_directions_options_default();
    options.n = 50;
    assert_int_equal(nqm_directions_create(&options, 0, NULL, &made, NULL), NQM_OK);
    return made;
}

static nqm_corpus_options small_scene(void) {
    nqm_corpus_options options = nqm_corpus_options_default();
    options.scene.n_points = 64;
    options.scene.n_lights = 64;
    options.scene.light = "studio";
    return options;
}

static nqm_status try_build(const nqm_corpus_options *options, const char *name, nqm_error *err) {
    nqm_directions *d = directions();
    const nqm_status status = nqm_corpus_build(N_PAIRS, pairs, d, options, scratch_path(name), err);
    nqm_directions_free(d);
    return status;
}

static nqm_dataset *build(const nqm_corpus_options *options, const char *name) {
    nqm_error err = {0};
    nqm_dataset *dataset = NULL;
    if (try_build(options, name, &err) != NQM_OK ||
        nqm_dataset_load(scratch_path(name), NULL, NQM_SPLIT_ALL, &dataset, &err) != NQM_OK)
        fail_msg("%s", err.message);
    return dataset;
}

static double label_of(const nqm_scene *scene, const char *ref, const char *test) {
    double *picture[2];
    const char *arguments[] = {ref, test};
    for (size_t i = 0; i < 2; ++i) {
        nqm_brdf *brdf;
        picture[i] = nqm_alloc(9 * nqm_scene_get_info(scene).n_points, sizeof **picture);
        assert_int_equal(nqm_fit_open(arguments[i], NULL, &brdf, NULL), NQM_OK);
        assert_int_equal(nqm_scene_render(scene, brdf, 1, picture[i], NULL, NULL), NQM_OK);
        nqm_brdf_free(brdf);
    }
    const nqm_label label = nqm_scene_compare_halves(scene, picture[0], picture[1]);
    nqm_free(picture[0]);
    nqm_free(picture[1]);
    return label.delta_e;
}

TEST(labels_are_those_of_single_pairs) {
    const nqm_corpus_options options = small_scene();
    nqm_dataset *d = build(&options, "training.safetensors");
    const nqm_dataset_info info = nqm_dataset_get_info(d);
    assert_int_equal(info.n_refs, 2);
    assert_int_equal(info.n_pairs, N_GOOD);
    nqm_scene *scene = make_scene(&options.scene);
    for (size_t i = 0, row = 0; i < N_TRAINING; ++i) {
        if (strstr(pairs[i].test, "missing") || strstr(pairs[i].test, "nothing"))
            continue;
        assert_near(d->delta_e[row], label_of(scene, pairs[i].reference, pairs[i].test), 0);
        assert_string_equal(nqm_name(&d->ref_names, d->pair_ref[row]), pairs[i].name);
        assert_string_equal(nqm_name(&d->kind_names, d->pair_kind[row]), pairs[i].kind);
        const char *name = nqm_name(&d->pair_names, row);
        if (i == 0)
            assert_true(strncmp(name, "ward:kd=", 8) == 0); /* the result of a fit */
        else
            assert_string_equal(name, pairs[i].test);
        ++row;
    }
    assert_near(d->delta_e[N_GOOD - 1], 0, 0);
    nqm_scene_free(scene);
    nqm_dataset_free(d);
}

/* Samples have one azimuth: such pairs must be wanted, and no model is made of, or judged by, their samples. */
TEST(anisotropic_pairs_are_labelled_when_wanted) {
    const nqm_corpus_pair some[] = {{.reference = REF, .test = "sgd:brass"},
                                    {.reference = REF, .test = "ggx:kd=0.2;alpha=0.2,0.21"},
                                    {.reference = "rotate:deg=30;of=ggx:alpha=0.1,0.4", .test = REF}};
    nqm_train_options train;
    nqm_corpus_options options = small_scene();
    nqm_directions *at = directions();
    nqm_model *model, *trained;
    assert_int_equal(nqm_train_options_recipe("nqm", &train, NULL), NQM_OK);
    assert_int_equal(nqm_model_builtin("default", &model, NULL), NQM_OK);
    for (int i = 0; i < 2; ++i) {
        nqm_dataset *d;
        nqm_prediction to[3];
        nqm_error err = {0};
        options.anisotropic = i;
        assert_int_equal(nqm_corpus_build(3, some, at, &options, scratch_path("some.safetensors"), NULL), NQM_OK);
        assert_int_equal(nqm_dataset_load(scratch_path("some.safetensors"), NULL, NQM_SPLIT_ALL, &d, NULL), NQM_OK);
        assert_int_equal(nqm_dataset_get_info(d).n_pairs, i ? 3 : 1);
        assert_int_equal(strstr(nqm_dataset_get_info(d).manifest, "azimuth") != NULL, !i); /* failures */
        const nqm_dataset_prediction p = {.dataset = d, .model = model, .n = 1, .pairs = (size_t[]){0}, .to = to};
        assert_int_equal(nqm_dataset_predict(&p, &err), NQM_ERR_INCOMPATIBLE);
        assert_int_equal(strstr(err.message, "azimuth") != NULL, i); /* the directions are not those of the model */
        if (i)
            assert_int_equal(nqm_train(d, &train, &trained, NULL, NULL), NQM_ERR_INCOMPATIBLE);
        nqm_dataset_free(d);
    }
    nqm_model_free(model);
    nqm_directions_free(at);
}

TEST(the_manifest_names_failures_and_others) {
    const nqm_corpus_options options = small_scene();
    nqm_dataset *d = build(&options, "training.safetensors");
    json_t *m = json_loads(nqm_dataset_get_info(d).manifest, 0, NULL), *row;
    assert_non_null(m);
    row = json_object_get(json_object_get(m, "failures"), "form");
    assert_int_equal(json_integer_value(json_object_get(row, "pairs")), 1);
    assert_non_null(strstr(json_string_value(json_object_get(row, "message")), "missing.bsdf"));
    row = json_array_get(json_object_get(row, "tests"), 0);
    assert_string_equal(json_string_value(json_array_get(row, 0)), "a");
    assert_string_equal(json_string_value(json_array_get(row, 1)), "missing.bsdf");
    row = json_object_get(json_object_get(json_object_get(m, "other_materials"), "train"), "b");
    assert_int_equal(json_integer_value(row), 2);
    assert_string_equal(json_string_value(json_array_get(json_object_get(m, "unseen_kinds"), 0)), "pair");
    assert_int_equal(json_array_size(json_object_get(m, "references")), 2);
    row = json_object_get(json_object_get(m, "kinds"), "ward");
    assert_int_equal(json_integer_value(json_object_get(row, "pairs")), 1);
    json_decref(m);
    nqm_dataset_free(d);
}

TEST(a_family_is_thinned) {
    nqm_corpus_options options = small_scene();
    options.keep = "encoding=1"; /* the other one has failed */
    nqm_dataset *d = build(&options, "kept.safetensors");
    assert_int_equal(nqm_dataset_get_info(d).n_pairs, N_GOOD);
    nqm_dataset_free(d);
    options.keep = "encoding";
    assert_int_equal(try_build(&options, "kept.safetensors", NULL), NQM_ERR_ARG);
}

TEST(a_list_without_labels_is_refused) {
    nqm_corpus_options options = small_scene();
    nqm_error err = {0};
    options.part = NQM_CORPUS_TEST;
    assert_int_equal(try_build(&options, "none.safetensors", &err), NQM_ERR_INCOMPATIBLE);
    assert_non_null(strstr(err.message, "no pair could be labelled"));
    assert_int_not_equal(access(scratch_path("none.safetensors"), F_OK), 0);
}

/* ---- interruption ------------------------------------------------------------------------------------------------ */

static size_t count_files(const char *folder) {
    DIR *dir = opendir(folder);
    size_t n = 0;
    for (struct dirent *entry; dir && (entry = readdir(dir)) != NULL;)
        n += entry->d_name[0] != '.';
    if (dir)
        closedir(dir);
    return n;
}

/* At the first report: the next is a fifth of a second later, when the work may be finished. */
static int stop_soon(void *user, const char *stage, double done, double total) {
    (void)user, (void)done, (void)total;
    return strcmp(stage, "corpus") == 0;
}

TEST(an_interrupted_corpus_goes_on) {
    char work[256], sha256[65];
    snprintf(work, sizeof work, "%s", scratch_path("work"));
    nqm_corpus_options options = small_scene();
    nqm_dataset *whole = build(&options, "whole.safetensors");
    snprintf(sha256, sizeof sha256, "%s", nqm_dataset_get_info(whole).sha256);
    nqm_dataset_free(whole);
    options.checkpoint = work;
    options.progress = stop_soon;
    assert_int_equal(try_build(&options, "never.safetensors", NULL), NQM_ERR_CANCELLED);
    assert_int_not_equal(access(scratch_path("never.safetensors"), F_OK), 0);
    options.progress = NULL;
    for (int round = 0; round < 2; ++round) { /* the second round reads all units from the work files */
        nqm_dataset *resumed = build(&options, "resumed.safetensors");
        assert_string_equal(nqm_dataset_get_info(resumed).sha256, sha256);
        nqm_dataset_free(resumed);
        assert_int_equal(count_files(work), 2);
    }
    remove_folder(work);
}

/* A unit of which the first rows are made, saved and loaded. */
typedef struct making {
    nqm_corpus corpus;
    nqm_corpus_options options;
    nqm_directions *directions;
    nqm_corpus_unit unit;
    size_t n_done, stop, resumed; /* resumed: rows of the first call */
} making;

static bool count_rows(void *user, size_t n) {
    making *m = user;
    if (m->resumed == SIZE_MAX)
        m->resumed = n;
    m->n_done += n;
    return m->n_done >= m->stop;
}

static void begin_making(making *m, const char *path, size_t stop) {
    *m = (making){.options = small_scene(), .directions = directions(), .stop = stop, .resumed = SIZE_MAX};
    m->corpus = (nqm_corpus){.options = &m->options,
                             .directions = m->directions,
                             .n_directions = 50,
                             .scene = make_scene(&m->options.scene),
                             .step = count_rows,
                             .step_user = m};
    assert_int_equal(nqm_corpus_list_make(N_PAIRS, pairs, &m->options, &m->corpus.list, NULL), NQM_OK);
    assert_int_equal(nqm_corpus_cache_create(m->corpus.list.n_refs, &m->corpus.cache, NULL), NQM_OK);
    nqm_corpus_unit *u = &m->unit;
    u->n_rows = m->corpus.list.refs[0].n_rows;
    u->path = (char *)(uintptr_t)path;
    assert_int_equal(
        nqm_alloc_arrays(NQM_ARRAYS({&u->ref_rgb, 50, 3 * sizeof(float)}, {&u->ref_used, 50, 1},
                                    {&u->test_rgb, u->n_rows * 50, 3 * sizeof(float)},
                                    {&u->test_used, u->n_rows * 50, 1}, {&u->label, u->n_rows, sizeof *u->label},
                                    {&u->names, u->n_rows, sizeof *u->names},
                                    {&u->failures, u->n_rows, sizeof *u->failures}),
                         NULL),
        NQM_OK);
}

static void end_making(making *m) {
    for (size_t t = 0; t < m->unit.n_rows; ++t) {
        nqm_free(m->unit.names[t]);
        nqm_free(m->unit.failures[t]);
    }
    nqm_free(m->unit.ref_rgb);
    nqm_corpus_cache_free(m->corpus.cache);
    nqm_scene_free(m->corpus.scene);
    nqm_corpus_list_free(&m->corpus.list);
    nqm_directions_free(m->directions);
}

TEST(an_interrupted_unit_goes_on_where_it_stopped) {
    char path[256], progress[280];
    snprintf(path, sizeof path, "%s", scratch_path("unit.safetensors"));
    snprintf(progress, sizeof progress, "%s.progress", path);
    making whole, parts;
    begin_making(&whole, NULL, SIZE_MAX);
    assert_int_equal(nqm_corpus_unit_make(&whole.corpus, &whole.unit, NULL), NQM_OK);
    const size_t n = whole.unit.n_rows;
    assert_int_equal(n, N_TRAINING - 2);
    assert_int_equal(whole.n_done, n);
    for (size_t done = 0; done < n; done += 3) {
        begin_making(&parts, path, done + 3);
        assert_int_equal(nqm_corpus_unit_make(&parts.corpus, &parts.unit, NULL),
                         done + 3 < n ? NQM_ERR_CANCELLED : NQM_OK);
        assert_int_equal(parts.resumed, done);
        if (done + 3 < n) {
            assert_int_equal(access(progress, F_OK), 0);
            end_making(&parts);
        }
    }
    const nqm_corpus_unit *a = &whole.unit, *b = &parts.unit;
    assert_memory_equal(a->test_rgb, b->test_rgb, n * 50 * 3 * sizeof(float));
    assert_memory_equal(a->test_used, b->test_used, n * 50);
    assert_memory_equal(a->ref_rgb, b->ref_rgb, (size_t)50 * 3 * sizeof(float));
    assert_memory_equal(a->label, b->label, n * sizeof *a->label);
    for (size_t t = 0; t < n; ++t) {
        assert_string_equal(a->names[t], b->names[t]);
        assert_string_equal(a->failures[t] ? a->failures[t] : "", b->failures[t] ? b->failures[t] : "");
    }
    assert_int_equal(nqm_corpus_unit_save(50, b, n, NULL), NQM_OK);
    assert_int_not_equal(access(progress, F_OK), 0); /* the finished unit replaces it */
    end_making(&parts);
    begin_making(&parts, path, SIZE_MAX);
    assert_true(nqm_corpus_unit_load(50, &parts.unit));
    assert_memory_equal(a->label, b->label, n * sizeof *a->label);
    assert_string_equal(a->names[1], b->names[1]);
    remove(path);
    end_making(&whole);
    end_making(&parts);
}

TEST(fits_are_shared) {
    making m;
    begin_making(&m, NULL, SIZE_MAX);
    nqm_corpus_fits fits = {0};
    nqm_brdf *brdf[2];
    bool is_lent;
    for (size_t i = 0; i < 2; ++i) {
        assert_int_equal(nqm_corpus_open(&m.corpus, &fits, pairs[0].test, &brdf[i], &is_lent, NULL), NQM_OK);
        assert_true(is_lent);
    }
    assert_ptr_equal(brdf[0], brdf[1]);
    assert_int_equal(fits.n, 1);
    assert_int_equal(nqm_corpus_open(&m.corpus, &fits, pairs[1].test, &brdf[1], &is_lent, NULL), NQM_OK);
    assert_false(is_lent);
    assert_int_equal(fits.n, 1);
    nqm_brdf_free(brdf[1]);
    assert_int_equal(nqm_corpus_open(&m.corpus, &fits, "sgd:brass", &brdf[1], &is_lent, NULL), NQM_OK);
    assert_true(is_lent);            /* a reference of the list */
    for (size_t i = 0; i < 2; ++i) { /* the failure too */
        nqm_error err = {0};
        assert_int_equal(nqm_corpus_open(&m.corpus, &fits, pairs[6].test, &brdf[0], &is_lent, &err), NQM_ERR_ARG);
        assert_non_null(strstr(err.message, "nothing"));
    }
    assert_int_equal(fits.n, 2);
    nqm_corpus_fits_free(&fits);
    end_making(&m);
}
