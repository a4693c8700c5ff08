/* SPDX-License-Identifier: MIT
 *
 * Output of `nqm batch`. The rows of a file are written to FILE.part first. FILE.part.journal begins with the terms of
 * the run; after every block, a line with the number of rows, of failed rows and of bytes so far, the SHA-256 of the
 * block and its notes, and the notes of its rows and the files that they depend on as JSON is appended. A killed run
 * leaves both files. A run with --resume checks terms and hashes, truncates FILE.part to the last checkpoint of the
 * journal, and continues, so that the finished file is identical to that of an uninterrupted run.
 */
#include "nqm/score/batch.h"

#include <errno.h>
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

static const char journal_mark[] = "nqm batch journal 5\n";

static _Noreturn void stop_write(const char *path) {
    stop(EXIT_OPEN, "%s: cannot write: %s", path ? path : "standard output", strerror(errno));
}

/* The hash of a block of rows and of their notes. */
static void hash_block(const char *text, size_t n_bytes, const char *notes, char hex[65]) {
    nqm_sha256 sha;
    if (!nqm_sha256_begin(&sha))
        stop(EXIT_LIMIT, "out of memory");
    nqm_sha256_add(&sha, text, n_bytes);
    nqm_sha256_add(&sha, notes, strlen(notes));
    nqm_sha256_end(&sha, hex);
}

/* ---- the journal ------------------------------------------------------------------------------------------------- */

/* A line of the journal: the first n_bytes of FILE.part are valid. */
typedef struct checkpoint {
    batch_progress done;
    size_t n_bytes;
    char sha256[65];   /* SHA-256 of the bytes since the previous checkpoint */
    long journal_end;  /* offset of the byte after the line */
    const char *notes; /* notes on the rows since the previous checkpoint; points into the line */
} checkpoint;

static _Noreturn void stop_damage(const batch_output *out) {
    stop(EXIT_MALFORMED, "%s does not match its journal: it is damaged; remove it to start again", out->part);
}

/* Compare the terms in the journal with those of this run; the message names the first that differs. */
static void compare_terms(const batch_output *out, const char *line, const json_t *terms) {
    json_t *before = parse_json(line);
    if (!before)
        stop_damage(out);
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)(uintptr_t)terms, key, value) {
        const json_t *was = json_object_get(before, key);
        if (!json_equal(value, was))
            stop(EXIT_INCOMPATIBLE,
                 "%s was begun with another %s%s%s: --resume needs the same; remove it to start again", out->part, key,
                 json_string_length(was) ? ", " : "", json_string_length(was) ? json_string_value(was) : "");
    }
    json_decref(before);
}

/* Cuts the end off the line. */
static bool read_checkpoint(char *line, checkpoint *c) {
    int n = 0;
    c->done.begun = true;
    if (sscanf(line, "%zu %zu %zu %64[0-9a-f] %n", &c->done.n_rows, &c->done.n_failed, &c->n_bytes, c->sha256, &n) != 4)
        return false;
    c->notes = line + n;
    line[strlen(line) - 1] = '\0';
    return n > 0 && strlen(c->sha256) == 64;
}

/* ---- notes in the journal ---------------------------------------------------------------------------------------- */

enum { N_NUMBERS = 5 };

static double *numbers_of(batch_note *note) {
    _Static_assert(offsetof(batch_note, novelty) == (N_NUMBERS - 1) * sizeof(double), "the numbers come first");
    return &note->jod;
}

/* The notes of rows [begin, end) as a line of JSON; free() it. */
static char *print_notes(const batch_output *out, size_t begin, size_t end) {
    json_t *all = json_array();
    for (size_t row = begin; row < end; ++row) {
        batch_note *note = &out->notes[row];
        json_t *one = json_array();
        for (int i = 0; i < N_NUMBERS; ++i)
            json_array_append_new(one, json_number(numbers_of(note)[i]));
        json_array_append_new(one, json_boolean(note->is_scored));
        json_array_append_new(one, json_boolean(note->is_identical));
        json_array_append_new(one, json_boolean(note->is_skipped));
        json_array_append_new(one, json_integer((json_int_t)note->n_text));
        json_array_append_new(one, note->remark ? json_name(note->remark) : json_null());
        json_array_append_new(all, one);
    }
    json_t *both = json_pack("{s:o,s:o}", "rows", all, "files", out->files ? json_incref(out->files) : json_object());
    char *text = json_dumps(both, JSON_COMPACT | JSON_REAL_PRECISION(17));
    if (!text)
        stop(EXIT_LIMIT, "out of memory");
    json_decref(both);
    return text;
}

