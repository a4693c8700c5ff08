/* SPDX-License-Identifier: MIT
 *
 * rows.c - read tests/unit/rows.txt once.
 */
#include "support/rows.h"
#include "support/check.h"

enum { MAX_BYTES = 1 << 17, MAX_ROWS = 2000 };

static char text[MAX_BYTES];
static table_row rows[MAX_ROWS]; /* "[name]", its rows, and a row of NULL, for each table */
static size_t n_rows;

static void add_line(char *line) {
    for (char *at = line; (at = strstr(at, "\\n")); ++at) {
        *at = '\n';
        memmove(at + 1, at + 2, strlen(at + 1));
    }
    assert_true(n_rows + 2 < MAX_ROWS);
    n_rows += *line == '['; /* the row of NULL of the table before */
    for (size_t column = 0; line; ++column) {
        char *end = strstr(line, " | ");
        assert_true(column < MAX_COLUMNS);
        rows[n_rows][column] = line;
        line = end ? end + 3 : NULL;
        if (end)
            *end = 0;
    }
    ++n_rows;
}

static void read_rows(void) {
    char *rest = text, *line;
    FILE *file = fopen(test_vector("../unit/rows.txt"), "r");
    assert_non_null(file);
    const size_t n = fread(text, 1, MAX_BYTES - 1, file);
    assert_true(n < MAX_BYTES - 1);
    fclose(file);
    while ((line = strsep(&rest, "\n")))
        if (*line && *line != '#')
            add_line(line);
}

const table_row *table_rows(const char *name, size_t *n) {
    char wanted[100];
    if (!n_rows)
        read_rows();
    snprintf(wanted, sizeof wanted, "[%s]", name);
    size_t i = 0, end;
    while (i < n_rows && !(rows[i][0] && strcmp(rows[i][0], wanted) == 0))
        ++i;
    if (i == n_rows || !rows[i + 1][0])
        fail_msg("no table %s", wanted);
    for (end = ++i; rows[end][0];)
        ++end;
    if (n)
        *n = end - i;
    return &rows[i];
}

nqm_status status_of(const char *word) {
    static const char *const words[] = {"OK", "ARG", "IO", "FORMAT", "INCOMPATIBLE", "MODEL", "NOMEM", "LIMIT"};
    for (int i = 0; i < 8; ++i)
        if (strcmp(words[i], word) == 0)
            return (nqm_status)-i;
    fail_msg("no status %s", word);
    return NQM_OK;
}
