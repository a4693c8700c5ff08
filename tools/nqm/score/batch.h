/* SPDX-License-Identifier: MIT
 *
 * batch.h - the results of `nqm batch` as text, the unfinished output file that a later run can resume, and what is
 * made of all rows at the end: the sorted file, JUnit XML, Markdown.
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
    score_gate gate;
    remark_terms terms;
} batch_form;

/** What is kept of a row after it has been written. */
typedef struct batch_note {
    double jod, jod_low, jod_high, delta_e, novelty; /* NaN: none */
    bool is_scored, is_identical;
    bool is_skipped; /* without a score, because both materials are refused alike */
    size_t n_text;   /* bytes of the row in the output, without the text that separates rows */
    char *remark;    /* error of a row without a score, warnings of the others; NULL: none; owned */
} batch_note;

/** The note of a result; it has no n_text. free() the remark. */
batch_note make_batch_note(const batch_form *form, size_t row, const nqm_score_result *result, const nqm_error *err);
/** The members of a result that a note has; the others are NaN and 0. */
nqm_score_result noted_result(const batch_note *note);

/** Report an error and exit when a column of the list has the name of a result column or of another column of the list. */
void check_batch_columns(const batch_form *form);
/** Print the text before the rows; a row, which is the columns of the list and the result; the text after the rows. */
void print_batch_head(const batch_form *form, FILE *out);
void print_batch_row(const batch_form *form, FILE *out, size_t row, const nqm_score_result *result,
                     const texture_numbers *texture, const nqm_error *err);
void print_batch_tail(const batch_form *form, FILE *out);
/** The text before each row but the first. */
const char *batch_separator(const batch_form *form);

/* ---- files that rows depend on (batch_files.c) ------------------------------------------------------------------- */

/** An object with the path of each file that the pairs name, and its identity. Relative paths begin in the working folder. */
json_t *identify_files(size_t n, const nqm_named_pair *pairs);
/** The first path of such an object whose file has another identity now; NULL: none. */
const char *find_changed_file(const json_t *files);

/* ---- the file (batch_output.c): on failure, these report the error and exit -------------------------------------- */

/** Progress of an output. */
typedef struct batch_progress {
    bool begun; /* the text before the rows was written */
    size_t n_rows, n_failed;
} batch_progress;

/** Standard output, a device, or a file. A file is named FILE.part until it is complete; FILE.part.journal records
 *  after every block how many bytes of it are valid, and the notes of its rows. */
typedef struct batch_output {
    FILE *rows; /* stream for rows that are not written to the file yet */
    char *text; /* (n_text) of `rows` */
    size_t n_text;
    FILE *stream; /* FILE.part, a device, standard output, or a temporary file that is copied there in the end */
    FILE *target; /* stream to which a temporary file is copied; NULL: none */
    char *path, *part, *journal; /* NULL: not a file */
    FILE *log;
    size_t n_bytes, n_head; /* bytes of FILE.part; bytes before its first row */
    batch_progress done;
    size_t max_rows;
    batch_note *notes;    /* (max_rows) of the rows that are written; owned */
    json_t *files;        /* files that the rows since the last checkpoint depend on; NULL: none; owned */
    json_t *files_before; /* files that the rows of the interrupted run depend on; owned */
} batch_output;

/** How to open an output. */
typedef struct batch_request {
    const char *path; /* NULL or "-": standard output */
    const json_t
        *terms;     /* settings that a resumed run must have in common with the interrupted run: an object of scalars */
    bool resume;    /* continue FILE.part if it exists; an error for anything but a file */
    bool is_sorted; /* finish_batch_sorted() will be called */
    bool may_help;  /* another run with the same terms may be writing the file */
    size_t max_rows;
} batch_request;

/** Open. `done` of the result is the progress of the interrupted run, zeros for a new file. false: another run is writing the file
 *  (only with `may_help`), and nothing is open. */
bool open_batch_output(const batch_request *request, batch_output *out);
/** After that: wait for the end of the other run, and open the output if that run left it unfinished. false: it is finished. */
bool take_over_batch_output(const batch_request *request, batch_output *out);
/** Report an error and exit if a file that the rows of the interrupted run depend on has changed. */
void check_batch_files(const batch_output *out);
/** Write the text of out->rows, which are complete rows whose notes and files are set, and record in the journal that
 *  the file is valid up to here. */
void append_batch_output(batch_output *out, const batch_progress *done);
/** Close. is_complete: write the text of out->rows and rename the file to its final name; otherwise FILE.part remains for a
 *  later run. */
void close_batch_output(batch_output *out, bool is_complete);
/** Close a complete output whose rows are to be the n rows `order`, one after the other. */
void close_batch_sorted(batch_output *out, const batch_form *form, size_t n, const size_t *order);

/* ---- all rows (batch_summary.c) ---------------------------------------------------------------------------------- */

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

/** free() `order`. */
batch_summary make_batch_summary(const batch_form *form, const char *list_name, const batch_output *out);
/** A JUnit report: one test case per pair, in the order of the list; a failure for each pair below the gate, an error for each
 *  without a score. */
void print_batch_junit(const batch_summary *summary, FILE *out);
/** A table in Markdown, worst first. */
void print_batch_markdown(const batch_summary *summary, FILE *out);
/** Write one of them to a file; path NULL: nothing. */
void write_batch_summary(const batch_summary *summary, const char *path,
                         void (*print)(const batch_summary *summary, FILE *out));

#endif
