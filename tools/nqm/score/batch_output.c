/* SPDX-License-Identifier: MIT
 *
 * Output of `nqm batch`. The rows of a file are written to FILE.part first. FILE.part.journal begins with the terms of
 * the run; after every block, a line with the number of rows, of failed rows and of bytes so far and the SHA-256 of
 * these bytes is appended. A killed run leaves both files. A run with --resume checks terms and hash, truncates
 * FILE.part to the last checkpoint of the journal, and continues, so that the finished file is identical to that of an
 * uninterrupted run.
 */
#include "nqm/score/batch.h"

#include <errno.h>
#include <fcntl.h>
#include <openssl/evp.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

static const char journal_mark[] = "nqm batch journal 1\n";

struct batch_output {
    FILE *stream;                /* FILE.part, a device, or standard output */
    char *path, *part, *journal; /* NULL: not a file */
    FILE *log;
    EVP_MD_CTX *sha; /* of all bytes so far */
    unsigned long long n_bytes;
};

static int cannot_write(const char *path) {
    return report("batch", EXIT_OPEN, "%s: cannot write: %s", path ? path : "standard output", strerror(errno));
}

static int out_of_memory(void) {
    return report("batch", EXIT_LIMIT, "out of memory");
}

const char *batch_output_part(const batch_output *out) {
    return out->part;
}

static void free_output(batch_output *out) {
    if (out->stream && out->stream != stdout)
        fclose(out->stream);
    if (out->log)
        fclose(out->log);
    EVP_MD_CTX_free(out->sha);
    free(out->path);
    free(out->part);
    free(out->journal);
    free(out);
}

/* ---- the hash ---------------------------------------------------------------------------------------------------- */

/* SHA-256 of all bytes so far, as hex digits. It works on a copy of `sha`, so that more bytes can be added. */
static bool hash_so_far(const EVP_MD_CTX *sha, char hex[65]) {
    unsigned char digest[EVP_MAX_MD_SIZE];
    unsigned n = 0;
    EVP_MD_CTX *copy = EVP_MD_CTX_new();
    bool good = copy && EVP_MD_CTX_copy_ex(copy, sha) == 1 && EVP_DigestFinal_ex(copy, digest, &n) == 1 && n == 32;
    for (unsigned i = 0; good && i < n; ++i)
        snprintf(hex + 2 * i, 3, "%02x", digest[i]);
    EVP_MD_CTX_free(copy);
    return good;
}

/* Add the first n bytes of FILE.part to the hash; false when it has fewer. */
static bool hash_part(batch_output *out, unsigned long long n) {
    char block[65536];
    while (n > 0) {
        size_t n_read = fread(block, 1, n < sizeof block ? (size_t)n : sizeof block, out->stream);
        if (n_read == 0 || EVP_DigestUpdate(out->sha, block, n_read) != 1)
            return false;
        n -= n_read;
    }
    return true;
}

/* ---- the journal ------------------------------------------------------------------------------------------------- */

/* A line of the journal: the first n_bytes of FILE.part are valid. */
typedef struct checkpoint {
    batch_progress done;
    unsigned long long n_bytes;
    char sha256[65];
    long journal_end; /* offset of the byte after the line */
} checkpoint;

static int report_damage(const batch_output *out) {
    return report("batch", EXIT_MALFORMED, "%s is not what its journal says: it is damaged; remove it to begin anew",
                  out->part);
}

/* Compare the terms in the journal with those of this run; the message names the first that differs. */
static int compare_terms(const batch_output *out, const char *line, const json_t *terms) {
    json_t *before = json_loads(line, 0, NULL);
    if (!before)
        return report_damage(out);
    const char *key;
    json_t *value;
    int exit_code = EXIT_OK;
    json_object_foreach((json_t *)(uintptr_t)terms, key, value) {
        if (exit_code == EXIT_OK && !json_equal(value, json_object_get(before, key)))
            exit_code = report("batch", EXIT_INCOMPATIBLE,
                               "%s was begun with another %s: --resume needs the same; remove it to begin anew",
                               out->part, key);
    }
    json_decref(before);
    return exit_code;
}

