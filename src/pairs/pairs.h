/* SPDX-License-Identifier: MIT
 *
 * pairs.h - inside the library: cells and names of lists, the materials of files that are named again and again, and words for scores.
 */
#ifndef NQM_SRC_PAIRS_H
#define NQM_SRC_PAIRS_H

#include "argument/argument.h"
#include "io/io.h"
#include <nqm/pairs.h>

enum { NQM_LIST_MAX_COLUMNS = 1024 }; /**< limit of the columns; JSON Lines: of the distinct member names of all rows */

/** The value of a row in one column. */
typedef struct nqm_pairs_cell {
    size_t column;
    const char *text; /**< UTF-8 as in the file; JSON text when is_json */
    bool is_json;     /**< `text` is a number, true, null, an array or an object of JSON; else it is a plain string */
} nqm_pairs_cell;

/** What made pairs consist of. */
struct nqm_pairs_state {
    nqm_named_pair *pair;
    const char **column;
    char hash[65];
    char *path;        /**< of a list, for messages */
    nqm_csv *csv;      /**< owns the names and texts of a list; NULL: JSON Lines, whose cells are stored in: */
    size_t *row_begin; /**< (n + 1) first cell of each row */
    size_t n_cells, max_cells;
    uint32_t *cell; /**< (n_cells) column, and whether the text is JSON */
    nqm_names text; /**< (n_cells) */
    /* of expanded pairs: */
    const nqm_pairs *of;
    const char **name;
    size_t *row;
    bool *is_made; /**< (n) the pair is one of several materials */
    size_t n_owned, max_owned;
    char **owned; /**< (n_owned) texts */
    size_t n_left_out, max_left_out;
    const char **left_out;
};

/** Cell i of a row, in the order of the row; false: it has fewer. Rows of JSON Lines may lack columns; pairs that are expanded have the
 *  cells of the row that they stand for, but their own reference and test. */
bool nqm_pairs_get_cell(const nqm_pairs *pairs, size_t row, size_t i, nqm_pairs_cell *cell);
/** As nqm_pairs_read(), from memory; `name` is for messages. */
NQM_MUST_CHECK nqm_status nqm_pairs_parse(const char *text, size_t n_bytes, const char *name, nqm_pairs **pairs_ret,
                                          nqm_error *err);

/* ---- names ------------------------------------------------------------------------------------------------------- */

/** The name of a BRDF among those that must differ: of one group and one reference. */
typedef struct nqm_pairs_name {
    size_t group, row; /* row: of a list, from 1; 0: an argument */
    const char *reference, *name;
} nqm_pairs_name;
/** Refuse names with control characters, and equal ones; sorts them. list: the name of the list that has them (NQM_ERR_FORMAT);
 *  NULL: arguments (NQM_ERR_ARG). */
NQM_MUST_CHECK nqm_status nqm_pairs_check_names(size_t n, nqm_pairs_name *names, const char *list, nqm_error *err);

/* ---- materials of files ------------------------------------------------------------------------------------------ */

/** Whether both members are materials that are refused for the same property, value and reason. */
bool nqm_pairs_refused_alike(nqm_argument_files *files, const nqm_named_pair *pair);
/** "A:B", or one of them where the other is ""; nqm_free() it. NULL: out of memory. */
char *nqm_pairs_join(const char *a, const char *b);

/* ---- words ------------------------------------------------------------------------------------------------------- */

/** Whether the rows of a list are more than 0.1 degrees from a model's directions: text (n) says how far. distance_deg: median, 95 %. */
bool nqm_pairs_describe_distance(const char *argument, const double distance_deg[2], size_t n, char *text);
/** What "ignore:WORDS:" of an argument means, for people; false: it has none. */
bool nqm_pairs_describe_ignored(const char *argument, size_t n, char *text);
enum { NQM_VERDICT_TEXT = 64 };
/** What a score means, in words that are not more certain than its interval: "visible", "between visible and very different",
 *  "identical"; "" without a score. text: (NQM_VERDICT_TEXT). Returns text or a static string. */
const char *nqm_verdict(const nqm_score_result *result, char *text);
/** A JOD below 10 in words; the table is in doc/cli.md. */
const char *nqm_verdict_words(double jod);
/** Fraction of people who would say that the reference looks better; 0.5 is guessing. */
double nqm_verdict_preference(const nqm_score_result *result);

#endif
