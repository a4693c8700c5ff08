/* SPDX-License-Identifier: MIT
 *
 * Pieces of a list as files of a folder: that of --work, which processes share (base/shared_work.h), or one beside the output. The
 * results of a pair do not depend on the other pairs of a call, so that they do not depend on the process either. A file holds
 * results as they are in memory; the rows of the output are printed from them, so that they are those of a run without pieces.
 */
#include "argument/argument.h"
#include "base/os.h"
#include "base/shared_work.h"
#include "io/io.h"
#include "nqm/score/batch.h"

#include <stdlib.h>
#include <string.h>

enum { MAX_PIECES = 4096, MAX_PATH = 4096, N_IDENTITY = 32 };

/* ---- files that rows depend on ----------------------------------------------------------------------------------- */

/* An identity is the SHA-256 of the contents of a small file, so that it does not change when the file is copied, and size and time
 * of a large one, which is not read completely. */
enum { SMALL_FILE = 1 << 16, IDENTITY = 72 };

static json_t *identify(const char *path) {
    char text[IDENTITY] = "";
    nqm_file_info info;
    nqm_map map;
    nqm_sha256 sha;
    if (!nqm_os_get_info(path, &info)) {
        strcpy(text, "missing");
    } else if (nqm_role_input(&info, path, NULL) == NQM_OK && info.n_bytes <= SMALL_FILE &&
               nqm_map_open(path, &map, NULL) == NQM_OK) {
        if (nqm_sha256_begin(&sha)) {
            nqm_sha256_add(&sha, map.data, map.n_bytes);
            nqm_sha256_end(&sha, text);
        }
        nqm_map_close(&map);
    } else {
        snprintf(text, IDENTITY, "%lld bytes, %lld.%09ld s", (long long)info.n_bytes, (long long)info.changed_s,
                 (long)info.changed_ns);
    }
    return json_string(text);
}

/* Set the values of an object whose keys are paths. */
static void identify_all(json_t *files) {
    const char *path;
    json_t *value;
    json_object_foreach(files, path, value)
        json_object_set_new(files, path, identify(path)); /* of a key that is there: allowed meanwhile */
}

static void add_file(void *files, const char *path) {
    json_object_set_new(files, path, json_null()); /* not UTF-8: no key, and not noticed */
}

static void add_argument(json_t *files, const char *argument) {
    nqm_argument *a = parse_argument(argument);
    nqm_argument_visit_files(a, add_file, files);
    nqm_argument_free(a);
}

/* An object with the path of each file that the pairs name, and its identity. Relative paths begin in the working folder. */
static json_t *identify_files(size_t n, const nqm_named_pair *pairs) {
    json_t *files = json_object();
    for (size_t i = 0; i < n; ++i) {
        if (i == 0 || strcmp(pairs[i].ref, pairs[i - 1].ref) != 0)
            add_argument(files, pairs[i].ref);
        add_argument(files, pairs[i].test);
    }
    identify_all(files);
    return files;
}

/* Whether all files of such an object have the same identity now. */
static bool has_same_files(const json_t *files) {
    json_t *now = json_copy((json_t *)(uintptr_t)files);
    identify_all(now);
    const bool is_same = json_equal(now, files);
    json_decref(now);
    return is_same;
}

/* ---- pieces ------------------------------------------------------------------------------------------------------ */

/* A single piece is lost when the run ends early, so that only processes that share it need its file. */
static bool is_saved(const batch_pieces *p) {
    return p->folder && (p->is_shared || p->n > 1);
}

static size_t first_row(const batch_pieces *p, size_t piece) {
    return piece * p->size;
}

static size_t row_count(const batch_pieces *p, size_t piece) {
    return nqm_smaller(p->size, p->list->n - first_row(p, piece));
}

static const char *piece_path(const batch_pieces *p, size_t piece, char path[MAX_PATH]) {
    if (snprintf(path, MAX_PATH, "%s/%s-%zu.safetensors", p->folder, p->identity, piece) >= MAX_PATH)
        stop(EXIT_LIMIT, "%s: the path is longer than %d bytes", p->folder, (int)MAX_PATH);
    return path;
}

