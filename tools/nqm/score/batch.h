/* SPDX-License-Identifier: MIT
 *
 * batch.h - the results of `nqm batch`: as pieces that a later run finds again, as text, and what is made of all rows at the end:
 * the sorted output, JUnit XML, Markdown.
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
    const char **names; /* (n_rows) of the tests, NULL: none */
    const nqm_model *model;
    bool metrics[NQM_METRIC_COUNT]; /* metrics to write */
    bool has_textures;              /* columns of textures, too */
    char *columns;                  /* of results, for print_csv_line(); owned */
    score_gate gate;
    remark_terms terms;
} batch_form;

/** What is kept of a row after it has been written. */
typedef struct batch_note {
    double jod, jod_low, jod_high, delta_e, novelty; /* NaN: none */
    bool is_scored, is_identical;
    bool is_skipped; /* without a score, because both materials are refused alike */
    long begin, end; /* of a sorted output: where the temporary file has the row */
    char *remark;    /* error of a row without a score, warnings of the others; NULL: none; owned */
} batch_note;

/** Set the columns; report an error and exit when one of the list has the name of a result column or of another one of the list. */
void set_batch_columns(batch_form *form);

/* ---- results (batch_pieces.c): on failure, these report the error and exit --------------------------------------- */

/** The results of a list in pieces of equal numbers of rows, each of which is a file of a folder: several processes make them
 *  together, and a later run with the same terms finds them again. */
typedef struct batch_pieces {
    const nqm_pair_list *list;
    nqm_scorer *scorer;
    const nqm_model *model; /* that of the scorer, for textures */
    bool near_only;         /* of textures */
    char *folder;      /* absolute; NULL: none, results are computed when they are needed; lives as long as the run */
    bool is_shared;    /* the folder is that of --work, which remains */
    char *terms;       /* all that determines results, as JSON; owned */
    char identity[33]; /* hash of the terms: the beginning of the files' names */
    size_t size, n;    /* rows of a piece, number of pieces */
    size_t current;    /* the piece whose results are below, n: none */
    nqm_score_result *results; /* (size) */
    texture_numbers *textures; /* (size) NaN: not of a texture */
    nqm_error *errors;         /* (size) */
    json_t *files;             /* files that these results depend on, from identify_files(); NULL: no folder; owned */
    size_t n_scored;           /* rows that this process has scored */
    double begin_s;
} batch_pieces;

/**
 * Begin. list, scorer, model, near_only, folder and is_shared are set.
 *
 * @param terms   an object of scalars: all settings that determine results, the list and its root included
 * @param resume  of a folder that is not shared: use the pieces of an earlier run, which must have had the same terms; otherwise
 *                they are removed
 */
void open_batch_pieces(batch_pieces *pieces, const json_t *terms, bool resume);
/** Score all pieces together with the other processes of `r`. Returns when all files exist: an exit code, its error reported. */
int share_batch_pieces(batch_pieces *pieces, ranks r);
/** Have results, textures and errors of a piece, which has *n_ret rows. Returns an exit code, its error reported. */
int get_batch_piece(batch_pieces *pieces, size_t piece, size_t *n_ret);
/** Remove the file of a piece, so that a later run scores it again. */
void forget_batch_piece(batch_pieces *pieces, size_t piece);
/** Show how many pairs are done and the speed of this process. Returns nonzero after Ctrl-C. */
int show_batch_progress(const batch_pieces *pieces, size_t n_done, size_t n);
/** Free. is_complete: also remove the files, and the folder, unless it is shared. */
void close_batch_pieces(batch_pieces *pieces, bool is_complete);

/* ---- the output (batch_print.c): on failure, these report the error and exit ------------------------------------ */

/** Rows on their way to standard output, a device, or a file, which gets its name when it is complete. */
typedef struct batch_output {
    output_file file;
    FILE *rows; /* that of `file`, or a temporary file of rows that are sorted in the end */
    size_t n_rows, n_failed;
    batch_note *notes; /* (max_rows) of the rows that are written; they live as long as the run */
    size_t max_rows;
} batch_output;

/** Open, and print the text before the rows. path: absolute, or "-". */
void open_batch_output(const char *path, const batch_form *form, bool is_sorted, batch_output *out);
/** Whether it is a file, of which nothing is seen until it is complete. */
bool is_batch_file(const batch_output *out);
/** Write a row and its note. Returns false, and writes nothing, if the row fails and `keep_going` is not set. Rows whose
 *  materials are refused alike do not count as failed. */
bool write_batch_row(batch_output *out, const batch_form *form, const batch_pieces *pieces, size_t at, bool keep_going);
/** Pass on what is written. */
void flush_batch_output(batch_output *out);
/** Write the end of the output and close it. order: (n) the rows of a sorted output; NULL: all are written. */
void close_batch_output(batch_output *out, const batch_form *form, size_t n, const size_t *order);

/* ---- all rows (batch_print.c) ---------------------------------------------------------------------------------- */

/** The rows, worst first: those without a score, then by JOD, equal ones as in the list; or best first. free() it. */
size_t *order_batch_rows(size_t n, const batch_note *notes, bool is_best);

/** The rows of a finished run. */
typedef struct batch_summary {
    const batch_form *form;
    const char *list_name;
    size_t n_rows, n_unscored, n_skipped, n_gated; /* n_unscored: without the skipped ones; n_gated: below the gate */
    const batch_note *notes;                       /* (n_rows) */
    size_t *order;                                 /* (n_rows) worst first */
    size_t n_shown;                                /* rows of tables */
} batch_summary;

/** The summary of the rows of another verb. */
typedef struct row_summary {
    batch_form form;
    nqm_pair_list list;
    batch_note *notes; /* (n_rows) */
    batch_summary summary;
} row_summary;
void summarise_rows(const score_run *run, const char *list_name, size_t n_shown, row_summary *s);
void free_row_summary(row_summary *s);

/** free() `order`. */
batch_summary make_batch_summary(const batch_form *form, const char *list_name, size_t n_rows, const batch_note *notes);
/** A JUnit report: one test case per pair, in the order of the list; a failure for each pair below the gate, an error for each
 *  without a score. */
void print_batch_junit(const batch_summary *summary, FILE *out);
/** A table in Markdown, worst first. */
void print_batch_markdown(const batch_summary *summary, FILE *out);
/** Write one of them to a file; path NULL: nothing. */
void write_batch_summary(const batch_summary *summary, const char *path,
                         void (*print)(const batch_summary *summary, FILE *out));

#endif