static bool read_note(const json_t *one, batch_note *note) {
    for (size_t i = 0; i < N_NUMBERS; ++i) {
        const json_t *number = json_array_get(one, i);
        numbers_of(note)[i] = json_is_number(number) ? json_number_value(number) : (double)NAN;
    }
    const json_t *n_text = json_array_get(one, N_NUMBERS + 3), *remark = json_array_get(one, N_NUMBERS + 4);
    note->is_scored = json_is_true(json_array_get(one, N_NUMBERS));
    note->is_identical = json_is_true(json_array_get(one, N_NUMBERS + 1));
    note->is_skipped = json_is_true(json_array_get(one, N_NUMBERS + 2));
    note->n_text = (size_t)json_integer_value(n_text);
    note->remark = json_is_string(remark) ? strdup(json_string_value(remark)) : NULL;
    return json_array_size(one) == N_NUMBERS + 5 && json_is_integer(n_text) && json_integer_value(n_text) >= 0;
}

/* The notes of the rows between two checkpoints; false unless there is one for each. */
static bool read_notes(batch_output *out, const checkpoint *last, const checkpoint *c) {
    json_t *both = parse_json(c->notes), *all = json_object_get(both, "rows");
    const size_t begin = last->done.n_rows, end = c->done.n_rows;
    bool good = json_object_update_missing(out->files_before, json_object_get(both, "files")) == 0 &&
                json_is_array(all) && end >= begin && end <= out->max_rows && json_array_size(all) == end - begin;
    for (size_t row = begin; good && row < end; ++row)
        good = read_note(json_array_get(all, row - begin), &out->notes[row]);
    json_decref(both);
    return good;
}

/* Compare the hash of the next n bytes of FILE.part and of the notes of their rows. */
static void check_block(batch_output *out, size_t n, const checkpoint *c) {
    char hex[65], *block = allocate(n, 1);
    if (fread(block, 1, n, out->stream) != n)
        stop_damage(out);
    hash_block(block, n, c->notes, hex);
    if (strcmp(hex, c->sha256) != 0)
        stop_damage(out);
    free(block);
}

/* The last checkpoint whose bytes FILE.part contains. journal_end is 0 when there is none: the run was killed before its
 * first checkpoint. */
static checkpoint read_journal(batch_output *out, const json_t *terms) {
    struct stat st;
    char *line = NULL;
    size_t room = 0;
    checkpoint last = {0};
    if (fstat(fileno(out->stream), &st) != 0)
        stop_write(out->part);
    rewind(out->log);
    rewind(out->stream);
    for (size_t number = 0;; ++number) {
        ssize_t n = getline(&line, &room, out->log);
        if (n <= 0 || line[n - 1] != '\n') /* end of file, or an incomplete line */
            break;
        checkpoint c = {0};
        if (number == 1)
            compare_terms(out, line, terms);
        else if (number == 0 ? strcmp(line, journal_mark) != 0 : !read_checkpoint(line, &c) || c.n_bytes < last.n_bytes)
            stop_damage(out);
        if (number < 2 || c.n_bytes > (size_t)st.st_size)
            continue;
        check_block(out, c.n_bytes - last.n_bytes, &c);
        if (!read_notes(out, &last, &c))
            stop_damage(out);
        if (c.done.n_rows == 0)
            out->n_head = c.n_bytes;
        c.journal_end = ftell(out->log);
        last = c;
    }
    free(line);
    return last;
}

/* Truncate FILE.part and the journal to a checkpoint: both are in append mode. */
static void truncate_to(const batch_output *out, const checkpoint *c) {
    rewind(out->stream); /* required between reading and writing */
    rewind(out->log);
    if (ftruncate(fileno(out->stream), (off_t)c->n_bytes) != 0 ||
        ftruncate(fileno(out->log), (off_t)c->journal_end) != 0)
        stop_write(out->part);
}

/* ---- opening ----------------------------------------------------------------------------------------------------- */

/* Open for reading and appending; create the file if it does not exist. */
static FILE *open_kept(const char *path) {
    FILE *stream = fopen(path, "a+e");
    if (!stream)
        stop_write(path);
    return stream;
}

/* Open and lock the journal; `log` is NULL if another run has locked it. The lock comes first: a run that ends deletes its journal.
 * *existed_ret: there was one. */
static void lock_journal(batch_output *out, bool *existed_ret) {
    nqm_error err = {0};
    int fd;
    must(nqm_lock_open(out->journal, &fd, existed_ret, &err), &err);
    out->log = fd < 0 ? NULL : fdopen(fd, "a+");
    if (fd >= 0 && !out->log)
        stop_write(out->journal);
}