static nqm_status save(const batch_pieces *p, size_t piece, nqm_error *err) {
    char path[MAX_PATH], *files = must_have(json_dumps(p->files, JSON_COMPACT));
    const size_t n = row_count(p, piece);
    bool has_errors = false;
    for (size_t i = 0; i < n; ++i)
        has_errors = has_errors || p->results[i].status != NQM_OK;
    const nqm_tensor tensors[] = {nqm_tensor_of("results", NQM_U8, n, sizeof *p->results, p->results),
                                  nqm_tensor_of("textures", NQM_U8, n, sizeof *p->textures, p->textures),
                                  nqm_tensor_of("errors", NQM_U8, n, sizeof *p->errors, p->errors)};
    const nqm_meta meta[] = {{"terms", p->terms}, {"files", files}};
    nqm_status status;
    do {
        make_folder(p->folder);
        status = nqm_safetensors_write(piece_path(p, piece, path), has_errors ? 3 : 2, tensors, 2, meta, NULL, err);
    } while (status == NQM_ERR_IO &&
             !nqm_os_is_folder(p->folder)); /* a run with the same output removed it meanwhile */
    free(files);
    return status;
}

/* Copy the bytes of a tensor; false: there is none of this size. */
static bool take(const nqm_safetensors *st, const char *name, size_t n_bytes, void *to) {
    const nqm_tensor *tensor = nqm_safetensors_find(st, name);
    if (!tensor || tensor->n_bytes != n_bytes)
        return false;
    memcpy(to, tensor->data, n_bytes);
    return true;
}

static bool take_piece(batch_pieces *p, size_t n, const nqm_safetensors *st) {
    char hex[65];
    bool intact = false;
    json_t *files = parse_json(nqm_safetensors_meta(st, "files"));
    const bool is_taken = nqm_safetensors_checksum(st, hex, &intact) && intact && json_is_object(files) &&
                          has_same_files(files) && take(st, "results", n * sizeof *p->results, p->results) &&
                          take(st, "textures", n * sizeof *p->textures, p->textures);
    if (is_taken && !take(st, "errors", n * sizeof *p->errors, p->errors))
        memset(p->errors, 0, n * sizeof *p->errors);
    json_decref(files);
    return is_taken;
}

/* Call `use` with a file of a piece; false: it is missing or damaged, or `use` says so. */
static bool open_piece(batch_pieces *p, const char *path, size_t n,
                       bool (*use)(batch_pieces *p, size_t n, const nqm_safetensors *st)) {
    nqm_map map;
    nqm_safetensors *st;
    if (nqm_map_open_own(path, &map, NULL) != NQM_OK)
        return false;
    const bool is_good = nqm_safetensors_parse(map.data, map.n_bytes, path, &st, NULL) == NQM_OK;
    const bool is_used = is_good && use(p, n, st);
    if (is_good)
        nqm_safetensors_free(st);
    nqm_map_close(&map);
    return is_used;
}

/* Load the results of a piece; false: there is no file, a damaged one, or one of other contents of a BRDF file. */
static bool load(batch_pieces *p, size_t piece) {
    char path[MAX_PATH];
    p->current = p->n; /* until the results are complete */
    if (!p->folder || !open_piece(p, piece_path(p, piece, path), row_count(p, piece), take_piece))
        return false;
    p->current = piece;
    return true;
}

/* ---- scores ------------------------------------------------------------------------------------------------------ */

/* The rows with a textured member. */
static void score_piece_textures(batch_pieces *p, size_t n, const nqm_named_pair *pairs) {
    const nqm_library_terms terms = {
        .model = p->model, .near_only = p->near_only, .progress = show_progress, .report = report_part};
    nqm_library_kept ref = {.name = NULL};
    nqm_texture_result *t = allocate(1, sizeof *t);
    for (size_t i = 0; i < n; ++i) {
        const bool is_needed = p->results[i].status != NQM_OK && has_texture(&pairs[i]);
        if (is_needed)
            score_texture(&terms, &pairs[i], &ref, t, &p->results[i], NULL, &p->errors[i]);
        p->textures[i] = texture_numbers_of(is_needed && p->results[i].status == NQM_OK ? t : NULL);
    }
    nqm_texture_free(ref.texture);
    free(t);
}

