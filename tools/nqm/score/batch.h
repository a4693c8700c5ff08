/* SPDX-License-Identifier: MIT
 *
 * batch.h - the results of `nqm batch` as pieces that a later run finds again, and what is made of all rows at the end: their order,
 * JUnit XML, Markdown.
 */
#ifndef NQM_TOOL_BATCH_H
#define NQM_TOOL_BATCH_H

#include "nqm/score/score.h"

/* ---- results (batch_pieces.c): on failure, these report the error and exit --------------------------------------- */

/** The results of a list in pieces of equal numbers of rows, each of which is a file of a folder: several processes make them
 *  together, and a later run with the same terms finds them again. */
typedef struct batch_pieces {
    const nqm_pairs *list;
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

/* ---- all rows (batch_summary.c) ---------------------------------------------------------------------------------- */

/** What is kept of a row after it has been written. */
typedef struct batch_note {
    const nqm_named_pair *pair;                      /* lives as long as the run */
    const char *name;                                /* of the test */
    double jod, jod_low, jod_high, delta_e, novelty; /* NaN: none */
    bool is_scored, is_identical;
    bool is_skipped; /* without a score, because both materials are refused alike */
    long begin, end; /* of a sorted output: where the temporary file has the row */
    char *remark;    /* error of a row without a score, warnings of the others; NULL: none; owned */
} batch_note;

batch_note make_batch_note(const remark_terms *terms, const nqm_named_pair *pair, const char *name,
                           const nqm_score_result *result, const nqm_error *err);
/** The rows, worst first: those without a score, then by JOD, equal ones as in the list; or best first. free() it. */
size_t *order_batch_rows(size_t n, const batch_note *notes, bool is_best);

/** The rows of a finished run. */
typedef struct batch_summary {
    const nqm_model *model;
    const score_gate *gate;
    const char *list_name;
    size_t n_rows, n_unscored, n_skipped, n_gated; /* n_unscored: without the skipped ones; n_gated: below the gate */
    const batch_note *notes;                       /* (n_rows) */
    size_t *order;                                 /* (n_rows) worst first */
    size_t n_shown;                                /* rows of tables */
} batch_summary;

/** The summary of the rows of another verb. */
typedef struct row_summary {
    batch_note *notes; /* (n_rows) */
    batch_summary summary;
} row_summary;
void summarise_rows(const score_run *run, const char *list_name, size_t n_shown, row_summary *s);
void free_row_summary(row_summary *s);

/** free() `order`. */
batch_summary make_batch_summary(const nqm_model *model, const score_gate *gate, const char *list_name, size_t n_rows,
                                 const batch_note *notes);
/** A JUnit report: one test case per pair, in the order of the list; a failure for each pair below the gate, an error for each
 *  without a score. */
void print_batch_junit(const batch_summary *summary, FILE *out);
/** A table in Markdown, worst first. */
void print_batch_markdown(const batch_summary *summary, FILE *out);
/** Write one of them to a file; path NULL: nothing. */
void write_batch_summary(const batch_summary *summary, const char *path,
                         void (*print)(const batch_summary *summary, FILE *out));

#endif