/* The terms in a journal that another run has locked; NULL: it has not written them yet. */
static json_t *read_terms(const char *journal) {
    char *line = NULL;
    size_t room = 0;
    FILE *stream = fopen(journal, "re");
    const bool is_there = stream && getline(&line, &room, stream) > 0 && getline(&line, &room, stream) > 0;
    json_t *terms = is_there ? parse_json(line) : NULL;
    free(line);
    if (stream)
        fclose(stream);
    return terms;
}

static bool is_written_by_other(const batch_output *out, const batch_request *request) {
    if (out->log)
        return false;
    if (!request->may_help)
        stop(EXIT_OPEN, "%s: another run is writing it", out->part);
    json_t *theirs = NULL;
    for (int i = 0; i < 20 && !(theirs = read_terms(out->journal)); ++i)
        nanosleep(&(struct timespec){.tv_nsec = 50000000}, NULL);
    if (!json_equal(request->terms, theirs))
        stop(EXIT_OPEN, "%s: another run is writing it, with another list or other options", out->part);
    json_decref(theirs);
    report(EXIT_OK, "another run is writing %s: this one scores pieces of the list, and writes it if that run dies",
           out->path);
    return true;
}

/* The journal is locked. */
static void open_part(batch_output *out, const batch_request *request, bool has_journal) {
    const json_t *terms = request->terms;
    const bool goes_on = request->resume && access(out->part, F_OK) ==
                                                0; /* only a journal remains when a run was killed after the rename */
    if (goes_on && !has_journal) {
        unlink(out->journal);
        stop(EXIT_INCOMPATIBLE, "%s has no journal next to it: remove it to start again", out->part);
    }
    out->stream = open_kept(out->part);
    nqm_keep_mode(fileno(out->stream), out->path);
    nqm_keep_mode(fileno(out->log), out->path);
    const checkpoint last = goes_on ? read_journal(out, terms) : (checkpoint){0};
    truncate_to(out, &last);
    out->n_bytes = last.n_bytes;
    out->done = last.done;
    if (last.journal_end == 0) {
        fputs(journal_mark, out->log);
        bool bad = json_dumpf(terms, out->log, JSON_COMPACT) != 0;
        fputc('\n', out->log);
        if (bad || fflush(out->log) != 0)
            stop_write(out->journal);
    }
}

/* false: another run is writing the file. */
static bool open_file(batch_output *out, const batch_request *request) {
    char *target = realpath(request->path, NULL); /* target of a symbolic link; NULL: a new file */
    const char *path = target ? target : request->path;
    out->path = absolute_path(path, "");
    out->part = absolute_path(path, ".part");
    out->journal = absolute_path(path, ".part.journal");
    free(target);
    bool has_journal;
    lock_journal(out, &has_journal);
    if (is_written_by_other(out, request))
        return false;
    open_part(out, request, has_journal);
    return true;
}

bool take_over_batch_output(const batch_request *request, batch_output *out) {
    bool has_journal;
    for (lock_journal(out, &has_journal); !out->log; lock_journal(out, &has_journal)) {
        if (interrupted())
            stop(EXIT_INTERRUPTED, "stopped while another run is writing %s", out->path);
        nanosleep(&(struct timespec){.tv_nsec = 50000000}, NULL);
    }
    if (!has_journal) { /* a run that finishes its output removes its journal */
        unlink(out->journal);
        return false;
    }
    report(EXIT_OK, "the other run has left %s unfinished: this one writes it", out->path);
    open_part(out, request, has_journal);
    return true;
}

bool open_batch_output(const batch_request *request, batch_output *out) {
    const char *path = request->path;
    *out = (batch_output){.stream = stdout, .max_rows = request->max_rows};
    out->notes = allocate(out->max_rows, sizeof *out->notes);
    out->files_before = json_object();
    out->rows = open_memstream(&out->text, &out->n_text);
    if (!out->rows)
        stop(EXIT_LIMIT, "out of memory");
    struct stat st;
    bool standard = !path || strcmp(path, "-") == 0;
    bool device = !standard && stat(path, &st) == 0 && !S_ISREG(st.st_mode);
    if (request->resume && (standard || device))
        stop(EXIT_USAGE, "--resume needs a file: -o FILE");
    if (device) {
        out->stream = fopen(path, "w");
        out->path = strdup(path);
        if (!out->stream || !out->path)
            stop_write(path);
    } else if (!standard && !open_file(out, request)) {
        return false;
    }
    if (request->is_sorted && !out->part) {
        out->target = out->stream;
        out->stream = tmpfile();
        if (!out->stream)
            stop(EXIT_OPEN, "there is no place for a temporary file: %s", strerror(errno));
    }
    return true;
}

