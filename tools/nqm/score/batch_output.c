/* SPDX-License-Identifier: MIT
 *
 * Output of `nqm batch`. The rows of a file are written to FILE.part first. FILE.part.journal begins with the terms of
 * the run; after every block, a line with the number of rows, of failed rows and of bytes so far and the SHA-256 of the
 * block is appended. A killed run leaves both files. A run with --resume checks terms and hashes, truncates FILE.part to
 * the last checkpoint of the journal, and continues, so that the finished file is identical to that of an uninterrupted
 * run.
 */
#include "nqm/score/batch.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

static const char journal_mark[] = "nqm batch journal 2\n";

static _Noreturn void stop_write(const char *path) {
    stop(EXIT_OPEN, "%s: cannot write: %s", path ? path : "standard output", strerror(errno));
}

static void hash_text(const char *text, size_t n_bytes, char hex[65]) {
    nqm_sha256 sha;
    if (!nqm_sha256_begin(&sha))
        stop(EXIT_LIMIT, "out of memory");
    nqm_sha256_add(&sha, text, n_bytes);
    nqm_sha256_end(&sha, hex);
}

/* ---- the journal ------------------------------------------------------------------------------------------------- */

/* A line of the journal: the first n_bytes of FILE.part are valid. */
typedef struct checkpoint {
    batch_progress done;
    size_t n_bytes;
    char sha256[65];  /* of the bytes since the checkpoint before */
    long journal_end; /* offset of the byte after the line */
} checkpoint;

static _Noreturn void stop_damage(const batch_output *out) {
    stop(EXIT_MALFORMED, "%s does not match its journal: it is damaged; remove it to start again", out->part);
}

/* Compare the terms in the journal with those of this run; the message names the first that differs. */
static void compare_terms(const batch_output *out, const char *line, const json_t *terms) {
    json_t *before = json_loads(line, 0, NULL);
    if (!before)
        stop_damage(out);
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)(uintptr_t)terms, key, value) {
        if (!json_equal(value, json_object_get(before, key)))
            stop(EXIT_INCOMPATIBLE, "%s was begun with another %s: --resume needs the same; remove it to start again",
                 out->part, key);
    }
    json_decref(before);
}

static bool read_checkpoint(const char *line, checkpoint *c) {
    int n = 0;
    c->done.begun = true;
    return sscanf(line, "%zu %zu %zu %64[0-9a-f]%n", &c->done.n_rows, &c->done.n_failed, &c->n_bytes, c->sha256, &n) ==
               4 &&
           strlen(c->sha256) == 64 && line[n] == '\n' && !line[n + 1];
}

/* Compare the hash of the next n bytes of FILE.part. */
static void check_block(batch_output *out, size_t n, const char *sha256) {
    char hex[65], *block = allocate(n, 1);
    if (fread(block, 1, n, out->stream) != n)
        stop_damage(out);
    hash_text(block, n, hex);
    if (strcmp(hex, sha256) != 0)
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
        check_block(out, c.n_bytes - last.n_bytes, c.sha256);
        c.journal_end = ftell(out->log);
        last = c;
    }
    free(line);
    return last;
}

/* Truncate FILE.part and the journal to a checkpoint: both are in append mode. */
static void truncate_to(const batch_output *out, const checkpoint *c) {
    rewind(out->stream); /* from reading to writing */
    rewind(out->log);
    if (ftruncate(fileno(out->stream), (off_t)c->n_bytes) != 0 ||
        ftruncate(fileno(out->log), (off_t)c->journal_end) != 0)
        stop_write(out->part);
}

/* ---- opening ----------------------------------------------------------------------------------------------------- */

/* Absolute path of `path` with `suffix`, because --root changes the working folder later. free() it. */
static char *full_path(const char *path, const char *suffix) {
    char *folder = *path == '/' ? strdup("") : getcwd(NULL, 0);
    if (!folder)
        stop(EXIT_OPEN, "the working folder has no path: %s", strerror(errno));
    size_t n = strlen(folder) + strlen(path) + strlen(suffix) + 2;
    char *full = allocate(n, 1);
    snprintf(full, n, "%s%s%s%s", folder, *path == '/' ? "" : "/", path, suffix);
    free(folder);
    return full;
}

/* Open for reading and appending; create the file if it does not exist. */
static FILE *open_kept(const char *path) {
    FILE *stream = fopen(path, "a+e");
    if (!stream)
        stop_write(path);
    return stream;
}

static void open_part(batch_output *out, const char *path, const json_t *terms, bool resume) {
    out->path = full_path(path, "");
    out->part = full_path(path, ".part");
    out->journal = full_path(path, ".part.journal");
    bool goes_on =
        resume && access(out->part, F_OK) == 0; /* only a journal remains when a run was killed after the rename */
    if (goes_on && access(out->journal, F_OK) != 0)
        stop(EXIT_INCOMPATIBLE, "%s has no journal next to it: remove it to start again", out->part);
    out->log = open_kept(out->journal);
    if (flock(fileno(out->log), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
        stop(EXIT_OPEN, "%s: another run is writing it", out->part);
    out->stream = open_kept(out->part);
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

void open_batch_output(const char *path, const json_t *terms, bool resume, batch_output *out) {
    *out = (batch_output){.stream = stdout};
    out->rows = open_memstream(&out->text, &out->n_text);
    if (!out->rows)
        stop(EXIT_LIMIT, "out of memory");
    struct stat st;
    bool standard = !path || strcmp(path, "-") == 0;
    bool device = !standard && stat(path, &st) == 0 && !S_ISREG(st.st_mode);
    if (resume && (standard || device))
        stop(EXIT_USAGE, "--resume needs a file: -o FILE");
    if (device) {
        out->stream = fopen(path, "w");
        if (!out->stream)
            stop_write(path);
    } else if (!standard) {
        open_part(out, path, terms, resume);
    }
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

static void write_text(batch_output *out) {
    if (fflush(out->rows) != 0 || ferror(out->rows))
        stop(EXIT_LIMIT, "out of memory");
    if (!out->part)
        end_progress(); /* the progress line may be on the same terminal */
    if (fwrite(out->text, 1, out->n_text, out->stream) != out->n_text || fflush(out->stream) != 0)
        stop_write(out->part);
}

void append_batch_output(batch_output *out, const batch_progress *done) {
    write_text(out);
    out->done = *done;
    if (out->part) {
        char sha256[65];
        out->n_bytes += out->n_text;
        hash_text(out->text, out->n_text, sha256);
        fprintf(out->log, "%zu %zu %zu %s\n", done->n_rows, done->n_failed, out->n_bytes, sha256);
        if (fflush(out->log) != 0)
            stop_write(out->journal);
    }
    rewind(out->rows);
}

void close_batch_output(batch_output *out, bool is_complete) {
    if (is_complete) {
        write_text(out);
        if (out->part &&
            (fsync(fileno(out->stream)) != 0 || rename(out->part, out->path) != 0 || unlink(out->journal) != 0))
            stop_write(out->path);
    }
    if (out->stream != stdout)
        fclose(out->stream);
    if (out->log)
        fclose(out->log);
    fclose(out->rows);
    free(out->text);
    free(out->path);
    free(out->part);
    free(out->journal);
}
