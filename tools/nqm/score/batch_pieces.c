/* SPDX-License-Identifier: MIT
 *
 * Pieces of a list as files of a folder that processes share (base/shared_work.h). The results of a pair do not depend on the
 * other pairs of a call, so that they do not depend on the process either. A file holds doubles and error messages; the rows of
 * the output are printed from them, so that they are those of a run without pieces.
 */
#include "nqm/score/batch_pieces.h"
#include "base/shared_work.h"
#include "io/io.h"
#include "nqm/score/batch.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { MAX_PIECES = 4096, MAX_PATH = 4096 };

/* ---- files ------------------------------------------------------------------------------------------------------- */

/* The members of a result in the columns of a file: runs of doubles, then counts. */
static const struct {
    size_t offset, n;
} doubles[] = {{offsetof(nqm_score_result, jod), 5},
               {offsetof(nqm_score_result, parts), sizeof(nqm_label) / sizeof(double)},
               {offsetof(nqm_score_result, similarity), 3},
               {offsetof(nqm_score_result, metrics), NQM_METRIC_COUNT},
               {offsetof(nqm_score_result, distance_deg), 4}};
enum { N_DOUBLES = 5 + sizeof(nqm_label) / sizeof(double) + 3 + NQM_METRIC_COUNT + 4, N_COUNTS = 7 };
_Static_assert(offsetof(nqm_score_result, novelty) - offsetof(nqm_score_result, jod) == 4 * sizeof(double) &&
                   offsetof(nqm_score_result, n_unusual[1]) - offsetof(nqm_score_result, n_valid) ==
                       (N_COUNTS - 1) * sizeof(size_t),
               "results are stored as runs of equal types");
_Static_assert(offsetof(nqm_score_result, suspect_cosine) - offsetof(nqm_score_result, distance_deg) ==
                   3 * sizeof(double),
               "the last run");

/* status, identical, doubles, counts, of textures */
enum { N_RESULT = 2 + N_DOUBLES + N_COUNTS, N_COLUMNS = N_RESULT + TEXTURE_NUMBERS };

static void pack(const nqm_score_result *r, double row[N_RESULT]) {
    double *to = row;
    *to++ = r->status;
    *to++ = r->identical;
    for (size_t i = 0; i < sizeof doubles / sizeof *doubles; to += doubles[i++].n)
        memcpy(to, (const char *)r + doubles[i].offset, doubles[i].n * sizeof *to);
    for (size_t i = 0; i < N_COUNTS; ++i)
        *to++ = (double)(&r->n_valid)[i];
}

static void unpack(const double row[N_RESULT], nqm_score_result *r) {
    const double *from = row;
    r->status = (nqm_status)*from++;
    r->identical = (int)*from++;
    for (size_t i = 0; i < sizeof doubles / sizeof *doubles; from += doubles[i++].n)
        memcpy((char *)r + doubles[i].offset, from, doubles[i].n * sizeof *from);
    for (size_t i = 0; i < N_COUNTS; ++i)
        (&r->n_valid)[i] = (size_t)*from++;
}

static size_t first_row(const batch_pieces *p, size_t piece) {
    return piece * p->size;
}

static size_t row_count(const batch_pieces *p, size_t piece) {
    return nqm_smaller(p->size, p->list->n_rows - first_row(p, piece));
}

static const char *piece_path(const batch_pieces *p, size_t piece, char path[MAX_PATH]) {
    if (snprintf(path, MAX_PATH, "%s/%s-%zu.safetensors", p->folder, p->identity, piece) >= MAX_PATH)
        stop(EXIT_LIMIT, "--work: the path is longer than %d bytes", (int)MAX_PATH);
    return path;
}

/* Messages of the rows without a score; free() it. */
static char *messages_json(size_t n, const nqm_score_result *results, const nqm_error *errors) {
    json_t *all = json_array();
    for (size_t i = 0; i < n; ++i)
        json_array_append_new(all, results[i].status == NQM_OK ? json_null() : json_name(errors[i].message));
    char *text = json_dumps(all, JSON_COMPACT);
    json_decref(all);
    if (!text)
        stop(EXIT_LIMIT, "out of memory");
    return text;
}

