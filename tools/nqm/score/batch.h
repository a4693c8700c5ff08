/* SPDX-License-Identifier: MIT
 *
 * batch.h - the results of `nqm batch` as text, and the unfinished file that a later run can go on with.
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

/** EXIT_OK, or a fault when a column of the list is called like one that the results add, or like another. */
int check_batch_columns(const batch_form *form);
/** What goes before the rows, a row with its columns of the list, what goes behind them. */
void print_batch_head(const batch_form *form, FILE *out);
void print_batch_row(const batch_form *form, FILE *out, size_t row, const nqm_score_result *result,
                     const nqm_error *err);
void print_batch_tail(const batch_form *form, FILE *out);

/* ---- the file (batch_output.c) ----------------------------------------------------------------------------------- */

/** How far an output has got. */
typedef struct batch_progress {
    bool begun; /* what goes before the rows is there */
    size_t n_rows, n_failed;
} batch_progress;

/** Standard output, a device, or a file: FILE.part until it is complete, with FILE.part.journal beside it, which says
 *  after every block how much of it is sound. */
typedef struct batch_output batch_output;

/**
 * Open. EXIT_OK, or the fault is reported and its exit code returned.
 *
 * @param path    NULL or "-": standard output
 * @param terms   what a run that goes on must have in common with the one before; an object of JSON scalars; lent
 * @param resume  go on with FILE.part, when there is one; only files can be
 * @param done    receives what is there already; zeros for a new file
 */
int open_batch_output(const char *path, const json_t *terms, bool resume, batch_output **out_ret, batch_progress *done);
/** Append complete rows and note in the journal that the file is sound up to here. As open_batch_output(). */
int append_batch_output(batch_output *out, const char *text, size_t n_bytes, const batch_progress *done);
/** Close. complete: append `tail` and let the file appear under its name; else what was written stays for a later run. As
 *  open_batch_output(). NULL is allowed. */
int close_batch_output(batch_output *out, bool complete, const char *tail, size_t n_tail);
/** The name of the unfinished file; NULL: rows go to standard output or a device. */
const char *batch_output_part(const batch_output *out);

#endif
