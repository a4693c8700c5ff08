/* SPDX-License-Identifier: MIT
 *
 * The list of the materials of files and folders.
 */
#include "library/library.h"
#include "base/os.h"
#include "brdf/brdf.h"

#include <stdlib.h>

nqm_status nqm_library_step(struct nqm_library_state *s, const char *stage, size_t done, size_t total, nqm_error *err) {
    return nqm_tick(&s->ticker, stage, (double)done, (double)total)
               ? nqm_fail(err, NQM_ERR_CANCELLED, -1, "interrupted")
               : NQM_OK;
}

/* ---- members ----------------------------------------------------------------------------------------------------- */

static void free_texts(nqm_library_member *member) {
    nqm_free((char *)(uintptr_t)member->argument);
    nqm_free((char *)(uintptr_t)member->key);
}

nqm_status nqm_library_add(nqm_library *library, char *argument, char *key, bool is_textured, nqm_error *err) {
    struct nqm_library_state *s = library->state;
    nqm_library_member member = {argument, key, is_textured};
    nqm_library_member *members =
        argument && key ? nqm_grow(s->members, &s->max_n, library->n + 1, sizeof *members) : NULL;
    if (!members) {
        free_texts(&member);
        return nqm_fail_nomem(err, (library->n + 1) * sizeof *members);
    }
    library->members = s->members = members;
    members[library->n++] = member;
    return NQM_OK;
}

void nqm_library_compact(nqm_library *library) {
    size_t n = 0;
    for (size_t i = 0; i < library->n; ++i)
        if (library->members[i].argument)
            library->state->members[n++] = library->members[i];
    library->n_failed += library->n - n;
    library->n = n;
}

void nqm_library_clear(nqm_library *library) {
    struct nqm_library_state *s = library->state;
    for (size_t i = 0; i < library->n; ++i)
        free_texts(&s->members[i]);
    nqm_free(s->members);
    nqm_gallery_free(s->gallery);
    nqm_map_close(&s->index);
    nqm_free(s->block);
    library->n = library->n_failed = s->max_n = 0;
    library->members = s->members = NULL;
    s->gallery = NULL;
    s->index = (nqm_map){.data = NULL};
    s->block = NULL;
}

/* key: what the names of its materials begin with; "": nothing. */
static nqm_status add_materials(nqm_library *to, const char *path, const nqm_materials *materials, const char *key,
                                nqm_error *err) {
    const size_t n = nqm_materials_count(materials);
    nqm_status status = NQM_OK;
    for (size_t i = 0; status == NQM_OK && i < n; ++i) {
        const nqm_material_info info = nqm_materials_reflecting(materials, i, to->state->ignored);
        const bool is_ignoring = info.ignorable && (info.spec || info.n_maps);
        char *argument = nqm_strdupf("%s%s%s%s%s%s", is_ignoring ? "ignore:" : "", is_ignoring ? info.ignorable : "",
                                     is_ignoring ? ":" : "", path, n > 1 ? ":" : "", n > 1 ? info.name : "");
        status =
            nqm_library_add(to, argument, nqm_pairs_join(key, n > 1 || !*key ? info.name : ""), info.n_maps > 0, err);
    }
    return status;
}

static bool ends_with(const char *path, const char *extensions) {
    const char *dot = strrchr(path, '.');
    return dot && nqm_contains_word(extensions, dot, true);
}

