/* SPDX-License-Identifier: MIT
 *
 * Making a corpus: plan every material group, make the groups (run.c), and write one dataset file with its manifest
 * (dataset.c). doc/corpus.md explains the content of a corpus.
 */
#include "corpus/corpus.h"
#include "encode/encode.h"

#include <string.h>
#include <sys/stat.h>

const char *const nqm_corpus_encoders[2] = {"sparse", "hyper"};

/* ---- options ----------------------------------------------------------------------------------------------------- */

#define FIELD(name) .key = #name, .offset = offsetof(nqm_corpus_options, name)

static const char *const part_words[] = {"train,validation", "test", NULL};

/* clang-format off */
static const nqm_option rows[] = {
    {FIELD(part), .name = "only", .kind = NQM_OPTION_ENUM, .metavar = "SPLITS", .words = part_words,
     .values = {"train,validation"}, .help = "splits in the dataset"},
    {FIELD(root), .kind = NQM_OPTION_TEXT, .metavar = "DIR", .help = "folder of relative paths (default: the list's folder)"},
    {FIELD(checkpoint), .name = "work", .kind = NQM_OPTION_TEXT, .metavar = "DIR",
     .help = "folder for finished work: a later run continues from it, and processes share it"},
    {FIELD(work_only), .name = "", .kind = NQM_OPTION_BOOL},
    {FIELD(models), .kind = NQM_OPTION_TEXT, .metavar = "NAMES",
     .help = "models of `nqm fit` that encode the references, separated by commas (default: all)"},
    {FIELD(n_perturbations), .name = "perturbations", .kind = NQM_OPTION_SIZE, .metavar = "N", .min = 0, .max = 1000,
     .values = {"26"}, .help = "perturbed copies per reference"},
    {FIELD(n_far), .name = "far", .kind = NQM_OPTION_SIZE, .metavar = "N", .min = 0, .max = 1000, .values = {"26"},
     .help = "tests per reference that really differ from it"},
    {FIELD(n_roundings), .name = "roundings", .kind = NQM_OPTION_SIZE, .metavar = "N", .min = 0, .max = 1000,
     .values = {"3"}, .help = "copies per reference with rounded values"},
    {FIELD(n_variants), .name = "variants", .kind = NQM_OPTION_SIZE, .metavar = "N", .min = 0, .max = 1000,
     .values = {"8"}, .help = "changed specs, translations, tables and overfitted networks per reference"},
    {FIELD(every), .kind = NQM_OPTION_SIZE, .metavar = "N", .min = 1, .max = 1000, .values = {"1"},
     .help = "keep one in N tests: a small corpus of the same composition"},
    {FIELD(seed), .kind = NQM_OPTION_U64, .metavar = "N", .values = {"1"}, .help = "seed of perturbations and fits"},
};
/* clang-format on */

const nqm_option_table nqm_corpus_option_table = {rows, sizeof rows / sizeof *rows, NULL};

nqm_corpus_options nqm_corpus_options_default(void) {
    nqm_corpus_options options = {.scene = nqm_scene_options_default()};
    (void)!nqm_options_begin(&nqm_corpus_option_table, NULL, &options, NULL); /* cannot fail without a recipe */
    return options;
}

/* ---- preparation ------------------------------------------------------------------------------------------------- */

static bool is_mesh(const char *shape) {
    return shape && strcmp(shape, "sphere") != 0 && strcmp(shape, "blob") != 0;
}

/* The scene is made before the groups; later its pictures are made on many threads, and the corpus reports its own progress. */
static int scene_progress(void *user, const char *stage, double done, double total) {
    const nqm_corpus_context *context = user;
    const nqm_corpus_options *options = context->options;
    if (context->step)
        return context->step(context->step_user, 0);
    return options->progress ? options->progress(options->progress_user, stage, done, total) : 0;
}

static nqm_status make_scene(nqm_corpus *c, nqm_error *err) {
    nqm_scene_options scene = c->context.options->scene;
    nqm_status status = NQM_OK;
    scene.progress = scene_progress;
    scene.progress_user = &c->context;
    if (scene.light && !nqm_light_is_builtin(scene.light))
        status = nqm_corpus_hash_file(scene.light, NULL, c->context.light_sha256, err);
    if (status == NQM_OK && is_mesh(scene.shape))
        status = nqm_corpus_hash_file(scene.shape, NULL, c->context.shape_sha256, err);
    if (status == NQM_OK)
        status = nqm_scene_create(&scene, &c->scene, err);
    c->context.scene = c->scene;
    return status;
}

static nqm_status hash_encoders(nqm_corpus *c, nqm_error *err) {
    for (size_t k = 0; k < 2; ++k) {
        size_t n_bytes;
        const unsigned char *bytes = nqm_encoder_bytes(nqm_corpus_encoders[k], &n_bytes);
        nqm_sha256 sha;
        if (!bytes)
            continue;
        if (!nqm_sha256_begin(&sha))
            return nqm_fail_nomem(err, sizeof sha);
        nqm_sha256_add(&sha, bytes, n_bytes);
        nqm_sha256_end(&sha, c->context.encoder_sha256[k]);
    }
    return NQM_OK;
}

