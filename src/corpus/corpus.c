/* SPDX-License-Identifier: MIT
 *
 * Making a corpus: cut the list of pairs into units of work, label them (run.c), and write one dataset file with its manifest
 * (dataset.c). doc/corpus.md is for users.
 */
#include "corpus/corpus.h"
#include "base/os.h"
#include "encode/encode.h"

#include <string.h>

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
    {FIELD(keep), .kind = NQM_OPTION_TEXT, .metavar = "FAMILY=N",
     .help = "of a family, at most N pairs per reference: those whose JODs are spread most evenly"},
    {FIELD(anisotropic), .kind = NQM_OPTION_BOOL, .help = "anisotropic pairs too: a dataset for the model 'anisotropic'"},
};
/* clang-format on */

const nqm_option_table nqm_corpus_option_table = {rows, sizeof rows / sizeof *rows, NULL};

NQM_OPTIONS_DEFAULT(nqm_corpus_option, .scene = nqm_scene_options_default())

/* ---- preparation ------------------------------------------------------------------------------------------------- */

static bool is_mesh(const char *shape) {
    return shape && strcmp(shape, "sphere") != 0 && strcmp(shape, "blob") != 0;
}

/* The scene is made before the units; later its pictures are made on many threads, and the corpus reports its own progress. */
static int scene_progress(void *user, const char *stage, double done, double total) {
    const nqm_corpus *corpus = user;
    const nqm_corpus_options *options = corpus->options;
    if (corpus->step)
        return corpus->step(corpus->step_user, 0);
    return options->progress ? options->progress(options->progress_user, stage, done, total) : 0;
}

static nqm_status make_scene(nqm_corpus *c, nqm_error *err) {
    nqm_scene_options scene = c->options->scene;
    nqm_status status = NQM_OK;
    scene.progress = scene_progress;
    scene.progress_user = c;
    if (scene.light && !nqm_light_is_builtin(scene.light))
        status = nqm_corpus_hash_file(scene.light, NULL, c->light_sha256, err);
    if (status == NQM_OK && is_mesh(scene.shape))
        status = nqm_corpus_hash_file(scene.shape, NULL, c->shape_sha256, err);
    if (status == NQM_OK)
        status = nqm_scene_create(&scene, &c->scene, err);
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
        nqm_sha256_end(&sha, c->encoder_sha256[k]);
    }
    return NQM_OK;
}

/* Cut the rows of each reference into units. */
static nqm_status make_units(nqm_corpus *c, nqm_error *err) {
    const nqm_corpus_list *list = &c->list;
    size_t n = 0;
    for (size_t r = 0; r < list->n_refs; ++r)
        n += (list->refs[r].n_rows + NQM_CORPUS_UNIT_ROWS - 1) / NQM_CORPUS_UNIT_ROWS;
    c->units = nqm_alloc(n, sizeof *c->units);
    if (!c->units)
        return nqm_fail_nomem(err, n * sizeof *c->units);
    for (size_t r = 0; r < list->n_refs; ++r)
        for (size_t at = 0; at < list->refs[r].n_rows; at += NQM_CORPUS_UNIT_ROWS)
            c->units[c->n_units++] =
                (nqm_corpus_unit){.ref = r,
                                  .first_row = list->refs[r].first_row + at,
                                  .n_rows = nqm_smaller(list->refs[r].n_rows - at, NQM_CORPUS_UNIT_ROWS)};
    return NQM_OK;
}