static bool read_checkpoint(const char *line, checkpoint *c) {
    int n = 0;
    c->done.begun = true;
    return sscanf(line, "%zu %zu %llu %64[0-9a-f]%n", &c->done.n_rows, &c->done.n_failed, &c->n_bytes, c->sha256, &n) ==
               4 &&
           strlen(c->sha256) == 64 && line[n] == '\n' && !line[n + 1];
}

/* Find the last checkpoint whose bytes FILE.part contains. journal_end is 0 when there is none: the run was killed
 * before its first checkpoint. */
static int read_journal(batch_output *out, const json_t *terms, checkpoint *last) {
    struct stat st;
    char *line = NULL;
    size_t room = 0;
    int exit_code = EXIT_OK;
    *last = (checkpoint){0};
    if (fstat(fileno(out->stream), &st) != 0)
        return cannot_write(out->part);
    for (size_t number = 0; exit_code == EXIT_OK; ++number) {
        ssize_t n = getline(&line, &room, out->log);
        if (n <= 0 || line[n - 1] != '\n') /* end of file, or an incomplete line */
            break;
        checkpoint c = {0};
        if (number == 0) {
            exit_code = strcmp(line, journal_mark) == 0 ? EXIT_OK : report_damage(out);
        } else if (number == 1) {
            exit_code = compare_terms(out, line, terms);
        } else if (!read_checkpoint(line, &c)) {
            exit_code = report_damage(out);
        } else if (c.n_bytes <= (unsigned long long)st.st_size) {
            c.journal_end = ftell(out->log);
            *last = c;
        }
    }
    free(line);
    return exit_code;
}

static int begin_journal(batch_output *out, const json_t *terms) {
    char *text = json_dumps(terms, JSON_COMPACT);
    if (!text)
        return out_of_memory();
    rewind(out->log);
    bool bad = ftruncate(fileno(out->log), 0) != 0 || ftruncate(fileno(out->stream), 0) != 0;
    bad = bad || fprintf(out->log, "%s%s\n", journal_mark, text) < 0 || fflush(out->log) != 0;
    free(text);
    return bad ? cannot_write(out->journal) : EXIT_OK;
}

/* Verify the hash, truncate FILE.part and the journal to the checkpoint, and position both at their end. */
static int continue_part(batch_output *out, const checkpoint *last) {
    char sha256[65] = "";
    rewind(out->stream);
    if (!hash_part(out, last->n_bytes) || !hash_so_far(out->sha, sha256) || strcmp(sha256, last->sha256) != 0)
        return report_damage(out);
    out->n_bytes = last->n_bytes;
    if (ftruncate(fileno(out->stream), (off_t)last->n_bytes) != 0 ||
        ftruncate(fileno(out->log), (off_t)last->journal_end) != 0 || fseek(out->stream, 0, SEEK_END) != 0 ||
        fseek(out->log, 0, SEEK_END) != 0)
        return cannot_write(out->part);
    return EXIT_OK;
}

/* ---- opening ----------------------------------------------------------------------------------------------------- */

/* Absolute path of `path` with `suffix`, because --root changes the working folder later. free() it. */
static char *full_path(const char *path, const char *suffix) {
    char *folder = *path == '/' ? strdup("") : getcwd(NULL, 0);
    size_t n = folder ? strlen(folder) + strlen(path) + strlen(suffix) + 2 : 0;
    char *full = folder ? malloc(n) : NULL;
    if (full)
        snprintf(full, n, "%s%s%s%s", folder, *path == '/' ? "" : "/", path, suffix);
    free(folder);
    return full;
}

/* Open for reading and writing; create the file if it does not exist. */
static FILE *open_kept(const char *path) {
    int fd = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    FILE *stream = fd < 0 ? NULL : fdopen(fd, "r+");
    if (fd >= 0 && !stream)
        close(fd);
    return stream;
}