static nqm_status save(const batch_pieces *p, size_t piece, nqm_error *err) {
    char path[MAX_PATH];
    const size_t n = row_count(p, piece);
    double *rows = allocate(n, N_COLUMNS * sizeof *rows);
    for (size_t i = 0; i < n; ++i) {
        pack(&p->results[i], rows + i * N_COLUMNS);
        memcpy(rows + i * N_COLUMNS + N_RESULT, p->textures[i].v, sizeof p->textures[i].v);
    }
    char *messages = messages_json(n, p->results, p->errors), *files = json_dumps(p->files, JSON_COMPACT);
    if (!files)
        stop(EXIT_LIMIT, "out of memory");
    const nqm_tensor tensor = nqm_tensor_of("results", NQM_F64, n, N_COLUMNS, rows);
    const nqm_meta meta[] = {{"errors", messages}, {"files", files}};
    const nqm_status status = nqm_safetensors_write(piece_path(p, piece, path), 1, &tensor, 2, meta, NULL, err);
    free(files);
    free(messages);
    free(rows);
    return status;
}

static bool take_results(batch_pieces *p, size_t n, const nqm_safetensors *st) {
    char hex[65];
    bool intact = false;
    const nqm_tensor *tensor = nqm_safetensors_find(st, "results");
    const char *text = nqm_safetensors_meta(st, "errors");
    json_t *messages = parse_json(text);
    bool good = nqm_safetensors_checksum(st, hex, &intact) && intact && tensor && tensor->dtype == NQM_F64 &&
                tensor->n_bytes == n * N_COLUMNS * sizeof(double) && json_array_size(messages) == n;
    for (size_t i = 0; good && i < n; ++i) {
        double row[N_COLUMNS];
        memcpy(row, (const char *)tensor->data + i * sizeof row, sizeof row);
        unpack(row, &p->results[i]);
        memcpy(p->textures[i].v, row + N_RESULT, sizeof p->textures[i].v);
        const char *message = json_string_value(json_array_get(messages, i));
        p->errors[i] = (nqm_error){.status = p->results[i].status, .byte_offset = -1};
        snprintf(p->errors[i].message, sizeof p->errors[i].message, "%s", message ? message : "");
    }
    json_decref(messages);
    return good;
}

/* Whether the files that the results depend on are the same now; then they become those of the piece. */
static bool take_files(batch_pieces *p, const nqm_safetensors *st) {
    const char *text = nqm_safetensors_meta(st, "files");
    json_t *files = parse_json(text);
    if (!json_is_object(files) || find_changed_file(files)) {
        json_decref(files);
        return false;
    }
    json_decref(p->files);
    p->files = files;
    return true;
}

/* Load the results of a piece; false: there is no file, a damaged one, or one of other contents of a BRDF file. */
static bool load_results(batch_pieces *p, size_t piece) {
    char path[MAX_PATH];
    nqm_map map;
    nqm_safetensors *st;
    if (!p->folder || access(piece_path(p, piece, path), R_OK) != 0 || nqm_map_open_own(path, &map, NULL) != NQM_OK)
        return false;
    bool loaded = false;
    if (nqm_safetensors_parse(map.data, map.n_bytes, path, &st, NULL) == NQM_OK) {
        loaded = take_results(p, row_count(p, piece), st) && take_files(p, st);
        nqm_safetensors_free(st);
    }
    nqm_map_close(&map);
    return loaded;
}

/* The rows with a textured member. */
static void score_piece_textures(batch_pieces *p, size_t n, const nqm_named_pair *pairs) {
    const texture_terms terms = {.model = p->model, .near_only = p->near_only};
    kept_texture ref = {.name = NULL};
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
    p->current = p->n; /* until the results are complete */
    json_decref(p->files);
    p->files = identify_files(n, p->list->pair + first_row(p, piece)); /* before they are read */
    const nqm_named_pair *pairs = p->list->pair + first_row(p, piece);
    const nqm_status status = nqm_scorer_run_named(p->scorer, n, pairs, p->results, p->errors, err);
    if (status == NQM_OK)
        score_piece_textures(p, n, pairs);
    if (status == NQM_OK)
        p->current = piece;
    return status;
}

/* ---- shared work ------------------------------------------------------------------------------------------------- */