static nqm_status make_plans(nqm_corpus *c, const char *materials_csv, nqm_error *err) {
    const nqm_corpus_options *options = c->context.options;
    c->items = nqm_alloc(c->list.n_groups, sizeof *c->items);
    if (!c->items)
        return nqm_fail_nomem(err, c->list.n_groups * sizeof *c->items);
    for (size_t g = 0; g < c->list.n_groups; ++g) {
        if (!nqm_corpus_in_part(&c->list.groups[g], options->part))
            continue;
        nqm_corpus_item *item = &c->items[c->n_items];
        nqm_status status = nqm_corpus_plan_make(&c->list, g, &c->context.models, options, &item->plan, err);
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

static nqm_status make_arrays(nqm_corpus *c, nqm_error *err) {
    size_t n = c->n_directions, n_refs = c->n_refs, n_tests = c->n_tests;
    nqm_status status =
        nqm_alloc_arrays(NQM_ARRAYS({&c->ref_rgb, n_refs * n, 3 * sizeof(float)}, {&c->ref_used, n_refs * n, 1},
                                    {&c->test_rgb, n_tests * n, 3 * sizeof(float)}, {&c->test_used, n_tests * n, 1},
                                    {&c->label, n_tests, sizeof *c->label}, {&c->fit_loss, n_tests, sizeof(double)},
                                    {&c->names, n_tests, sizeof *c->names},
                                    {&c->failures, n_tests, sizeof *c->failures}, {&c->kept, n_tests, 1}),
                         err);
    if (status != NQM_OK)
        return status;
    size_t ref = 0, test = 0;
    for (size_t i = 0; i < c->n_items; ++i) {
        nqm_corpus_item *item = &c->items[i];
        item->ref_rgb = c->ref_rgb + 3 * n * ref;
        item->ref_used = c->ref_used + n * ref;
        item->test_rgb = c->test_rgb + 3 * n * test;
        item->test_used = c->test_used + n * test;
        item->label = c->label + test;
        item->fit_loss = c->fit_loss + test;
        item->kept = c->kept + test;
        item->names = c->names + test;
        item->failures = c->failures + test;
        ref += item->plan.n_refs;
        test += item->plan.n_tests;
    }
    return NQM_OK;
}

static nqm_status make_paths(nqm_corpus *c, nqm_error *err) {
    nqm_status status = NQM_OK;
    for (size_t i = 0; status == NQM_OK && c->context.options->checkpoint && i < c->n_items; ++i)
        status = nqm_corpus_item_path(&c->context, &c->items[i], &c->items[i].path, err);
    return status;
}

static void free_corpus(nqm_corpus *c) {
    for (size_t t = 0; c->names && t < c->n_tests; ++t)
        nqm_free(c->names[t]);
    for (size_t t = 0; c->failures && t < c->n_tests; ++t)
        nqm_free(c->failures[t]);
    for (size_t i = 0; i < c->n_items; ++i) {
        nqm_corpus_plan_free(&c->items[i].plan);
        nqm_free(c->items[i].path);
    }
    nqm_free(c->items);
    nqm_free(c->ref_rgb);
    nqm_corpus_cache_free(c->context.cache);
    nqm_scene_free(c->scene);
    nqm_corpus_list_free(&c->list);
}

/* ---- entry ------------------------------------------------------------------------------------------------------- */

static nqm_status make_folder(const char *folder, nqm_error *err) {
    struct stat st;
    if (!folder || mkdir(folder, 0777) == 0 || (stat(folder, &st) == 0 && S_ISDIR(st.st_mode)))
        return NQM_OK;
    return nqm_fail(err, NQM_ERR_IO, -1, "%s: cannot create this folder for finished groups", folder);
}

/* Detect an output that cannot be written before the work, not after it. */
static nqm_status check_output(const nqm_corpus_options *options, const char *path, nqm_error *err) {
    if (options->work_only)
        return options->checkpoint ? NQM_OK
                                   : nqm_fail(err, NQM_ERR_ARG, -1, "corpus: work_only needs a checkpoint folder");
    nqm_outfile probe = {0};
    nqm_status status = nqm_outfile_open(path, &probe, err);
    nqm_outfile_abort(&probe);
    if (status == NQM_OK)
        status = nqm_corpus_manifest_open(path, &probe, err);
    nqm_outfile_abort(&probe);
    return status;
}

nqm_status nqm_corpus_build(const char *materials_csv, const nqm_directions *directions,
                            const nqm_corpus_options *options_or_null, const char *path, nqm_error *err) {
    NQM_REQUIRE(err, materials_csv, directions, path);
    nqm_corpus_options options = options_or_null ? *options_or_null : nqm_corpus_options_default();
    nqm_corpus c = {.n_directions = nqm_directions_count(directions)};
    c.context.options = &options;
    c.context.directions = directions;
    c.context.list = &c.list;
    nqm_status status = nqm_options_check(&nqm_corpus_option_table, &options, err);
    if (status == NQM_OK)
        status = check_output(&options, path, err);
    if (status == NQM_OK)
        status = nqm_corpus_models_parse(options.models, &c.context.models, err);
    if (status == NQM_OK)
        status = make_folder(options.checkpoint, err);
    if (status == NQM_OK)
        status = nqm_corpus_list_load(materials_csv, options.root, &c.list, err);
    if (status == NQM_OK)
        status = nqm_corpus_cache_create(c.list.n_refs, &c.context.cache, err);
    if (status == NQM_OK)
        status = make_plans(&c, materials_csv, err);
    if (status == NQM_OK)
        status = make_arrays(&c, err);
    if (status == NQM_OK)
        status = make_scene(&c, err);
    if (status == NQM_OK)
        status = hash_encoders(&c, err);
    if (status == NQM_OK)
        status = make_paths(&c, err);
    if (status == NQM_OK)
        status = nqm_corpus_run(&c, err);
    if (status == NQM_OK && !options.work_only)
        status = nqm_corpus_write(&c, path, err);
    free_corpus(&c);
    return status;
}