/* not_read: NQM_REMARK_SIZE characters; files of a folder that may be meant are added. */
static nqm_status add_file(nqm_library *to, const char *path, const char *key, char *not_read, nqm_error *err) {
    const bool is_only = to->state->is_file;
    nqm_materials *materials = NULL;
    nqm_error why = {0};
    nqm_status status = nqm_materials_open(path, &materials, &why);
    if (status == NQM_OK) {
        status = add_materials(to, path, materials, is_only ? "" : key, err);
        nqm_materials_free(materials);
        return status;
    }
    if (ends_with(path, ".binary .bsdf .npy .safetensors .h5 .mat") ||
        (ends_with(path, ".csv") && nqm_brdf_probe(path)))
        return nqm_library_add(to, nqm_strdup(path), nqm_strdup(key), false, err);
    if (is_only || status == NQM_ERR_NOMEM)
        return nqm_fail(err, status, why.byte_offset, "%s", why.message);
    if (ends_with(path, ".mtlx .gltf .glb .pbrt")) { /* damaged; others of a folder need not be materials */
        nqm_library_report(&to->state->terms, status, "%s", why.message);
        ++to->n_failed;
    } else if (ends_with(path, ".csv .txt .xml .json .usd .usda .usdc .usdz .zip .pth .npz"))
        nqm_remark_add(not_read, NQM_REMARK_SIZE, "%s", key);
    return NQM_OK;
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

static int compare_texts(const void *a, const void *b) {
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

/* The files of a folder and of the folders in it. Links are not followed; a folder inside that cannot be read has no files. */
static nqm_status walk(struct nqm_library_state *s, const char *folder, nqm_names *files, nqm_error *err) {
    const bool has_slash = folder[strlen(folder) - 1] == '/';
    nqm_names names = {.n = 0};
    nqm_status status = nqm_os_list_folder(folder, &names, err);
    for (size_t i = 0; status == NQM_OK && i < names.n; ++i) {
        const char *name = nqm_name(&names, i);
        char *path = nqm_strdupf("%s%s%s", folder, has_slash ? "" : "/", name);
        nqm_file_info info;
        if (!path)
            status = nqm_fail_nomem(err, strlen(folder) + strlen(name));
        else if (nqm_os_is_link(path) || !nqm_os_get_info(path, &info))
            status = NQM_OK;
        else if (info.kind == NQM_FILE_FOLDER)
            status = walk(s, path, files, err);
        else if (info.kind == NQM_FILE_REGULAR && *name != '.')
            status = nqm_names_add(files, path, strlen(path), err);
        nqm_free(path);
        if (status == NQM_OK || status == NQM_ERR_IO)
            status = nqm_library_step(s, "read", files->n, 0, err);
    }
    nqm_names_free(&names);
    return status;
}

/* The files of n paths, each once. "/dev/null" has none. */
static nqm_status list_files(struct nqm_library_state *s, size_t n, const char *const *where, nqm_library_files *files,
                             nqm_error *err) {
    nqm_status status = NQM_OK;
    for (size_t i = 0; status == NQM_OK && i < n; ++i) {
        const char *path = nqm_argument_rest(where[i]); /* what is ignored is asked for each material */
        if (nqm_os_is_folder(path))
            status = walk(s, path, &files->text, err);
        else if (strcmp(path, "/dev/null") != 0)
            status = nqm_names_add(&files->text, path, strlen(path), err);
    }
    files->paths = nqm_alloc(files->text.n, sizeof *files->paths);
    if (status == NQM_OK && !files->paths)
        status = nqm_fail_nomem(err, files->text.n * sizeof *files->paths);
    if (status != NQM_OK)
        return status;
    for (size_t i = 0; i < files->text.n; ++i)
        files->paths[i] = nqm_name(&files->text, i);
    qsort(files->paths, files->text.n, sizeof *files->paths, compare_texts);
    for (size_t i = 0; i < files->text.n; ++i)
        if (i == 0 || strcmp(files->paths[i], files->paths[files->n - 1]) != 0)
            files->paths[files->n++] = files->paths[i];
    return NQM_OK;
}

/* n: paths that were given; materials of several are named by their whole paths. */
static nqm_status add_files(nqm_library *to, size_t n, const nqm_library_files *files, nqm_error *err) {
    struct nqm_library_state *s = to->state;
    const char *slash = strrchr(s->path, '/');
    const size_t n_key = n > 1 ? 0 : !s->is_file ? strlen(s->path) : slash ? (size_t)(slash - s->path) : 0;
    char not_read[NQM_REMARK_SIZE] = "";
    nqm_status status = NQM_OK;
    for (size_t i = 0; status == NQM_OK && i < files->n; ++i) {
        const char *key = files->paths[i] + n_key;
        status = nqm_library_step(s, "read", i, files->n, err);
        if (status == NQM_OK)
            status = add_file(to, files->paths[i], n > 1 ? key : key + strspn(key, "/"), not_read, err);
    }
    if (status == NQM_OK && *not_read)
        nqm_library_report(&s->terms, NQM_OK, "%s: these files are no materials or BRDFs: %s", s->path, not_read);
    if (status == NQM_OK && to->n == 0 && !s->is_file)
        status = nqm_fail(err, NQM_ERR_IO, -1, "%s: no file of materials or BRDFs is there", s->path);
    return status;
}

/* ---- libraries --------------------------------------------------------------------------------------------------- */

typedef struct whole_library {
    nqm_library library;
    struct nqm_library_state state;
} whole_library;

static nqm_status set_options(nqm_library *library, size_t n, const char *const *where,
                              const nqm_library_options *options, nqm_error *err) {
    struct nqm_library_state *s = library->state;
    s->score = options->score ? *options->score : nqm_score_options_default();
    s->score.metrics = 0;
    s->terms = (nqm_library_terms){
        .model = s->model, .progress = options->progress, .report = options->report, .user = options->user};
    s->ticker = (nqm_ticker){.fn = options->progress, .user = options->user};
    if (options->ignore && !nqm_ignore_parse(options->ignore, strlen(options->ignore), &s->ignored))
        return nqm_fail(err, NQM_ERR_ARG, -1, "'%.100s' is no list of what can be ignored", options->ignore);
    s->path = n == 1 ? nqm_strdup(where[0]) : nqm_strdupf("%zu files and folders", n);
    s->index_path = options->index ? nqm_strdup(options->index) : NULL;
    if (!s->path || (options->index && !s->index_path))
        return nqm_fail_nomem(err, NQM_REMARK_SIZE);
    library->path = s->path;
    s->is_file = n == 1 && !nqm_os_is_folder(s->path);
    return NQM_OK;
}

nqm_status nqm_library_open(size_t n, const char *const *where, const nqm_model *model,
                            const nqm_library_options *options, nqm_library **library_ret, nqm_error *err) {
    NQM_MAKE(err, library_ret, where);
    const nqm_library_options none = {.ignore = NULL};
    nqm_library_files files = {.n = 0};
    whole_library *whole = nqm_alloc(1, sizeof *whole);
    if (!whole)
        return nqm_fail_nomem(err, sizeof *whole);
    nqm_library *library = &whole->library;
    library->state = &whole->state;
    whole->state.model = model;
    nqm_status status = set_options(library, n, where, options ? options : &none, err);
    if (status == NQM_OK)
        status = list_files(&whole->state, n, where, &files, err);
    if (status == NQM_OK && model && whole->state.index_path)
        status = nqm_library_identify(library, &files, err);
    if (status == NQM_OK && model && whole->state.index_path)
        status = nqm_library_read_index(library, err);
    if (status == NQM_OK && !whole->state.gallery)
        status = add_files(library, n, &files, err);
    nqm_free(files.paths);
    nqm_names_free(&files.text);
    if (status == NQM_OK)
        *library_ret = library;
    else
        nqm_library_free(library);
    return status;
}

void nqm_library_free(nqm_library *library) {
    if (!library)
        return;
    struct nqm_library_state *s = library->state;
    (void)!nqm_library_begin_pairs(s, 0, NULL);
    nqm_free(s->pairs);
    nqm_library_clear(library);
    nqm_scorer_free(s->scorer);
    nqm_free(s->path);
    nqm_free(s->index_path);
    nqm_free(library);
}
