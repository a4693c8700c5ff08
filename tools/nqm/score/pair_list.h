/* SPDX-License-Identifier: MIT
 *
 * pair_list.h - lists of pairs that are named by files, specs and presets, from CSV or JSON Lines.
 */
#ifndef PAIR_LIST_H
#define PAIR_LIST_H

#include "base/names.h"
#include "io/io.h"

#include <nqm/metric.h>
#include <stdbool.h>

/** The value of a row in one column. */
typedef struct nqm_list_cell {
    size_t column;
    const char *text; /**< UTF-8 as in the file; JSON text when is_json */
    int is_json;      /**< 1: `text` is JSON (a number, true, null, an array or an object); 0: it is a plain string */
} nqm_list_cell;

/** A pair that can be scored, for one of the materials of a file (below). */
typedef struct expanded_pair {
    nqm_named_pair pair;
    const char *name; /* name of the test; NULL: none */
    size_t origin;    /* index of the pair that it stands for */
    bool is_made;     /* the texts are owned: "FILE:NAME", "FILE:NAME", "NAME:NAME" */
    bool is_owned[2]; /* ref and test: also "ignore:...:FILE" */
} expanded_pair;

enum { NQM_LIST_MAX_COLUMNS = 1024 }; /**< limit of the columns; JSON Lines: of the distinct member names of all rows */

/** A list of pairs with any further columns. */
typedef struct nqm_pair_list {
    size_t n_rows;
    nqm_named_pair *pair; /**< (n_rows) in the order of the list; in one block with the other arrays */
    size_t n_columns;
    const char **column; /**< (n_columns) names, in the order of the header or of their first appearance */
    char sha256[65];     /**< SHA-256 of the list, hex digits */
    const struct expanded_pair
        *expanded;     /**< (n_rows) of an expanded list: whose cells they are, and names; NULL: their own */
    nqm_csv *csv;      /**< owns the names and texts; NULL: JSON Lines, whose cells are stored in: */
    size_t *row_begin; /**< (n_rows + 1) first cell of each row */
    size_t n_cells, max_cells;
    uint32_t *cell; /**< (n_cells) column, and NQM_LIST_JSON if the text is JSON */
    nqm_names text; /**< (n_cells) */
} nqm_pair_list;

/** The number of cells of a row; rows of JSON Lines may lack columns. */
size_t nqm_pair_list_cells(const nqm_pair_list *list, size_t row);
/** Cell i of a row, in the order of the row. */
nqm_list_cell nqm_pair_list_cell(const nqm_pair_list *list, size_t row, size_t i);

/**
 * Read a list: CSV with a header that names the columns `reference` and `test` (ASCII case ignored), or JSON Lines with
 * strings "reference" and "test" in each line (files.md). The format is detected from the first byte that is not a
 * blank: '{' means JSON Lines. Other columns are kept unchanged. The memory of a list is at most ten times its bytes.
 *
 * @return NQM_ERR_IO, NQM_ERR_FORMAT (the message names line and byte), NQM_ERR_LIMIT, NQM_ERR_NOMEM
 */
NQM_MUST_CHECK nqm_status nqm_pair_list_load(const char *path, nqm_pair_list **list_ret, nqm_error *err);
/** Free a list; NULL is allowed. */
void nqm_pair_list_free(nqm_pair_list *list);
/** As nqm_pair_list_load(), from memory; `name` is for messages. */
NQM_MUST_CHECK nqm_status nqm_pair_list_parse(const char *text, size_t n_bytes, const char *name,
                                              nqm_pair_list **list_ret, nqm_error *err);

/* ---- pairs of files of several materials -------------------------------------------------------------------------- */

typedef struct expansion {
    size_t n, max_n;
    expanded_pair *pairs; /* (n) in the order of the given pairs, materials in that of their file */
} expansion;

/**
 * A test that is a file of several materials stands for a pair with each of them. If the reference is such a file, too, its
 * materials are paired with those of the same names; one that the test lacks is a pair that cannot be opened, and one that only the
 * test has is reported and left out. Other pairs remain.
 *
 * @param names  (n) of the tests, NULL where there is none; NULL: there are none. Names of materials are appended.
 */
void expand_pairs(size_t n, const nqm_named_pair *pairs, const char *const *names, expansion *expansion);
/** The texts of its pairs are freed, too. */
void free_expansion(expansion *expansion);

/** A list whose pairs are expanded; the cells of a row are those of the row that it stands for. */
typedef struct expanded_list {
    nqm_pair_list list; /* uses the texts of the given list */
    expansion expansion;
    nqm_named_pair *pair;
} expanded_list;

void expand_list(const nqm_pair_list *list, const char *const *names, expanded_list *expanded);
/** NULL members are allowed. */
void free_expanded_list(expanded_list *expanded);

/** Whether both members are materials that nqm refuses for the same property, value and reason. */
bool has_same_refusal(const nqm_named_pair *pair);

#endif