static nqm_status score_piece(batch_pieces *p, size_t piece, nqm_error *err) {
    const size_t n = row_count(p, piece);
    const nqm_named_pair *pairs = p->list->pairs + first_row(p, piece);
    p->current = p->n;
    json_decref(p->files);
    p->files = is_saved(p) ? identify_files(n, pairs) : NULL; /* before they are read */
    nqm_status status = nqm_scorer_run_named(p->scorer, n, pairs, p->results, p->errors, err);
    if (status == NQM_OK)
        score_piece_textures(p, n, pairs);
    if (status == NQM_OK && is_saved(p))
        status = save(p, piece, err);
    if (status != NQM_OK)
        return status;
    p->current = piece;
    p->n_scored += n;
    return NQM_OK;
}

int get_batch_piece(batch_pieces *p, size_t piece, size_t *n_ret) {
    nqm_error err = {0};
    if (p->current != piece && !load(p, piece) && score_piece(p, piece, &err) != NQM_OK)
        return report_error(&err);
    *n_ret = row_count(p, piece);
    return EXIT_OK;
}

void forget_batch_piece(batch_pieces *p, size_t piece) {
    char path[MAX_PATH];
    if (p->folder)
        nqm_os_remove(piece_path(p, piece, path));
}

int show_batch_progress(const batch_pieces *p, size_t n_done, size_t n) {
    if (p->n_scored)
        note_progress("%.0f pairs/s", (double)p->n_scored / (nqm_clock_s() - p->begin_s));
    return show_progress(NULL, "batch", (double)n_done, (double)n);
}

/* ---- shared work ------------------------------------------------------------------------------------------------- */

/* What the callbacks share; they are called one at a time. */
typedef struct sharing {
    batch_pieces *pieces;
    char path[MAX_PATH];
    size_t n_done; /* pieces */
} sharing;

static const char *path_of(void *user, size_t piece) {
    sharing *s = user;
    return piece_path(s->pieces, piece, s->path);
}

/* Only open the file: the rank that writes the output checks its content. */
static bool is_finished(void *user, size_t piece) {
    sharing *s = user;
    const int file = nqm_os_open(path_of(s, piece), NQM_OPEN_READ);
    const bool found = file >= 0;
    if (found)
        nqm_os_close(file);
    s->n_done += found;
    return found;
}

static nqm_status make_piece(void *user, size_t piece, nqm_error *err) {
    sharing *s = user;
    const nqm_status status = score_piece(s->pieces, piece, err);
    s->n_done += status == NQM_OK;
    return status;
}

static bool is_stopped(void *user) {
    const sharing *s = user;
    return show_batch_progress(s->pieces, s->n_done * s->pieces->size, s->pieces->list->n) || interrupted();
}

int share_batch_pieces(batch_pieces *p, ranks r) {
    nqm_error err = {0};
    sharing s = {.pieces = p};
    const nqm_shared_work work = {.n = p->n,
                                  .first = p->n * r.rank / r.count,
                                  .one_at_a_time = true, /* a piece is scored on all threads */
                                  .user = &s,
                                  .path = path_of,
                                  .load = is_finished,
                                  .make = make_piece,
                                  .is_stopped = is_stopped};
    const nqm_status status = p->n ? nqm_shared_work_run(&work, &err) : NQM_OK;
    end_progress();
    if (status == NQM_ERR_CANCELLED)
        return report(EXIT_INTERRUPTED, "stopped; the same command continues from %s", p->folder);
    return status == NQM_OK ? EXIT_OK : report_error(&err);
}

/* ---- the folder -------------------------------------------------------------------------------------------------- */

/* Call `visit` with the paths of the files of pieces, or only of those with these terms, files being written included, until
 * it returns true. A folder that is not there has none. */