void check_batch_files(const batch_output *out) {
    const char *changed = find_changed_file(out->files_before);
    if (changed)
        stop(EXIT_INCOMPATIBLE,
             "%s: its first %zu rows were scored with another content of the file %s: --resume needs the same; "
             "remove it to start again",
             out->part, out->done.n_rows, changed);
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

static void write_text(batch_output *out) {
    if (fflush(out->rows) != 0 || ferror(out->rows))
        stop(EXIT_LIMIT, "out of memory");
    if (!out->part && !out->target)
        end_progress(); /* the progress line may be on the same terminal */
    if (fwrite(out->text, 1, out->n_text, out->stream) != out->n_text || fflush(out->stream) != 0)
        stop_write(out->part ? out->part : out->path);
}

void append_batch_output(batch_output *out, const batch_progress *done) {
    write_text(out);
    out->n_bytes += out->n_text;
    if (done->n_rows == 0)
        out->n_head = out->n_bytes;
    if (out->part) {
        char sha256[65], *notes = print_notes(out, out->done.n_rows, done->n_rows);
        hash_block(out->text, out->n_text, notes, sha256);
        fprintf(out->log, "%zu %zu %zu %s %s\n", done->n_rows, done->n_failed, out->n_bytes, sha256, notes);
        if (fflush(out->log) != 0)
            stop_write(out->journal);
        free(notes);
    }
    out->done = *done;
    json_decref(out->files);
    out->files = NULL;
    rewind(out->rows);
}

static void release(batch_output *out) {
    if (out->stream != stdout)
        fclose(out->stream);
    if (out->target && out->target != stdout)
        fclose(out->target);
    if (out->log)
        fclose(out->log);
    fclose(out->rows);
    for (size_t row = 0; row < out->done.n_rows; ++row)
        free(out->notes[row].remark);
    json_decref(out->files);
    json_decref(out->files_before);
    free(out->notes);
    free(out->text);
    free(out->path);
    free(out->part);
    free(out->journal);
}

void close_batch_output(batch_output *out, bool is_complete) {
    if (is_complete) {
        nqm_error err = {0};
        write_text(out);
        if (out->part && fsync(fileno(out->stream)) != 0)
            stop_write(out->path);
        if (out->part)
            must(nqm_replace(out->part, out->path, &err), &err);
        if (out->part && unlink(out->journal) != 0)
            stop_write(out->path);
    }
    release(out);
}

/* ---- sorted ------------------------------------------------------------------------------------------------------ */

/* Offset of each row in the unsorted text; free() it. */
static off_t *find_rows(const batch_output *out, size_t n_separator) {
    off_t *offset = allocate(out->done.n_rows, sizeof *offset), at = (off_t)out->n_head;
    for (size_t row = 0; row < out->done.n_rows; ++row) {
        at += (off_t)(row ? n_separator : 0);
        offset[row] = at;
        at += (off_t)out->notes[row].n_text;
    }
    return offset;
}

static void copy_text(const batch_output *out, off_t begin, size_t n, FILE *to) {
    char *text = allocate(n, 1);
    if (fseeko(out->stream, begin, SEEK_SET) != 0 || fread(text, 1, n, out->stream) != n || fwrite(text, 1, n, to) != n)
        stop_write(out->path);
    free(text);
}

static void copy_rows(const batch_output *out, const batch_form *form, size_t n, const size_t *order, FILE *to) {
    const char *separator = batch_separator(form);
    off_t *offset = find_rows(out, strlen(separator));
    copy_text(out, 0, out->n_head, to);
    for (size_t i = 0; i < n; ++i) {
        fputs(i ? separator : "", to);
        copy_text(out, offset[order[i]], out->notes[order[i]].n_text, to);
    }
    print_batch_tail(form, to);
    free(offset);
}

void close_batch_sorted(batch_output *out, const batch_form *form, size_t n, const size_t *order) {
    if (out->part) {
        output_file file;
        open_output(out->path, &file);
        copy_rows(out, form, n, order, file.stream);
        close_output(&file);
        if (unlink(out->part) != 0 || unlink(out->journal) != 0)
            stop_write(out->path);
    } else {
        copy_rows(out, form, n, order, out->target);
        if (fflush(out->target) != 0)
            stop_write(out->path);
    }
    release(out);
}
