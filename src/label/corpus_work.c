/* SPDX-License-Identifier: MIT
 *
 * Work files: one finished group each, so that an interrupted corpus goes on where it stopped. The name of a file is a
 * hash of all that its content depends on (versions, options, light, directions, sources, planned tests); with other
 * options other files are made, and none is ever mistaken for another.
 */
#include "label/corpus.h"

#include <jansson.h>
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
    const nqm_scene_options *scene = &context->scene_options;
    hash_text(sha, "nqm corpus work file 1");
    hash_text(sha, nqm_version());
    hash_text(sha, nqm_directions_id(context->directions));
    hash_text(sha, context->light_sha256);
    hash_u64(sha, scene->n_points);
    hash_u64(sha, scene->n_lights);
    hash_u64(sha, scene->seed);
    hash_f64(sha, scene->exposure_cdm2);
    hash_f64(sha, scene->peak_cdm2);
    hash_u64(sha, context->options->seed);
    for (size_t k = 0; k < NQM_CORPUS_N_FITS; ++k) {
        hash_text(sha, nqm_corpus_fits[k].model);
        hash_text(sha, nqm_fit_loss_name(nqm_corpus_fits[k].loss));
    }
}

static void hash_plan(nqm_sha256 *sha, const nqm_corpus_list *list, const nqm_corpus_plan *plan) {
    size_t first = list->groups[plan->group].first_ref;
    hash_text(sha, list->groups[plan->group].name);
    for (size_t f = 0; f < plan->n_forms; ++f) {
        hash_text(sha, plan->forms[f].brdf);
        hash_text(sha, f < plan->n_refs ? list->refs[first + f].file_sha256 : "");
    }
    for (size_t t = 0; t < plan->n_tests; ++t) {
        const nqm_corpus_test *test = &plan->tests[t];
        hash_u64(sha, test->ref);
        hash_u64(sha, test->base);
        hash_u64(sha, test->which);
        hash_text(sha, nqm_corpus_kind_name(test->kind));
        hash_text(sha, test->perturbation[0]);
        hash_text(sha, test->perturbation[1]);
    }
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
    hash_plan(&sha, context->list, &item->plan);
    nqm_sha256_end(&sha, hex);
    snprintf(path, n, "%s/%.32s.safetensors", folder, hex);
    *path_ret = path;
    return NQM_OK;
}

/* ---- content ----------------------------------------------------------------------------------------------------- */

enum { N_TENSORS = 5 };

static void describe(const nqm_corpus_item *item, size_t n, nqm_tensor tensors[N_TENSORS]) {
    size_t n_refs = item->plan.n_refs, n_tests = item->plan.n_tests;
    const nqm_tensor all[N_TENSORS] = {
        {.name = "ref_rgb", .dtype = NQM_F32, .n_dims = 3, .dims = {n_refs, n, 3}, .n_bytes = 12 * n_refs * n},
        {.name = "ref_used", .dtype = NQM_U8, .n_dims = 2, .dims = {n_refs, n}, .n_bytes = n_refs * n},
        {.name = "test_rgb", .dtype = NQM_F32, .n_dims = 3, .dims = {n_tests, n, 3}, .n_bytes = 12 * n_tests * n},
        {.name = "test_used", .dtype = NQM_U8, .n_dims = 2, .dims = {n_tests, n}, .n_bytes = n_tests * n},
        {.name = "delta_e", .dtype = NQM_F64, .n_dims = 1, .dims = {n_tests}, .n_bytes = 8 * n_tests}};
    memcpy(tensors, all, sizeof all);
    tensors[0].data = item->ref_rgb;
    tensors[1].data = item->ref_used;
    tensors[2].data = item->test_rgb;
    tensors[3].data = item->test_used;
    tensors[4].data = item->delta_e;
}

nqm_status nqm_corpus_item_save(const char *path, size_t n_directions, const nqm_corpus_item *item, nqm_error *err) {
    nqm_tensor tensors[N_TENSORS];
    describe(item, n_directions, tensors);
    json_t *names = json_array();
    for (size_t t = 0; t < item->plan.n_tests; ++t)
        json_array_append_new(names, json_string(item->names[t]));
    char *text = json_array_size(names) == item->plan.n_tests ? json_dumps(names, JSON_COMPACT) : NULL;
    json_decref(names);
    if (!text)
        return nqm_fail(err, NQM_ERR_NOMEM, -1, "%s: out of memory", path);
    const nqm_meta meta = {"names", text};
    nqm_status status = nqm_safetensors_write(path, N_TENSORS, tensors, 1, &meta, NULL, err);
    free(text);
    return status;
}

static bool load_names(const nqm_safetensors *st, nqm_corpus_item *item) {
    const char *text = nqm_safetensors_meta(st, "names");
    json_t *names = text ? json_loads(text, 0, NULL) : NULL;
    size_t n_tests = item->plan.n_tests, t = 0;
    while (json_array_size(names) == n_tests && t < n_tests) {
        const char *name = json_string_value(json_array_get(names, t));
        item->names[t] = name ? nqm_strdup(name) : NULL;
        if (!item->names[t])
            break;
        ++t;
    }
    json_decref(names);
    for (size_t k = 0; t < n_tests && k < t; ++k) {
        nqm_free(item->names[k]);
        item->names[k] = NULL;
    }
    return t == n_tests;
}

/* Same shapes as the item's, and an intact checksum. */
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

bool nqm_corpus_item_load(const char *path, size_t n_directions, nqm_corpus_item *item) {
    nqm_tensor tensors[N_TENSORS];
    nqm_map map;
    nqm_safetensors *st;
    if (access(path, R_OK) != 0 || nqm_map_open(path, &map, NULL) != NQM_OK)
        return false;
    if (nqm_safetensors_parse(map.data, map.n_bytes, path, &st, NULL) != NQM_OK) {
        nqm_map_close(&map);
        return false;
    }
    describe(item, n_directions, tensors);
    bool loaded = matches(st, tensors) && load_names(st, item);
    void *const into[N_TENSORS] = {item->ref_rgb, item->ref_used, item->test_rgb, item->test_used, item->delta_e};
    for (size_t i = 0; loaded && i < N_TENSORS; ++i)
        memcpy(into[i], nqm_safetensors_find(st, tensors[i].name)->data, tensors[i].n_bytes);
    nqm_safetensors_free(st);
    nqm_map_close(&map);
    return loaded;
}
