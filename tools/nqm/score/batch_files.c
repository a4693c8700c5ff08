/* SPDX-License-Identifier: MIT
 *
 * The files that rows of `nqm batch` depend on: their paths with an identity, which is the SHA-256 of the contents of a
 * small file, so that it does not change when the file is copied, and size and time of a large one, which is not read
 * completely.
 */
#include "nqm/score/batch.h"

#include "brdf/brdf.h"
#include "material/maps.h"
#include <nqm/material.h>

#include <stdlib.h>
#include <string.h>

enum { SMALL_FILE = 1 << 16, IDENTITY = 72 };

typedef struct file_list {
    size_t n;
    const char **paths; /* (n) keys of the object */
    char (*identity)[IDENTITY];
} file_list;

static void identify(void *user, size_t i) {
    const file_list *list = user;
    struct stat st;
    nqm_map map;
    nqm_sha256 sha;
    char *text = list->identity[i];
    if (stat(list->paths[i], &st) != 0) {
        strcpy(text, "missing");
    } else if (nqm_role_input(&st, list->paths[i], NULL) == NQM_OK && st.st_size <= SMALL_FILE &&
               nqm_map_open(list->paths[i], &map, NULL) == NQM_OK) {
        if (nqm_sha256_begin(&sha)) {
            nqm_sha256_add(&sha, map.data, map.n_bytes);
            nqm_sha256_end(&sha, text);
        }
        nqm_map_close(&map);
    } else {
        snprintf(text, IDENTITY, "%lld bytes, %lld.%09ld s", (long long)st.st_size, (long long)st.st_mtim.tv_sec,
                 (long)st.st_mtim.tv_nsec);
    }
}

/* Set the values of an object whose keys are paths. */
static void identify_all(json_t *files) {
    const char *key;
    json_t *value;
    file_list list = {.paths = allocate(json_object_size(files), sizeof *list.paths),
                      .identity = allocate(json_object_size(files), sizeof *list.identity)};
    json_object_foreach(files, key, value) list.paths[list.n++] = key;
    nqm_parallel_for(list.n, identify, &list);
    for (size_t i = 0; i < list.n; ++i)
        json_object_set_new(files, list.paths[i], json_string(list.identity[i]));
    free(list.paths);
    free(list.identity);
}

/* The latents in the folder of a decoder of neural processes. */
static void add_latents(json_t *files, const char *path) {
    const char *slash = strrchr(path, '/');
    const int n_folder = slash ? (int)(slash - path) + 1 : 0;
    char latents[4096];
    if (snprintf(latents, sizeof latents, "%.*snps_latents.csv", n_folder, path) < (int)sizeof latents &&
        is_file(latents))
        json_object_set_new(files, latents, json_null());
}

/* The images of a textured material. */
static void add_images(json_t *files, const nqm_textured *textured) {
    for (size_t i = 0; i < textured->n_images; ++i)
        if (textured->images[i].path)
            json_object_set_new(files, textured->images[i].path, json_null());
}

/* The measured files and images that the materials of a file name. */
static void add_measured(json_t *files, const char *path) {
    const nqm_materials *materials =
        parsed_materials(path); /* NULL: another kind of file, or a broken one, which scoring reports */
    for (size_t i = 0; materials && i < nqm_materials_count(materials); ++i) {
        const nqm_material_info info = nqm_materials_get(materials, i);
        if (nqm_materials_maps(materials, i, ~0U))
            add_images(files, nqm_materials_maps(materials, i, ~0U));
        if (!info.spec || nqm_spec_probe(info.spec))
            continue;
        char *measured = must_have(nqm_path_beside(path, info.spec));
        json_object_set_new(files, measured, json_null());
        nqm_free(measured);
    }
}

/* The file of an argument: all of it, or what is before the last colon. */
static void add_path(json_t *files, const char *argument, size_t n) {
    char path[4096];
    unsigned ignored;
    const size_t n_prefix = nqm_ignore_prefix(argument, &ignored);
    argument += n_prefix;
    n -= nqm_smaller(n, n_prefix);
    if (n == 0 || n >= sizeof path)
        return;
    memcpy(path, argument, n);
    path[n] = '\0';
    char *colon = strrchr(path, ':');
    if (!is_file(path) && colon)
        *colon = '\0';
    if (!is_file(path))
        return;
    if (!json_object_get(files, path)) {
        json_object_set_new(files, path, json_null()); /* not UTF-8: no key, and not noticed */
        add_measured(files, path);
    }
    if (colon)
        add_latents(files, path);
}

/* A spec may name files as values of its keys: "of=FILE", "with=(FILE)". */
static void add_argument(json_t *files, const char *argument) {
    if (!nqm_spec_probe(argument)) {
        add_path(files, argument, strlen(argument));
        return;
    }
    while (*argument) {
        const size_t n = strcspn(argument, ";");
        const char *value = memchr(argument, '=', n), *end = argument + n;
        if (value) {
            value += 1 + strspn(value + 1, "(");
            while (end > value && end[-1] == ')')
                --end;
            if (!nqm_spec_probe(value))
                add_path(files, value, (size_t)(end - value));
        }
        argument += n + (argument[n] == ';');
    }
}

json_t *identify_files(size_t n, const nqm_named_pair *pairs) {
    json_t *files = json_object();
    for (size_t i = 0; i < n; ++i) {
        if (i == 0 || strcmp(pairs[i].ref, pairs[i - 1].ref) != 0)
            add_argument(files, pairs[i].ref);
        add_argument(files, pairs[i].test);
    }
    identify_all(files);
    return files;
}

bool has_same_files(const json_t *files) {
    json_t *now = json_copy((json_t *)(uintptr_t)files);
    identify_all(now);
    const bool is_same = json_equal(now, files);
    json_decref(now);
    return is_same;
}
