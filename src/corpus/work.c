/* SPDX-License-Identifier: MIT
 *
 * Work files: one finished unit each, from which an interrupted corpus continues. The name of a file is
 * a hash of everything that determines its content (version, options, light, directions, contents of the BRDFs, tests), so that
 * runs with different options never share a file.
 */
#include "argument/argument.h"
#include "base/os.h"
#include "brdf/brdf.h"
#include "corpus/corpus.h"
#include "fit/fit.h"
#include "io/json.h"
#include "percept/percept.h"

#include <stdlib.h>
#include <string.h>

/* ---- checksums of the files that a list of pairs names ----------------------------------------------------------- */

nqm_status nqm_corpus_hash_file(const char *path, const char *path_more, char hex[65], nqm_error *err) {
    nqm_map map = {0}, more = {0};
    nqm_sha256 sha;
    nqm_status status = nqm_map_open(path, &map, err);
    if (status == NQM_OK && path_more)
        status = nqm_map_open(path_more, &more, err);
    if (status == NQM_OK && !nqm_sha256_begin(&sha))
        status = nqm_fail(err, NQM_ERR_NOMEM, -1, "%s: out of memory", path);
    if (status == NQM_OK) {
        nqm_sha256_add(&sha, map.data, map.n_bytes);
        nqm_sha256_add(&sha, more.data, more.n_bytes);
        nqm_sha256_end(&sha, hex);
    }
    nqm_map_close(&map);
    nqm_map_close(&more);
    return status;
}

nqm_status nqm_corpus_hash_content(const nqm_corpus_list *list, const char *base, char hex[65], nqm_error *err) {
    char *text = nqm_argument_below(base, list->root), *more = NULL;
    nqm_argument *of = text ? nqm_argument_parse(text, NULL) : NULL;
    nqm_status status = of ? NQM_OK : nqm_fail_nomem(err, strlen(base));
    *hex = 0;
    if (of && of->path)
        status = nqm_argument_companion(of, &more, err);
    if (status == NQM_OK && of->path)
        status = nqm_corpus_hash_file(of->path, more, hex, err);
    nqm_free(more);
    nqm_argument_free(of);
    nqm_free(text);
    return status;
}

nqm_status nqm_corpus_hash_refs(nqm_corpus_list *list, nqm_error *err) {
    nqm_status status = NQM_OK;
    for (size_t i = 0; status == NQM_OK && i < list->n_refs; ++i)
        if (nqm_argument_kind_of(list->refs[i].brdf) != NQM_ARGUMENT_FIT)
            status = nqm_corpus_hash_content(list, list->refs[i].brdf, list->refs[i].file_sha256, err);
    return status;
}

/* ---- names ------------------------------------------------------------------------------------------------------- */

static void hash_text(nqm_sha256 *sha, const char *text) {
    nqm_sha256_add(sha, text, strlen(text) + 1);
}

static void hash_corpus(nqm_sha256 *sha, const nqm_corpus *corpus) {
    const nqm_scene_options *scene = &corpus->options->scene;
    hash_text(sha, "nqm corpus work file 6");
    hash_text(sha, nqm_version());
    hash_text(sha, nqm_directions_id(corpus->directions));
    hash_text(sha, *corpus->light_sha256 ? corpus->light_sha256 : scene->light ? scene->light : "");
    hash_text(sha, *corpus->shape_sha256 ? corpus->shape_sha256 : scene->shape ? scene->shape : "");
    const uint64_t counts[] = {
        scene->width,       scene->height, scene->n_points,     nqm_scene_n_frames(scene),  nqm_scene_n_lights(scene),
        scene->light_width, scene->seed,   scene->shadows != 0, scene->interreflection != 0};
    const double numbers[] = {scene->turn_rad, scene->elevation_rad, scene->exposure_cdm2, scene->peak_cdm2};
    nqm_sha256_add_values(sha, sizeof counts / sizeof *counts, sizeof *counts, counts);
    nqm_sha256_add_values(sha, sizeof numbers / sizeof *numbers, sizeof *numbers, numbers);
    if (scene->exact)
        hash_text(sha, "exact");
    if (corpus->options->anisotropic)
        hash_text(sha, "anisotropic");
    for (size_t k = 0; k < 2; ++k)
        hash_text(sha, corpus->encoder_sha256[k]);
}

