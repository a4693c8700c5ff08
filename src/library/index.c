/* SPDX-License-Identifier: MIT
 *
 * The file that keeps members and pictures of a library: tensors with the arguments and keys of the members with values, each with a
 * NUL, the key after a 't' if the member is textured; their pictures; and the files of the maps of textured members, each with a NUL.
 */
#include "base/os.h"
#include "brdf/brdf.h"
#include "library/library.h"
#include "model/model.h"

#include <stdlib.h>

enum { NAMES, PICTURES, MAPS, N_TENSORS };
static const char *const tensor_names[N_TENSORS] = {"names", "pictures", "maps"};

/* Hash n bytes, and path, size and time of each file. */
static nqm_status hash_files(const nqm_library_files *files, const char *bytes, size_t n, char hash[65],
                             nqm_error *err) {
    nqm_sha256 sha;
    if (!nqm_sha256_begin(&sha))
        return nqm_fail_nomem(err, n);
    nqm_sha256_add(&sha, bytes, n);
    for (size_t i = 0; i < files->n; ++i) {
        nqm_file_info file = {.n_bytes = 0};
        (void)nqm_os_get_info(files->paths[i], &file);
        nqm_sha256_add(&sha, files->paths[i], strlen(files->paths[i]) + 1);
        nqm_sha256_add_values(&sha, 3, sizeof(int64_t), (int64_t[]){file.n_bytes, file.changed_s, file.changed_ns});
    }
    nqm_sha256_end(&sha, hash);
    return NQM_OK;
}

/* The model, what is ignored, and the files. */
nqm_status nqm_library_identify(nqm_library *library, const nqm_library_files *files, nqm_error *err) {
    char bytes[65];
    snprintf(bytes, sizeof bytes, "%.64s", nqm_model_get_info(library->state->model).sha256);
    bytes[64] = (char)library->state->ignored;
    return hash_files(files, bytes, sizeof bytes, library->state->hash, err);
}

/* Sizes and times of the files in a text of n bytes. */
static nqm_status hash_maps(const char *text, size_t n, char hash[65], nqm_error *err) {
    nqm_library_files files = {.n = 0};
    for (size_t at = 0; at < n; at += strlen(text + at) + 1)
        ++files.n;
    files.paths = nqm_alloc(files.n, sizeof *files.paths);
    if (!files.paths)
        return nqm_fail_nomem(err, files.n * sizeof *files.paths);
    for (size_t at = 0, i = 0; at < n; at += strlen(text + at) + 1)
        files.paths[i++] = text + at;
    const nqm_status status = hash_files(&files, "", 0, hash, err);
    nqm_free(files.paths);
    return status;
}

/* The members of an index. Returns whether the text has two names for each of n. */
static bool take_members(nqm_library *of, const nqm_tensor *names, size_t n) {
    const char *at = names->data, *end = at + names->n_bytes;
    for (size_t i = 0; i < n; ++i) {
        const char *middle = memchr(at, 0, (size_t)(end - at));
        const char *last = middle ? memchr(middle + 1, 0, (size_t)(end - middle - 1)) : NULL;
        if (!last || last < middle + 2 ||
            nqm_library_add(of, nqm_strdup(at), nqm_strdup(middle + 2), middle[1] == 't', NULL) != NQM_OK)
            return false;
        at = last + 1;
    }
    return at == end;
}

/* Use the members and pictures of a parsed index; false: they are not those of these files. */
static bool take_index(nqm_library *of, const nqm_safetensors *st) {
    struct nqm_library_state *s = of->state;
    const nqm_tensor *names = nqm_safetensors_find(st, tensor_names[NAMES]),
                     *pictures = nqm_safetensors_find(st, tensor_names[PICTURES]),
                     *maps = nqm_safetensors_find(st, tensor_names[MAPS]);
    const char *stored = nqm_safetensors_meta(st, "library"), *failed = nqm_safetensors_meta(st, "failed"),
               *of_maps = nqm_safetensors_meta(st, "map-files");
    char hash_now[65];
    if (!stored || strcmp(stored, s->hash) != 0 || !failed || !names || names->dtype != NQM_U8 || !pictures ||
        pictures->dtype != NQM_F32 || pictures->n_dims != 2 || pictures->dims[1] != nqm_gallery_size(s->model) ||
        (uintptr_t)pictures->data % sizeof(float) != 0 || !nqm_tensor_all_finite(pictures) ||
        !take_members(of, names, pictures->dims[0]) || !maps || maps->dtype != NQM_U8 || maps->n_bytes == 0 ||
        ((const char *)maps->data)[maps->n_bytes - 1] || !of_maps ||
        hash_maps(maps->data, maps->n_bytes, hash_now, NULL) != NQM_OK || strcmp(hash_now, of_maps) != 0)
        return false;
    of->n_failed = strtoul(failed, NULL, 10);
    return nqm_gallery_create(s->model, of->n, pictures->data, &s->gallery, NULL) == NQM_OK;
}

