/* SPDX-License-Identifier: MIT
 *
 * rows.h - results as rows: each is a JSON object, of which other outputs name members by paths. CSV is a list of columns, and
 * pages and reports are templates (show/html.h).
 */
#ifndef NQM_TOOL_ROWS_H
#define NQM_TOOL_ROWS_H

#include "nqm/tool.h"

/** The value at a path of keys, as "interval.ci95.0". A key of a list is an index, or a word that selects the object whose "with" it
 *  is, or in which it is true. NULL: none. */
const json_t *value_at(const json_t *json, const char *path);
/** The same as a number; NaN: none. */
double number_at(const json_t *json, const char *path);

/** The texts of a list, separated by "; "; free() it. */
char *join_texts(const json_t *texts);

/** Bits of nqm_column_group. */
enum {
    COLUMNS_SCORE = 1 << NQM_COLUMN_SCORE,
    COLUMNS_PARTS = 1 << NQM_COLUMN_PARTS,
    COLUMNS_OF_LABEL = 1 << NQM_COLUMN_LABEL,
    COLUMNS_SIMILARITY = 1 << NQM_COLUMN_SIMILARITY,
    COLUMNS_METRICS = 1 << NQM_COLUMN_METRIC,
    COLUMNS_TEXTURE = 1 << NQM_COLUMN_TEXTURE,
    COLUMNS_BARE_TEXTURE = COLUMNS_TEXTURE << 1, /* the same as members of the row itself */
};
/** Members of an object from the columns of these groups (nqm_score_column()), in "parts" and the like where they belong; of metrics
 *  the chosen ones, NULL: all. What the result does not have is left out, or null. Returns row. */
json_t *set_columns(json_t *row, unsigned groups, const bool *metrics, const nqm_score_result *score,
                    const nqm_texture_result *texture);
/** The same as columns of print_csv_line(), between other ones. free() it. */
char *list_columns(const char *first, unsigned groups, const bool *metrics, const char *last);

/** A text of a row as it was given: those of JSON are UTF-8. */
typedef struct row_text {
    const char *column, *text; /* column NULL: the end of the list */
} row_text;
/**
 * Print a line of CSV. columns: headings with commas, each with the path of its value in the row if that is not the heading, as
 * "test,low=interval.ci95.0"; one before the first is printed, too. row NULL: the headings. texts: columns that have these texts;
 * NULL: none.
 */
void print_csv_line(FILE *out, const char *columns, const json_t *row, const row_text *texts);

/** The numbers of n keys in their ascending order, or with sign -1 in the descending one; equal ones by number, NaN last. free() it. */
size_t *order_by(size_t n, const double *keys, double sign);

#endif