typedef struct hashing {
    nqm_sha256 *sha;
    const nqm_corpus_list *list;
} hashing;

/* Hash what a test is made from: the checksum of a file, all parameters of presets and other specs. */
static nqm_status hash_base(void *user, const char *base, nqm_error *err) {
    const hashing *h = user;
    char hex[65];
    const nqm_corpus_ref *ref = nqm_corpus_ref_of(h->list, base);
    nqm_status status = ref ? NQM_OK : nqm_corpus_hash_content(h->list, base, hex, NULL);
    hash_text(h->sha, base);
    if (status == NQM_ERR_NOMEM)
        return nqm_fail_nomem(err, sizeof hex);
    hash_text(h->sha, status != NQM_OK ? "missing" : ref ? ref->file_sha256 : hex); /* a failure of the pair */
    if (status != NQM_OK || *(ref ? ref->file_sha256 : hex) || strchr(base, '='))
        return NQM_OK;
    nqm_brdf *brdf;
    if (nqm_brdf_open(base, &brdf, NULL) != NQM_OK)
        return NQM_OK;
    const char *spec = nqm_brdf_get_info(brdf).spec;
    hash_text(h->sha, spec ? spec : "");
    nqm_brdf_free(brdf);
    return NQM_OK;
}

static nqm_status hash_argument(hashing *h, const char *argument, nqm_error *err) {
    nqm_error fault = {0};
    hash_text(h->sha, argument);
    nqm_status status = nqm_argument_visit_bases(argument, hash_base, h, &fault);
    if (status == NQM_ERR_NOMEM && err)
        *err = fault;
    return status == NQM_ERR_NOMEM ? status : NQM_OK; /* others are failures of the pair */
}