static int open_part(batch_output *out, const char *path, const json_t *terms, bool resume, batch_progress *done) {
    out->path = full_path(path, "");
    out->part = full_path(path, ".part");
    out->journal = full_path(path, ".part.journal");
    out->sha = EVP_MD_CTX_new();
    if (!out->path || !out->part || !out->journal || !out->sha || EVP_DigestInit_ex(out->sha, EVP_sha256(), NULL) != 1)
        return out_of_memory();
    bool goes_on =
        resume && access(out->part, F_OK) == 0; /* only a journal remains when a run was killed after the rename */
    if (goes_on && access(out->journal, F_OK) != 0)
        return report("batch", EXIT_INCOMPATIBLE, "%s has no journal beside it: remove it to begin anew", out->part);
    out->log = open_kept(out->journal);
    if (!out->log)
        return cannot_write(out->journal);
    if (flock(fileno(out->log), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
        return report("batch", EXIT_OPEN, "%s: another run is writing it", out->part);
    out->stream = open_kept(out->part);
    if (!out->stream)
        return cannot_write(out->part);
    checkpoint last = {0};
    int exit_code = goes_on ? read_journal(out, terms, &last) : EXIT_OK;
    if (exit_code != EXIT_OK)
        return exit_code;
    if (last.journal_end == 0)
        return begin_journal(out, terms);
    *done = last.done;
    return continue_part(out, &last);
}

int open_batch_output(const char *path, const json_t *terms, bool resume, batch_output **out_ret,
                      batch_progress *done) {
    *out_ret = NULL;
    *done = (batch_progress){0};
    struct stat st;
    bool standard = !path || strcmp(path, "-") == 0;
    bool device = !standard && stat(path, &st) == 0 && !S_ISREG(st.st_mode);
    if (resume && (standard || device))
        return report("batch", EXIT_USAGE, "--resume needs a file: -o FILE");
    batch_output *out = calloc(1, sizeof *out);
    if (!out)
        return out_of_memory();
    int exit_code = EXIT_OK;
    if (standard) {
        out->stream = stdout;
    } else if (device) {
        out->stream = fopen(path, "w");
        exit_code = out->stream ? EXIT_OK : cannot_write(path);
    } else {
        exit_code = open_part(out, path, terms, resume, done);
    }
    if (exit_code == EXIT_OK)
        *out_ret = out;
    else
        free_output(out);
    return exit_code;
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

static bool write_all(batch_output *out, const char *text, size_t n_bytes) {
    return fwrite(text, 1, n_bytes, out->stream) == n_bytes && fflush(out->stream) == 0;
}

int append_batch_output(batch_output *out, const char *text, size_t n_bytes, const batch_progress *done) {
    if (!out->part)
        end_progress(); /* the progress line may be on the same terminal */
    if (!write_all(out, text, n_bytes))
        return cannot_write(out->part);
    if (!out->part)
        return EXIT_OK;
    char sha256[65];
    out->n_bytes += n_bytes;
    if (EVP_DigestUpdate(out->sha, text, n_bytes) != 1 || !hash_so_far(out->sha, sha256))
        return out_of_memory();
    bool bad = fprintf(out->log, "%zu %zu %llu %s\n", done->n_rows, done->n_failed, out->n_bytes, sha256) < 0;
    return fflush(out->log) != 0 || bad ? cannot_write(out->journal) : EXIT_OK;
}

int close_batch_output(batch_output *out, bool complete, const char *tail, size_t n_tail) {
    if (!out)
        return EXIT_OK;
    int exit_code = EXIT_OK;
    if (complete) {
        bool bad = !write_all(out, tail, n_tail);
        if (out->part)
            bad = bad || fsync(fileno(out->stream)) != 0 || rename(out->part, out->path) != 0 ||
                  unlink(out->journal) != 0;
        if (bad)
            exit_code = cannot_write(out->path);
    }
    free_output(out);
    return exit_code;
}
