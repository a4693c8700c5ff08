/* SPDX-License-Identifier: MIT
 *
 * pair_list.h - lists of pairs that are named by files, specs and presets, from CSV or JSON Lines.
 */
#ifndef PAIR_LIST_H
#define PAIR_LIST_H

#include <nqm/metric.h>

/** A list of pairs with any further columns. Immutable. */
typedef struct nqm_pair_list nqm_pair_list;

/** The value of a row in one column. */
typedef struct nqm_list_cell {
    size_t column;
    const char *text; /**< UTF-8 as in the file; JSON text when is_json */
    int is_json;      /**< 1: `text` is JSON (a number, true, null, an array or an object); 0: it is a plain string */
} nqm_list_cell;

enum { NQM_LIST_MAX_COLUMNS = 1024 }; /**< JSON Lines: limit of the distinct member names of all rows */

/**
 * Read a list: CSV with a header that names the columns `reference` and `test` (ASCII case ignored), or JSON Lines with
 * strings "reference" and "test" in each line (files.md). The format is detected from the first byte that is not a
 * blank: '{' means JSON Lines. Other columns are kept unchanged.
 *
 * @return NQM_ERR_IO, NQM_ERR_FORMAT (the message names line and byte), NQM_ERR_LIMIT, NQM_ERR_NOMEM
 */
NQM_MUST_CHECK nqm_status nqm_pair_list_load(const char *path, nqm_pair_list **list_ret, nqm_error *err);
/** Free a list; NULL is allowed. */
void nqm_pair_list_free(nqm_pair_list *list);
/** Rows. */
size_t nqm_pair_list_count(const nqm_pair_list *list);
/** (nqm_pair_list_count) the pairs in the order of the list; borrowed. */
const nqm_named_pair *nqm_pair_list_pairs(const nqm_pair_list *list);
/** Columns, `reference` and `test` among them, in the order of the header or of their first appearance. */
size_t nqm_pair_list_columns(const nqm_pair_list *list);
/** Name of a column; borrowed; NULL when the index is too large. */
const char *nqm_pair_list_column(const nqm_pair_list *list, size_t column);
/** The cells of a row, in the order of the row; JSON rows may lack columns. Returns their number; *cells_ret is
 *  borrowed. */
size_t nqm_pair_list_cells(const nqm_pair_list *list, size_t row, const nqm_list_cell **cells_ret);
/** SHA-256 of the bytes of the list, 64 hex digits; borrowed. */
const char *nqm_pair_list_sha256(const nqm_pair_list *list);

/** As nqm_pair_list_load(), from memory; `name` is for messages. */
NQM_MUST_CHECK nqm_status nqm_pair_list_parse(const char *text, size_t n_bytes, const char *name,
                                              nqm_pair_list **list_ret, nqm_error *err);

#endif
