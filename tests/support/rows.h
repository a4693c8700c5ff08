/* SPDX-License-Identifier: MIT
 *
 * rows.h - the tables of tests/unit/rows.txt: specs, texts and the words that they must give.
 */
#ifndef NQM_TESTS_ROWS_H
#define NQM_TESTS_ROWS_H

#include <nqm/base.h>

enum { MAX_COLUMNS = 8 };
typedef const char *table_row[MAX_COLUMNS];

/** The rows below "[name]": the parts of each line between " | ", in which "\n" is a new line. What a line lacks is NULL, and so is the
 *  row behind the last. n may be NULL. Fails if there is no such table. */
const table_row *table_rows(const char *name, size_t *n);

/** EVERY_ROW(row, "mistakes of specs") must_refuse(row[0], NQM_ERR_ARG, row[1]); */
#define EVERY_ROW(row, name) for (const char *const *row = *table_rows(name, NULL); row[0]; row += MAX_COLUMNS)

/** NQM_ERR_FORMAT of "FORMAT". */
nqm_status status_of(const char *word);

#endif
