/* SPDX-License-Identifier: MIT
 *
 * Work files: one finished group each, from which an interrupted corpus continues. The name of a file is
 * a hash of everything that determines its content (version, options, light, directions, sources, planned tests), so that
 * runs with different options never share a file.
 */
#include "corpus/corpus.h"
#include "io/options_json.h"
#include "percept/percept.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* ---- names ------------------------------------------------------------------------------------------------------- */

static void hash_text(nqm_sha256 *sha, const char *text) {
    nqm_sha256_add(sha, text, strlen(text) + 1);
}

static void hash_u64(nqm_sha256 *sha, uint64_t value) {
    unsigned char bytes[8];
    nqm_store_u64(bytes, value);
    nqm_sha256_add(sha, bytes, sizeof bytes);
}

static void hash_f64(nqm_sha256 *sha, double value) {
    unsigned char bytes[8];
    nqm_store_f64(bytes, value);
    nqm_sha256_add(sha, bytes, sizeof bytes);
}

static void hash_context(nqm_sha256 *sha, const nqm_corpus_context *context) {
    const nqm_scene_options *scene = &context->options->scene;
    hash_text(sha, "nqm corpus work file 5");
    hash_text(sha, nqm_version());
    hash_text(sha, nqm_directions_id(context->directions));
    hash_text(sha, *context->light_sha256 ? context->light_sha256 : scene->light ? scene->light : "");
    hash_text(sha, *context->shape_sha256 ? context->shape_sha256 : scene->shape ? scene->shape : "");
    const uint64_t counts[] = {scene->width,
                               scene->height,
                               scene->n_points,
                               nqm_scene_n_frames(scene),
                               nqm_scene_n_lights(scene),
                               scene->light_width,
                               scene->seed,
                               scene->shadows != 0,
                               scene->interreflection != 0,
                               context->options->seed,
                               context->options->n_far};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; ++i)
        hash_u64(sha, counts[i]);
    hash_f64(sha, scene->turn_rad);
    hash_f64(sha, scene->elevation_rad);
    hash_f64(sha, scene->exposure_cdm2);
    hash_f64(sha, scene->peak_cdm2);
    if (scene->exact)
        hash_text(sha, "exact");
    for (size_t k = 0; k < context->models.n; ++k)
        hash_text(sha, context->models.name[k]);
    for (size_t k = 0; k < 2; ++k)
        hash_text(sha, context->encoder_sha256[k]);
}

/* Hash the content of a form: all parameters of presets and other specs, the checksum of files. */
static nqm_status hash_form(nqm_sha256 *sha, const nqm_corpus_form *form, const char *file_sha256, nqm_error *err) {
    hash_text(sha, form->brdf);
    hash_text(sha, form->kind.name);
    hash_text(sha, file_sha256);
    if (*file_sha256)
        return NQM_OK;
    nqm_brdf *brdf;
    nqm_status status = nqm_brdf_open(form->path, &brdf, err);
    if (status != NQM_OK)
        return status;
    const char *spec = nqm_brdf_get_info(brdf).spec;
    hash_text(sha, spec ? spec : "");
    nqm_brdf_free(brdf);
    return NQM_OK;
}

/* Hash what a test is made from, the content of the other material included. */
static nqm_status hash_test(nqm_sha256 *sha, const nqm_corpus_list *list, const nqm_corpus_test *test, nqm_error *err) {
    hash_u64(sha, test->ref);
    hash_u64(sha, test->base);
    hash_text(sha, test->kind.name);
    hash_text(sha, test->perturbation[0]);
    hash_text(sha, test->perturbation[1]);
    hash_text(sha, test->between);
    hash_text(sha, test->spec ? test->spec : "");
    hash_text(sha, test->path.model ? test->path.model : "");
    hash_u64(sha, test->path.loss);
    hash_u64(sha, test->path.n_steps);
    hash_u64(sha, test->path.seed);
    if (!nqm_corpus_uses_other(test)) {
        hash_u64(sha, test->which);
        return NQM_OK;
    }
    const nqm_corpus_ref *other = &list->refs[test->which]; /* its index changes with the list */
    const nqm_corpus_form form = {.brdf = other->brdf, .path = other->path};
    return hash_form(sha, &form, other->file_sha256, err);
}

static nqm_status hash_plan(nqm_sha256 *sha, const nqm_corpus_list *list, const nqm_corpus_plan *plan, nqm_error *err) {
    nqm_status status = NQM_OK;
    size_t first = list->groups[plan->group].first_ref;
    hash_text(sha, list->groups[plan->group].name);
    for (size_t f = 0; status == NQM_OK && f < plan->n_forms; ++f)
        status = hash_form(sha, &plan->forms[f], f < plan->n_refs ? list->refs[first + f].file_sha256 : "", err);
    for (size_t t = 0; status == NQM_OK && t < plan->n_tests; ++t)
        status = hash_test(sha, list, &plan->tests[t], err);
    return status;
}