/* What the callbacks share; they are called one at a time. */
typedef struct sharing {
    batch_pieces *pieces;
    char path[MAX_PATH];
    size_t n_done, n_rows_done; /* pieces; rows of this process */
    double begin_s;
} sharing;

static const char *path_of(void *user, size_t piece) {
    sharing *s = user;
    return piece_path(s->pieces, piece, s->path);
}

/* Only look for the file: the rank that writes the output checks its content. */
static bool is_finished(void *user, size_t piece) {
    sharing *s = user;
    const bool found = access(path_of(s, piece), R_OK) == 0;
    s->n_done += found;
    return found;
}

static nqm_status make_piece(void *user, size_t piece, nqm_error *err) {
    sharing *s = user;
    nqm_status status = score_piece(s->pieces, piece, err);
    if (status == NQM_OK)
        status = save(s->pieces, piece, err);
    s->n_done += status == NQM_OK;
    s->n_rows_done += row_count(s->pieces, piece);
    return status;
}

static bool is_stopped(void *user) {
    const sharing *s = user;
    if (s->n_rows_done)
        note_progress("%.0f pairs/s by this process", (double)s->n_rows_done / (nqm_clock_s() - s->begin_s));
    return show_progress(NULL, "batch", (double)s->n_done, (double)s->pieces->n) || interrupted();
}

int share_batch_pieces(batch_pieces *p, ranks r) {
    nqm_error err = {0};
    sharing s = {.pieces = p, .begin_s = nqm_clock_s()};
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

/* ---- one process ------------------------------------------------------------------------------------------------- */

static void hash_terms(const json_t *terms, size_t size, char identity[33]) {
    char hex[65], *text = json_dumps(terms, JSON_COMPACT | JSON_SORT_KEYS);
    nqm_sha256 sha;
    if (!text || !nqm_sha256_begin(&sha))
        stop(EXIT_LIMIT, "out of memory");
    static const char layout[] = "nqm batch piece 5";
    nqm_sha256_add(&sha, layout, sizeof layout);
    nqm_sha256_add_values(&sha, 1, sizeof size, &size);
    nqm_sha256_add(&sha, text, strlen(text));
    nqm_sha256_end(&sha, hex);
    snprintf(identity, 33, "%.32s", hex);
    free(text);
}

void open_batch_pieces(const char *folder, const json_t *terms, const nqm_pair_list *list, nqm_scorer *scorer,
                       const nqm_model *model, batch_pieces *p) {
    const size_t n_blocks = nqm_ceil_div(list->n_rows, NQM_SCORE_BLOCK);
    const size_t blocks_each = folder ? nqm_ceil_div(n_blocks, MAX_PIECES) : 1;
    *p = (batch_pieces){
        .list = list, .scorer = scorer, .model = model, .size = NQM_SCORE_BLOCK * (blocks_each ? blocks_each : 1)};
    p->n = p->current = nqm_ceil_div(list->n_rows, p->size);
    p->results = allocate(p->size, sizeof *p->results);
    p->errors = allocate(p->size, sizeof *p->errors);
    p->textures = allocate(p->size, sizeof *p->textures);
    if (!folder)
        return;
    if (mkdir(folder, 0777) != 0 && !is_folder(folder))
        stop(EXIT_OPEN, "--work: the folder '%s' cannot be made", folder);
    p->folder = absolute_path(folder, "");
    hash_terms(terms, p->size, p->identity);
}

int get_batch_results(batch_pieces *p, size_t row, size_t *n_ret, size_t *at) {
    nqm_error err = {0};
    const size_t piece = row / p->size;
    if (p->current != piece && load_results(p, piece))
        p->current = piece;
    if (p->current != piece && score_piece(p, piece, &err) != NQM_OK)
        return report_error(&err);
    *at = row - first_row(p, piece);
    *n_ret = row_count(p, piece) - *at;
    return EXIT_OK;
}

void forget_batch_piece(batch_pieces *p, size_t row) {
    char path[MAX_PATH];
    if (p->folder)
        unlink(piece_path(p, row / p->size, path));
}

void close_batch_pieces(batch_pieces *p) {
    free(p->folder);
    free(p->results);
    free(p->errors);
    free(p->textures);
    json_decref(p->files);
}