nqm_status nqm_corpus_unit_path(const nqm_corpus *corpus, const nqm_corpus_unit *unit, char **path_ret,
                                nqm_error *err) {
    const char *folder = corpus->options->checkpoint;
    size_t n = strlen(folder) + 80;
    *path_ret = NULL;
    nqm_sha256 sha;
    char *path = nqm_alloc(n, 1), hex[65];
    if (!path || !nqm_sha256_begin(&sha)) {
        nqm_free(path);
        return nqm_fail_nomem(err, n);
    }
    hashing h = {&sha, &corpus->list};
    hash_corpus(&sha, corpus);
    hash_text(&sha, corpus->list.refs[unit->ref].name);
    nqm_status status = hash_argument(&h, corpus->list.refs[unit->ref].brdf, err);
    for (size_t i = 0; status == NQM_OK && i < unit->n_rows; ++i)
        status = hash_argument(&h, corpus->list.rows[unit->first_row + i].test, err);
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

enum { N_TENSORS = 5, N_LABEL = 1 + NQM_LABEL_PARTS + 1 };
_Static_assert(sizeof(nqm_label) == N_LABEL * sizeof(double), "labels are stored as rows of numbers");

static void describe(const nqm_corpus_unit *unit, size_t n, nqm_tensor tensors[N_TENSORS]) {
    const size_t n_rows = unit->n_rows;
    const nqm_tensor all[N_TENSORS] = {
        {.name = "ref_rgb", .dtype = NQM_F32, .n_dims = 2, .dims = {n, 3}, .data = unit->ref_rgb},
        {.name = "ref_used", .dtype = NQM_U8, .n_dims = 1, .dims = {n}, .data = unit->ref_used},
        {.name = "test_rgb", .dtype = NQM_F32, .n_dims = 3, .dims = {n_rows, n, 3}, .data = unit->test_rgb},
        {.name = "test_used", .dtype = NQM_U8, .n_dims = 2, .dims = {n_rows, n}, .data = unit->test_used},
        {.name = "label", .dtype = NQM_F64, .n_dims = 2, .dims = {n_rows, N_LABEL}, .data = unit->label}};
    memcpy(tensors, all, sizeof all);
    for (size_t t = 0; t < N_TENSORS; ++t)
        nqm_tensor_measure(&tensors[t]);
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

/* The file of an unfinished unit; nqm_free() it. NULL: out of memory. */
static char *progress_path(const nqm_corpus_unit *unit) {
    return nqm_strdupf("%s.progress", unit->path);
}

static void remove_progress(const nqm_corpus_unit *unit) {
    char *path = progress_path(unit);
    if (path)
        nqm_os_remove(path);
    nqm_free(path);
}

static nqm_status save_at(const char *path, size_t n_directions, const nqm_corpus_unit *unit, size_t n_done,
                          nqm_error *err) {
    nqm_tensor tensors[N_TENSORS];
    describe(unit, n_directions, tensors);
    char *names = strings_to_json(unit->n_rows, unit->names);
    char *failures = strings_to_json(unit->n_rows, unit->failures);
    char count[24];
    snprintf(count, sizeof count, "%zu", n_done);
    const nqm_meta meta[] = {{"names", names}, {"failures", failures}, {"rows_done", count}};
    const size_t n_meta = n_done < unit->n_rows ? 3 : 2;
    nqm_status status = names && failures
                            ? nqm_safetensors_write(path, N_TENSORS, tensors, n_meta, meta, NULL, err)
                            : nqm_fail(err, NQM_ERR_NOMEM, -1, "%s: a name is not UTF-8, or memory ran out", path);
    free(names);
    free(failures);
    return status;
}

nqm_status nqm_corpus_unit_save(size_t n_directions, const nqm_corpus_unit *unit, size_t n_done, nqm_error *err) {
    if (n_done == unit->n_rows) {
        nqm_status status = save_at(unit->path, n_directions, unit, n_done, err);
        if (status == NQM_OK)
            remove_progress(unit);
        return status;
    }
    char *path = progress_path(unit);
    if (!path)
        return nqm_fail_nomem(err, strlen(unit->path));
    nqm_status status = save_at(path, n_directions, unit, n_done, err);
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

/* Each of the first n_done rows must have a name; the next may have one, if it was stopped while it was made. */
static bool load_names(const nqm_safetensors *st, size_t n_done, nqm_corpus_unit *unit) {
    size_t n = unit->n_rows;
    bool good = load_strings(st, "names", n, unit->names) && load_strings(st, "failures", n, unit->failures);
    for (size_t i = 0; i < n_done; ++i)
        good = good && unit->names[i];
    const size_t n_kept = good ? n_done : 0;
    forget(n - n_kept, unit->names + n_kept);
    forget(n - n_kept, unit->failures + n_kept);
    return good;
}

/* The number of rows in a file: all, unless it is that of an unfinished unit. */
static size_t rows_in(const nqm_safetensors *st, const nqm_corpus_unit *unit) {
    const char *count = nqm_safetensors_meta(st, "rows_done");
    return count ? nqm_smaller(strtoul(count, NULL, 10), unit->n_rows) : unit->n_rows;
}

/* Load the rows of a file; returns their number, 0: no such file, or a damaged one. */
static size_t load_at(const char *path, size_t n_directions, nqm_corpus_unit *unit) {
    nqm_tensor tensors[N_TENSORS];
    nqm_map map;
    nqm_safetensors *st;
    if (nqm_map_open_own(path, &map, NULL) != NQM_OK)
        return 0;
    if (nqm_safetensors_parse(map.data, map.n_bytes, path, &st, NULL) != NQM_OK) {
        nqm_map_close(&map);
        return 0;
    }
    describe(unit, n_directions, tensors);
    const size_t n_done = rows_in(st, unit);
    bool loaded = matches(st, tensors) && load_names(st, n_done, unit);
    void *const into[N_TENSORS] = {unit->ref_rgb, unit->ref_used, unit->test_rgb, unit->test_used, unit->label};
    for (size_t i = 0; loaded && i < N_TENSORS; ++i)
        memcpy(into[i], nqm_safetensors_find(st, tensors[i].name)->data, tensors[i].n_bytes);
    nqm_safetensors_free(st);
    nqm_map_close(&map);
    return loaded ? n_done : 0;
}

bool nqm_corpus_unit_load(size_t n_directions, nqm_corpus_unit *unit) {
    if (load_at(unit->path, n_directions, unit) < unit->n_rows)
        return false;
    remove_progress(unit); /* of a process that was killed just before it removed the file */
    return true;
}

size_t nqm_corpus_unit_resume(size_t n_directions, nqm_corpus_unit *unit) {
    char *path = progress_path(unit);
    const size_t n_done = path ? load_at(path, n_directions, unit) : 0;
    nqm_free(path);
    return n_done;
}
