/* SPDX-License-Identifier: MIT
 *
 * batch.h - the results of `nqm batch` as text, and the unfinished output file that a later run can resume.
 */
#ifndef NQM_TOOL_BATCH_H
#define NQM_TOOL_BATCH_H

#include "nqm/score/pair_list.h"
#include "nqm/score/score.h"

/* ---- rows (batch_print.c) ---------------------------------------------------------------------------------------- */

typedef enum batch_format { BATCH_CSV, BATCH_JSON_LINES, BATCH_JSON } batch_format;

/** How rows are written. */
typedef struct batch_form {
    batch_format format;
    const nqm_pair_list *list;
    const nqm_model *model;
    nqm_precision precision;
    bool metrics[NQM_METRIC_COUNT]; /* which to write */
    remark_terms terms;
} batch_form;

/** Report an error and exit when a column of the list has the name of a result column or of another column of the list. */
void check_batch_columns(const batch_form *form);
/** Print the text before the rows; a row, which is the columns of the list and the result; the text after the rows. */
void print_batch_head(const batch_form *form, FILE *out);
void print_batch_row(const batch_form *form, FILE *out, size_t row, const nqm_score_result *result,
                     const nqm_error *err);
void print_batch_tail(const batch_form *form, FILE *out);

/* ---- the file (batch_output.c): on failure, these report the error and exit -------------------------------------- */

/** Progress of an output. */
typedef struct batch_progress {
    bool begun; /* the text before the rows was written */
    size_t n_rows, n_failed;
} batch_progress;

/** Standard output, a device, or a file. A file is named FILE.part until it is complete; FILE.part.journal records
 *  after every block how many bytes of it are valid. */
typedef struct batch_output {
    FILE *rows; /* to print to: text that is not written yet */
    char *text; /* (n_text) of `rows` */
    size_t n_text;
    FILE *stream;                /* FILE.part, a device, or standard output */
    char *path, *part, *journal; /* NULL: not a file */
    FILE *log;
    size_t n_bytes; /* of FILE.part */
    batch_progress done;
} batch_output;

/**
 * Open.
 *
 * @param path    NULL or "-": standard output
 * @param terms   settings that a resumed run must have in common with the interrupted run; a JSON object of scalars;
 *                borrowed
 * @param resume  continue FILE.part if it exists; an error for anything but a file
 * @param out     receives the output, whose `done` is the progress of the interrupted run; zeros for a new file
 */
void open_batch_output(const char *path, const json_t *terms, bool resume, batch_output *out);
/** Write the text of out->rows, which are complete rows, and record in the journal that the file is valid up to here. */
void append_batch_output(batch_output *out, const batch_progress *done);
/** Close. is_complete: write the text of out->rows and rename the file to its final name; otherwise FILE.part remains for a
 *  later run. */
void close_batch_output(batch_output *out, bool is_complete);

#endif