nqm_status nqm_library_read_index(nqm_library *of, nqm_error *err) {
    struct nqm_library_state *s = of->state;
    nqm_safetensors *st = NULL;
    nqm_file_info file;
    if (!nqm_os_get_info(s->index_path, &file) || file.kind != NQM_FILE_REGULAR ||
        nqm_map_open_own(s->index_path, &s->index, NULL) != NQM_OK)
        return NQM_OK;
    const bool is_read = nqm_safetensors_parse(s->index.data, s->index.n_bytes, s->index_path, &st, NULL) == NQM_OK;
    const char *format = is_read ? nqm_safetensors_meta(st, "format") : NULL;
    const bool is_index = format && strcmp(format, "nqm-index") == 0, fits = is_index && take_index(of, st);
    s->block = fits ? nqm_safetensors_take(st) : NULL;
    nqm_safetensors_free(st);
    if (!fits)
        nqm_library_clear(of);
    return is_index ? NQM_OK
                    : nqm_fail(err, NQM_ERR_ARG, -1,
                               "%s: is no index that nqm has written, and is not replaced: remove it or name another "
                               "file",
                               s->index_path);
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

static void put_file(void *stream, const char *path) {
    fprintf(stream, "%s%c", path, 0);
}

/* The files that an argument reads. */
static nqm_status put_maps(const char *argument, FILE *to, nqm_error *err) {
    nqm_argument *a = nqm_argument_parse(argument, NULL);
    if (!a)
        return nqm_fail_nomem(err, strlen(argument) + 1);
    nqm_argument_visit_files(a, put_file, to);
    nqm_argument_free(a);
    return NQM_OK;
}

/* The texts of the first and third tensor; free() both. */
static nqm_status make_texts(const nqm_library *of, char *texts[2], size_t n_texts[2], nqm_error *err) {
    FILE *names = nqm_os_memory_stream(&texts[0], &n_texts[0]), *maps = nqm_os_memory_stream(&texts[1], &n_texts[1]);
    nqm_status status = names && maps ? NQM_OK : nqm_fail_nomem(err, 1);
    if (maps)
        fputc(0, maps); /* a tensor has elements */
    for (size_t i = 0; status == NQM_OK && i < of->n; ++i) {
        fprintf(names, "%s%c%c%s%c", of->members[i].argument, 0, of->members[i].is_textured ? 't' : '-',
                of->members[i].key, 0);
        if (of->members[i].is_textured)
            status = put_maps(of->members[i].argument, maps, err);
    }
    const bool has_names = names && nqm_os_close_memory(names, &texts[0], &n_texts[0]);
    const bool has_maps = maps && nqm_os_close_memory(maps, &texts[1], &n_texts[1]);
    return status == NQM_OK && !(has_names && has_maps) ? nqm_fail_nomem(err, n_texts[0] + n_texts[1]) : status;
}

nqm_status nqm_library_write_index(const nqm_library *of, nqm_error *err) {
    const struct nqm_library_state *s = of->state;
    char *texts[2] = {NULL, NULL}, failed[24], of_maps[65];
    size_t n_texts[2] = {0, 0};
    nqm_status status = make_texts(of, texts, n_texts, err);
    if (status == NQM_OK)
        status = hash_maps(texts[1], n_texts[1], of_maps, err);
    snprintf(failed, sizeof failed, "%zu", of->n_failed);
    const nqm_tensor tensors[N_TENSORS] = {nqm_tensor_of(tensor_names[NAMES], NQM_U8, 0, n_texts[0], texts[0]),
                                           nqm_tensor_of(tensor_names[PICTURES], NQM_F32, of->n,
                                                         nqm_gallery_size(s->model), nqm_gallery_pictures(s->gallery)),
                                           nqm_tensor_of(tensor_names[MAPS], NQM_U8, 0, n_texts[1], texts[1])};
    const nqm_meta meta[] = {{"format", "nqm-index"}, {"library", s->hash}, {"failed", failed}, {"map-files", of_maps}};
    if (status == NQM_OK)
        status = nqm_safetensors_write(s->index_path, N_TENSORS, tensors, sizeof meta / sizeof *meta, meta, NULL, err);
    free(texts[0]);
    free(texts[1]);
    return status;
}