nqm_status nqm_corpus_item_path(const nqm_corpus_context *context, const nqm_corpus_item *item, char **path_ret,
                                nqm_error *err) {
    const char *folder = context->options->checkpoint;
    size_t n = strlen(folder) + 80;
    *path_ret = NULL;
    nqm_sha256 sha;
    char *path = nqm_alloc(n, 1), hex[65];
    if (!path || !nqm_sha256_begin(&sha)) {
        nqm_free(path);
        return nqm_fail_nomem(err, n);
    }
    hash_context(&sha, context);
    nqm_status status = hash_plan(&sha, context->list, &item->plan, err);
    nqm_sha256_end(&sha, hex);
    if (status != NQM_OK) {
        nqm_free(path);
        return status;
    }
    snprintf(path, n, "%s/%.32s.safetensors", folder, hex);
    *path_ret = path;
    return NQM_OK;
}

/* ---- content ----------------------------------------------------------------------------------------------------- */

enum { N_TENSORS = 7, N_LABEL = 1 + NQM_LABEL_PARTS + 1 };
_Static_assert(sizeof(nqm_label) == N_LABEL * sizeof(double), "labels are stored as rows of numbers");

static void describe(const nqm_corpus_item *item, size_t n, nqm_tensor tensors[N_TENSORS]) {
    size_t n_refs = item->plan.n_refs, n_tests = item->plan.n_tests;
    const nqm_tensor all[N_TENSORS] = {
        {.name = "ref_rgb", .dtype = NQM_F32, .n_dims = 3, .dims = {n_refs, n, 3}, .data = item->ref_rgb},
        {.name = "ref_used", .dtype = NQM_U8, .n_dims = 2, .dims = {n_refs, n}, .data = item->ref_used},
        {.name = "test_rgb", .dtype = NQM_F32, .n_dims = 3, .dims = {n_tests, n, 3}, .data = item->test_rgb},
        {.name = "test_used", .dtype = NQM_U8, .n_dims = 2, .dims = {n_tests, n}, .data = item->test_used},
        {.name = "label", .dtype = NQM_F64, .n_dims = 2, .dims = {n_tests, N_LABEL}, .data = item->label},
        {.name = "fit_loss", .dtype = NQM_F64, .n_dims = 1, .dims = {n_tests}, .data = item->fit_loss},
        {.name = "kept", .dtype = NQM_U8, .n_dims = 1, .dims = {n_tests}, .data = item->kept}};
    memcpy(tensors, all, sizeof all);
    for (size_t t = 0; t < N_TENSORS; ++t) {
        tensors[t].n_bytes = nqm_dtype_size(tensors[t].dtype);
        for (size_t k = 0; k < tensors[t].n_dims; ++k)
            tensors[t].n_bytes *= tensors[t].dims[k];
    }
}

/* (n) strings as a JSON array, NULL as null; free() it. NULL: out of memory, or not UTF-8. */
static char *strings_to_json(size_t n, char *const *strings) {
    json_t *array = json_array();
    for (size_t i = 0; i < n; ++i)
        json_array_append_new(array, strings[i] ? json_string(strings[i]) : json_null());
    char *text = json_array_size(array) == n ? json_dumps(array, JSON_COMPACT) : NULL;
    json_decref(array);
    return text;
}

/* The file of an unfinished group; nqm_free() it. NULL: out of memory. */
static char *progress_path(const nqm_corpus_item *item) {
    const size_t n = strlen(item->path) + sizeof ".progress";
    char *path = nqm_alloc(n, 1);
    if (path)
        snprintf(path, n, "%s.progress", item->path);
    return path;
}

static void remove_progress(const nqm_corpus_item *item) {
    char *path = progress_path(item);
    if (path)
        unlink(path);
    nqm_free(path);
    nqm_corpus_fits_remove(item);
}

static nqm_status save_at(const char *path, size_t n_directions, const nqm_corpus_item *item, size_t n_done,
                          nqm_error *err) {
    nqm_tensor tensors[N_TENSORS];
    describe(item, n_directions, tensors);
    char *names = strings_to_json(item->plan.n_tests, item->names);
    char *failures = strings_to_json(item->plan.n_tests, item->failures);
    char count[24];
    snprintf(count, sizeof count, "%zu", n_done);
    const nqm_meta meta[] = {{"names", names}, {"failures", failures}, {"tests_done", count}};
    const size_t n_meta = n_done < item->plan.n_tests ? 3 : 2;
    nqm_status status = names && failures
                            ? nqm_safetensors_write(path, N_TENSORS, tensors, n_meta, meta, NULL, err)
                            : nqm_fail(err, NQM_ERR_NOMEM, -1, "%s: a name is not UTF-8, or memory ran out", path);
    free(names);
    free(failures);
    return status;
}

