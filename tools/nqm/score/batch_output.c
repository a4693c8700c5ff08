/* SPDX-License-Identifier: MIT
 *
 * Output of `nqm batch`: rows in the order of the list are written while they are made, sorted ones to a temporary file first.
 */
#include "nqm/score/batch.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

static _Noreturn void stop_write(const batch_output *out) {
    stop(EXIT_OPEN, "%s: cannot write: %s", out->file.file.path ? out->file.file.path : "standard output",
         strerror(errno));
}

void open_batch_output(const char *path, const batch_form *form, bool is_sorted, batch_output *out) {
    *out = (batch_output){.max_rows = form->list->n_rows};
    open_output(path, &out->file);
    out->notes = allocate(out->max_rows, sizeof *out->notes);
    out->rows = is_sorted ? tmpfile() : out->file.stream;
    if (!out->rows)
        stop(EXIT_OPEN, "there is no place for a temporary file: %s", strerror(errno));
    print_batch_head(form, out->file.stream);
}

bool is_batch_file(const batch_output *out) {
    return out->file.file.temporary != NULL;
}

bool write_batch_row(batch_output *out, const batch_form *form, const batch_pieces *pieces, size_t at,
                     bool keep_going) {
    const size_t row = out->n_rows;
    const bool is_sorted = out->rows != out->file.stream;
    batch_note *note = &out->notes[row];
    *note = make_batch_note(form, row, &pieces->results[at], &pieces->errors[at]);
    const bool is_failed = !note->is_scored && !note->is_skipped;
    if (is_failed && !keep_going) {
        free(note->remark);
        return false;
    }
    if (is_sorted)
        note->begin = ftell(out->rows);
    else
        fputs(row ? batch_separator(form) : "", out->rows);
    print_batch_row(form, out->rows, row, &pieces->results[at], &pieces->textures[at], &pieces->errors[at]);
    if (is_sorted)
        note->end = ftell(out->rows);
    out->n_failed += is_failed;
    ++out->n_rows;
    return true;
}

void flush_batch_output(batch_output *out) {
    if (!is_batch_file(out))
        end_progress(); /* the progress line may be on the same terminal */
    if (fflush(out->rows) != 0 || ferror(out->rows))
        stop_write(out);
}

static void copy_row(const batch_output *out, const batch_note *note) {
    const size_t n = (size_t)(note->end - note->begin);
    char *text = allocate(n, 1);
    if (fseek(out->rows, note->begin, SEEK_SET) != 0 || fread(text, 1, n, out->rows) != n ||
        fwrite(text, 1, n, out->file.stream) != n)
        stop_write(out);
    free(text);
}

void close_batch_output(batch_output *out, const batch_form *form, size_t n, const size_t *order) {
    for (size_t i = 0; order && i < n; ++i) {
        fputs(i ? batch_separator(form) : "", out->file.stream);
        copy_row(out, &out->notes[order[i]]);
    }
    print_batch_tail(form, out->file.stream);
    if (fflush(out->file.stream) != 0)
        stop_write(out);
    if (out->rows != out->file.stream)
        fclose(out->rows);
    close_output(&out->file);
}