static nqm_status make_arrays(nqm_corpus *c, nqm_error *err) {
    const size_t n = c->n_directions, n_units = c->n_units, n_rows = c->list.n_rows;
    nqm_status status =
        nqm_alloc_arrays(NQM_ARRAYS({&c->ref_rgb, n_units * n, 3 * sizeof(float)}, {&c->ref_used, n_units * n, 1},
                                    {&c->test_rgb, n_rows * n, 3 * sizeof(float)}, {&c->test_used, n_rows * n, 1},
                                    {&c->label, n_rows, sizeof *c->label}, {&c->names, n_rows, sizeof *c->names},
                                    {&c->failures, n_rows, sizeof *c->failures}, {&c->kept, n_rows, 1}),
                         err);
    for (size_t i = 0; status == NQM_OK && i < n_units; ++i) {
        nqm_corpus_unit *unit = &c->units[i];
        const size_t row = unit->first_row;
        unit->ref_rgb = c->ref_rgb + 3 * n * i;
        unit->ref_used = c->ref_used + n * i;
        unit->test_rgb = c->test_rgb + 3 * n * row;
        unit->test_used = c->test_used + n * row;
        unit->label = c->label + row;
        unit->names = c->names + row;
        unit->failures = c->failures + row;
    }
    return status;
}

static nqm_status make_paths(nqm_corpus *c, nqm_error *err) {
    nqm_status status = NQM_OK;
    for (size_t i = 0; status == NQM_OK && c->options->checkpoint && i < c->n_units; ++i)
        status = nqm_corpus_unit_path(c, &c->units[i], &c->units[i].path, err);
    return status;
}

static void free_corpus(nqm_corpus *c) {
    for (size_t t = 0; c->ref_rgb && t < c->list.n_rows; ++t) {
        nqm_free(c->names[t]);
        nqm_free(c->failures[t]);
    }
    for (size_t i = 0; i < c->n_units; ++i)
        nqm_free(c->units[i].path);
    nqm_free(c->units);
    nqm_free(c->ref_rgb);
    nqm_corpus_cache_free(c->cache);
    nqm_scene_free(c->scene);
    nqm_corpus_list_free(&c->list);
}

/* ---- entry ------------------------------------------------------------------------------------------------------- */

static nqm_status ensure_folder(const char *folder, nqm_error *err) {
    if (!folder || nqm_os_make_folder(folder) || nqm_os_is_folder(folder))
        return NQM_OK;
    return nqm_fail(err, NQM_ERR_IO, -1, "%s: cannot create this folder for finished work", folder);
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

static nqm_status prepare(nqm_corpus *c, size_t n, const nqm_corpus_pair *pairs, nqm_error *err) {
    const nqm_corpus_options *options = c->options;
    nqm_status status = nqm_corpus_list_make(n, pairs, options, &c->list, err);
    if (status == NQM_OK)
        status = nqm_corpus_hash_refs(&c->list, err);
    if (status == NQM_OK)
        status = nqm_corpus_cache_create(c->list.n_refs, &c->cache, err);
    if (status == NQM_OK)
        status = make_units(c, err);
    if (status == NQM_OK)
        status = make_arrays(c, err);
    if (status == NQM_OK)
        status = make_scene(c, err);
    if (status == NQM_OK)
        status = hash_encoders(c, err);
    return status == NQM_OK ? make_paths(c, err) : status;
}

nqm_status nqm_corpus_build(size_t n, const nqm_corpus_pair *pairs, const nqm_directions *directions,
                            const nqm_corpus_options *options_or_null, const char *path, nqm_error *err) {
    NQM_REQUIRE(err, pairs, directions, path);
    nqm_corpus_options options = options_or_null ? *options_or_null : nqm_corpus_options_default();
    nqm_corpus c = {
        .options = &options, .directions = directions, .n_directions = nqm_directions_get_info(directions).n};
    nqm_status status = nqm_options_check(&nqm_corpus_option_table, &options, err);
    if (status == NQM_OK)
        status = nqm_corpus_parse_keep(options.keep, &c.n_keep_name, &c.n_keep, err);
    if (status == NQM_OK)
        status = check_output(&options, path, err);
    if (status == NQM_OK)
        status = ensure_folder(options.checkpoint, err);
    if (status == NQM_OK)
        status = prepare(&c, n, pairs, err);
    if (status == NQM_OK)
        status = nqm_corpus_run(&c, err);
    if (status == NQM_OK && !options.work_only)
        status = nqm_corpus_select(&c, err);
    if (status == NQM_OK && !options.work_only)
        status = nqm_corpus_write(&c, path, err);
    free_corpus(&c);
    return status;
}