nqm_status nqm_corpus_item_save(size_t n_directions, const nqm_corpus_item *item, size_t n_done, nqm_error *err) {
    if (n_done == item->plan.n_tests) {
        nqm_status status = save_at(item->path, n_directions, item, n_done, err);
        if (status == NQM_OK)
            remove_progress(item);
        return status;
    }
    char *path = progress_path(item);
    if (!path)
        return nqm_fail_nomem(err, strlen(item->path));
    nqm_status status = save_at(path, n_directions, item, n_done, err);
    nqm_free(path);
    return status;
}

static void forget(size_t n, char **strings) {
    for (size_t i = 0; i < n; ++i) {
        nqm_free(strings[i]);
        strings[i] = NULL;
    }
}

/* The opposite of strings_to_json(). */
static bool load_strings(const nqm_safetensors *st, const char *key, size_t n, char **strings) {
    const char *text = nqm_safetensors_meta(st, key);
    json_t *array;
    bool good = nqm_json_parse(text, &array, NULL) == NQM_OK && json_array_size(array) == n;
    for (size_t i = 0; good && i < n; ++i) {
        const char *string = json_string_value(json_array_get(array, i));
        strings[i] = string ? nqm_strdup(string) : NULL;
        good = !string || strings[i];
    }
    json_decref(array);
    if (!good)
        forget(n, strings);
    return good;
}

/* Whether the file has the shapes of the item and a correct checksum. */
static bool matches(const nqm_safetensors *st, const nqm_tensor tensors[N_TENSORS]) {
    char hex[65];
    bool intact = false;
    if (!nqm_safetensors_checksum(st, hex, &intact) || !intact)
        return false;
    for (size_t i = 0; i < N_TENSORS; ++i) {
        const nqm_tensor *found = nqm_safetensors_find(st, tensors[i].name);
        if (!found || found->dtype != tensors[i].dtype || found->n_dims != tensors[i].n_dims ||
            memcmp(found->dims, tensors[i].dims, found->n_dims * sizeof *found->dims) != 0)
            return false;
    }
    return true;
}

/* Each of the first n_done tests must have a name; the next may have one, if it was stopped while it was made. */
static bool load_names(const nqm_safetensors *st, size_t n_done, nqm_corpus_item *item) {
    size_t n = item->plan.n_tests;
    bool good = load_strings(st, "names", n, item->names) && load_strings(st, "failures", n, item->failures);
    for (size_t i = 0; i < n_done; ++i)
        good = good && item->names[i];
    const size_t n_kept = good ? n_done : 0;
    forget(n - n_kept, item->names + n_kept);
    forget(n - n_kept, item->failures + n_kept);
    return good;
}

/* The number of tests in a file: all, unless it is that of an unfinished group. */
static size_t tests_in(const nqm_safetensors *st, const nqm_corpus_item *item) {
    const char *count = nqm_safetensors_meta(st, "tests_done");
    return count ? nqm_smaller(strtoul(count, NULL, 10), item->plan.n_tests) : item->plan.n_tests;
}

/* Load the tests of a file; returns their number, 0: no such file, or a damaged one. */
static size_t load_at(const char *path, size_t n_directions, nqm_corpus_item *item) {
    nqm_tensor tensors[N_TENSORS];
    nqm_map map;
    nqm_safetensors *st;
    if (access(path, R_OK) != 0 || nqm_map_open_own(path, &map, NULL) != NQM_OK)
        return 0;
    if (nqm_safetensors_parse(map.data, map.n_bytes, path, &st, NULL) != NQM_OK) {
        nqm_map_close(&map);
        return 0;
    }
    describe(item, n_directions, tensors);
    const size_t n_done = tests_in(st, item);
    bool loaded = matches(st, tensors) && load_names(st, n_done, item);
    void *const into[N_TENSORS] = {item->ref_rgb, item->ref_used, item->test_rgb, item->test_used,
                                   item->label,   item->fit_loss, item->kept};
    for (size_t i = 0; loaded && i < N_TENSORS; ++i)
        memcpy(into[i], nqm_safetensors_find(st, tensors[i].name)->data, tensors[i].n_bytes);
    nqm_safetensors_free(st);
    nqm_map_close(&map);
    return loaded ? n_done : 0;
}

bool nqm_corpus_item_load(size_t n_directions, nqm_corpus_item *item) {
    if (load_at(item->path, n_directions, item) < item->plan.n_tests)
        return false;
    remove_progress(item); /* left by a process that was killed just before it removed the file */
    return true;
}

size_t nqm_corpus_item_resume(size_t n_directions, nqm_corpus_item *item) {
    char *path = progress_path(item);
    const size_t n_done = path ? load_at(path, n_directions, item) : 0;
    nqm_free(path);
    return n_done;
}