static bool each_file(batch_pieces *p, bool only_own, bool (*visit)(batch_pieces *p, const char *path)) {
    nqm_names names = {.n = 0};
    char path[MAX_PATH];
    bool is_ended = false;
    if (nqm_os_list_folder(p->folder, &names, &fault) == NQM_ERR_NOMEM)
        stop_error(&fault);
    for (size_t i = 0; i < names.n && !is_ended; ++i) {
        const char *name = nqm_name(&names, i);
        is_ended = strspn(name, "0123456789abcdef") == N_IDENTITY && name[N_IDENTITY] == '-' &&
                   strstr(name, ".safetensors") && (!only_own || strncmp(name, p->identity, N_IDENTITY) == 0) &&
                   snprintf(path, MAX_PATH, "%s/%s", p->folder, name) < MAX_PATH && visit(p, path);
    }
    nqm_names_free(&names);
    return is_ended;
}

static bool find_one(batch_pieces *p, const char *path) {
    (void)p, (void)path;
    return true;
}

/* Remove a file, unless another run is writing it and has locked it. */
static bool remove_file(batch_pieces *p, const char *path) {
    const int file = nqm_os_open(path, NQM_OPEN_WRITE);
    (void)p;
    if (file >= 0 && nqm_os_lock(file, path) != NQM_LOCK_HELD)
        nqm_os_remove(path);
    if (file >= 0)
        nqm_os_close(file);
    return false;
}

/* Stop at the first of this run's terms that was another one in the run that made the piece. */
static bool compare_terms(batch_pieces *p, size_t n, const nqm_safetensors *st) {
    json_t *now = parse_json(p->terms), *before = parse_json(nqm_safetensors_meta(st, "terms")), *value;
    const char *key;
    (void)n;
    json_object_foreach(now, key, value) {
        const json_t *was = json_object_get(before, key);
        if (!json_equal(value, was))
            stop(EXIT_INCOMPATIBLE,
                 "%s was begun with another %s%s%s: --resume needs the same; leave it out to start again", p->folder,
                 key, json_string_length(was) ? ", " : "", json_string_length(was) ? json_string_value(was) : "");
    }
    json_decref(now);
    json_decref(before);
    return true;
}

static bool compare_file(batch_pieces *p, const char *path) {
    return open_piece(p, path, 0, compare_terms);
}

static void hash_terms(batch_pieces *p) {
    const size_t layout[] = {6, NQM_BIG_ENDIAN, p->size, sizeof *p->results, sizeof *p->textures, sizeof *p->errors};
    char hex[65];
    nqm_sha256 sha;
    if (!nqm_sha256_begin(&sha))
        stop(EXIT_LIMIT, "out of memory");
    nqm_sha256_add_values(&sha, sizeof layout / sizeof *layout, sizeof *layout, layout);
    nqm_sha256_add(&sha, p->terms, strlen(p->terms));
    nqm_sha256_end(&sha, hex);
    snprintf(p->identity, sizeof p->identity, "%.32s", hex);
}

void open_batch_pieces(batch_pieces *p, const json_t *terms, bool resume) {
    const size_t n_blocks = nqm_ceil_div(p->list->n, NQM_SCORE_BLOCK);
    p->size = NQM_SCORE_BLOCK * (p->folder ? nqm_larger(1, nqm_ceil_div(n_blocks, MAX_PIECES)) : 1);
    p->n = p->current = nqm_ceil_div(p->list->n, p->size);
    p->results = allocate(p->size, sizeof *p->results);
    p->errors = allocate(p->size, sizeof *p->errors);
    p->textures = allocate(p->size, sizeof *p->textures);
    p->terms = must_have(json_dumps(terms, JSON_COMPACT));
    p->begin_s = nqm_clock_s();
    hash_terms(p);
    if (p->is_shared) {
        make_folder(p->folder);
    } else if (p->folder && !(resume && each_file(p, true, find_one))) {
        if (resume)
            each_file(p, false, compare_file);
        each_file(p, false, remove_file);
    }
}

void close_batch_pieces(batch_pieces *p, bool is_complete) {
    if (p->folder && !p->is_shared) {
        if (is_complete)
            each_file(p, true, remove_file);
        (void)nqm_os_remove_folder(p->folder); /* if it is empty */
    }
    free(p->terms);
    free(p->results);
    free(p->errors);
    free(p->textures);
    json_decref(p->files);
}
