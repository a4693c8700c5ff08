/* SPDX-License-Identifier: MIT
 *
 * Reads lists of pairs, with any further columns, from CSV and JSON Lines. The cells of a row are contiguous. Texts of
 * a CSV are borrowed from its reader; texts of JSON Lines are owned by the list. Cells take few bytes, because those of a file
 * may have one or two.
 */
#include "io/json.h"
#include "pairs/pairs.h"

#include <stdlib.h>
#include <string.h>

enum { VALUE_IS_JSON = 1 << 16, MIN_JSON_ROW = 27 }; /* bytes of a line with two names of one character */

/* A list that is being read. */
typedef struct pair_list {
    nqm_pairs pairs;
    struct nqm_pairs_state s;
} pair_list;

void nqm_pairs_free(nqm_pairs *pairs) {
    struct nqm_pairs_state *s = pairs ? pairs->state : NULL;
    if (!s)
        return;
    for (size_t i = 0; !s->of && !s->csv && i < pairs->n_columns; ++i)
        nqm_free((void *)(uintptr_t)s->column[i]);
    for (size_t i = 0; i < s->n_owned; ++i)
        nqm_free(s->owned[i]);
    nqm_names_free(&s->text);
    nqm_free(s->owned);
    nqm_free(s->path);
    nqm_free(s->cell);
    nqm_free(s->pair);
    nqm_free(s->name);
    nqm_free(s->row);
    nqm_free(s->is_made);
    nqm_free(s->left_out);
    nqm_csv_free(s->csv);
    nqm_free(pairs);
}

/* Read a cell as it is in the file. */
static bool read_cell(const nqm_pairs *pairs, size_t row, size_t i, nqm_pairs_cell *cell) {
    const struct nqm_pairs_state *s = pairs->state;
    if (!s || i >= (s->csv ? pairs->n_columns : s->row_begin[row + 1] - s->row_begin[row]))
        return false;
    *cell = (nqm_pairs_cell){.column = i};
    if (s->csv) {
        cell->text = nqm_csv_text(s->csv, row, (int)i);
        return true;
    }
    const size_t at = s->row_begin[row] + i;
    *cell = (nqm_pairs_cell){s->cell[at] & ~(uint32_t)VALUE_IS_JSON, nqm_name(&s->text, at),
                             (s->cell[at] & VALUE_IS_JSON) != 0};
    return true;
}

bool nqm_pairs_get_cell(const nqm_pairs *pairs, size_t row, size_t i, nqm_pairs_cell *cell) {
    const struct nqm_pairs_state *s = pairs->state;
    if (!pairs->rows)
        return read_cell(pairs, row, i, cell);
    if (!read_cell(s->of, pairs->rows[row], i, cell))
        return false;
    const char *name = pairs->columns[cell->column];
    if (s->is_made[row] && nqm_equal_any_case(name, "reference", SIZE_MAX))
        cell->text = pairs->pairs[row].ref;
    else if (s->is_made[row] && nqm_equal_any_case(name, "test", SIZE_MAX))
        cell->text = pairs->pairs[row].test;
    return true;
}

/* ---- CSV --------------------------------------------------------------------------------------------------------- */

/* The name of a BRDF in a row; a missing one is refused here, because it is a fault of the list and not of the BRDF. */
static nqm_status take_csv_name(const nqm_csv *csv, size_t row, int column, const char *name, const char **text_ret,
                                nqm_error *err) {
    const size_t byte = nqm_csv_byte(csv, row, column);
    *text_ret = nqm_csv_text(csv, row, column);
    if (**text_ret)
        return NQM_OK;
    return nqm_fail(err, NQM_ERR_FORMAT, (int64_t)byte, "%s: row %zu, byte %zu: column '%s' is empty", name, row + 1,
                    byte, nqm_csv_header(csv, column));
}

static nqm_status take_csv(pair_list *list, const char *name, nqm_error *err) {
    int ref = nqm_csv_column(list->s.csv, "reference"), test = nqm_csv_column(list->s.csv, "test");
    if (ref < 0 || test < 0)
        return nqm_fail(err, NQM_ERR_FORMAT, 0,
                        "%s: byte 0: the header names no column '%s': a list begins with the line reference,test", name,
                        ref < 0 ? "reference" : "test");
    size_t n_rows = nqm_csv_rows(list->s.csv), n_columns = nqm_csv_columns(list->s.csv);
    if (n_columns > NQM_LIST_MAX_COLUMNS)
        return nqm_fail(err, NQM_ERR_LIMIT, 0, "%s: %zu columns (byte 0); a list has at most %d", name, n_columns,
                        (int)NQM_LIST_MAX_COLUMNS);
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&list->s.pair, n_rows, sizeof *list->s.pair}, {&list->s.column, n_columns, sizeof *list->s.column}),
        err);
    if (status != NQM_OK)
        return status;
    for (size_t k = 0; k < n_columns; ++k)
        list->s.column[list->pairs.n_columns++] = nqm_csv_header(list->s.csv, (int)k);
    for (size_t row = 0; status == NQM_OK && row < n_rows; ++row) {
        status = take_csv_name(list->s.csv, row, ref, name, &list->s.pair[row].ref, err);
        if (status == NQM_OK)
            status = take_csv_name(list->s.csv, row, test, name, &list->s.pair[row].test, err);
        ++list->pairs.n;
    }
    return status;
}

/* ---- JSON Lines -------------------------------------------------------------------------------------------------- */

/* One line of the text, for messages. */
typedef struct json_line {
    const char *name; /* of the file */
    size_t number;    /* from 1 */
    int64_t at;       /* byte offset of its first character */
} json_line;

/* Find the column with a name; add it if it is new. */
static nqm_status find_column(pair_list *list, const json_line *line, const char *name, size_t *column_ret,
                              nqm_error *err) {
    for (size_t k = 0; k < list->pairs.n_columns; ++k)
        if (strcmp(list->s.column[k], name) == 0) {
            *column_ret = k;
            return NQM_OK;
        }
    if (list->pairs.n_columns == NQM_LIST_MAX_COLUMNS)
        return nqm_fail(err, NQM_ERR_LIMIT, line->at, "%s: line %zu: more than %d different members", line->name,
                        line->number, (int)NQM_LIST_MAX_COLUMNS);
    list->s.column[list->pairs.n_columns] = nqm_strdup(name);
    if (!list->s.column[list->pairs.n_columns])
        return nqm_fail_nomem(err, strlen(name));
    *column_ret = list->pairs.n_columns++;
    return NQM_OK;
}

/* Append a value. */
static nqm_status add_value(pair_list *list, size_t column, const json_t *value, nqm_error *err) {
    uint32_t *cell = nqm_grow(list->s.cell, &list->s.max_cells, list->s.n_cells + 1, sizeof *cell);
    char number[32], *dump = NULL;
    const char *text = json_string_value(value);
    if (cell)
        list->s.cell = cell;
    if (json_is_real(value))
        text = nqm_format_double(number, sizeof number, json_real_value(value));
    else if (!text)
        text = dump = json_dumps(value, JSON_COMPACT | JSON_ENCODE_ANY);
    nqm_status status =
        cell && text ? nqm_names_add(&list->s.text, text, strlen(text), err) : nqm_fail_nomem(err, sizeof *cell);
    if (status == NQM_OK)
        list->s.cell[list->s.n_cells++] = (uint32_t)column | (json_is_string(value) ? 0 : (uint32_t)VALUE_IS_JSON);
    free(dump);
    return status;
}

static nqm_status take_members(pair_list *list, const json_line *line, json_t *object, nqm_error *err) {
    const char *key;
    json_t *value;
    static const char *const needed[] = {"reference", "test"};
    for (size_t i = 0; i < 2; ++i)
        if (json_string_length(json_object_get(object, needed[i])) == 0)
            return nqm_fail(err, NQM_ERR_FORMAT, line->at, "%s: line %zu, byte %lld: no string \"%s\"", line->name,
                            line->number, (long long)line->at, needed[i]);
    json_object_foreach(object, key, value) {
        size_t column = 0;
        nqm_status status = find_column(list, line, key, &column, err);
        if (status == NQM_OK)
            status = add_value(list, column, value, err);
        if (status != NQM_OK)
            return status;
    }
    list->s.row_begin[++list->pairs.n] = list->s.n_cells;
    return NQM_OK;
}

static nqm_status take_line(pair_list *list, const json_line *line, const char *text, size_t n, nqm_error *err) {
    json_error_t flaw;
    nqm_status status = nqm_json_check(text, n, n, line->name, (size_t)line->at, err);
    if (status != NQM_OK)
        return status;
    json_t *object;
    status = nqm_json_load(text, n, JSON_REJECT_DUPLICATES, &object, &flaw, err);
    if (status == NQM_ERR_NOMEM)
        return status;
    if (!object) {
        long long at = line->at + (flaw.position > 0 ? flaw.position : 0);
        return nqm_fail(err, NQM_ERR_FORMAT, at, "%s: line %zu, byte %lld: no JSON object: %.120s", line->name,
                        line->number, at, flaw.text);
    }
    status = json_is_object(object) ? take_members(list, line, object, err)
                                    : nqm_fail(err, NQM_ERR_FORMAT, line->at,
                                               "%s: line %zu, byte %lld: no JSON object; a list has one on each line",
                                               line->name, line->number, (long long)line->at);
    json_decref(object);
    return status;
}

static size_t count_blanks(const char *text, size_t n) {
    size_t i = 0;
    while (i < n && text[i] && strchr(" \t\r\n", text[i]))
        ++i;
    return i;
}

/* Set the pairs, when the texts do not move any more. */
static void fill_pairs(pair_list *list) {
    nqm_pairs_cell cell;
    for (size_t row = 0; row < list->pairs.n; ++row)
        for (size_t i = 0; read_cell(&list->pairs, row, i, &cell); ++i) {
            if (strcmp(list->s.column[cell.column], "reference") == 0)
                list->s.pair[row].ref = cell.text;
            else if (strcmp(list->s.column[cell.column], "test") == 0)
                list->s.pair[row].test = cell.text;
        }
}

static nqm_status take_json_lines(pair_list *list, const char *text, size_t begin, size_t n_bytes, const char *name,
                                  nqm_error *err) {
    size_t max_rows = 1, line_begin = 0;
    for (size_t i = 0; i < n_bytes; ++i)
        if (text[i] == '\n') {
            max_rows += i - line_begin >= MIN_JSON_ROW;
            line_begin = i + 1;
        }
    nqm_status status = nqm_alloc_arrays(NQM_ARRAYS({&list->s.pair, max_rows, sizeof *list->s.pair},
                                                    {&list->s.column, NQM_LIST_MAX_COLUMNS, sizeof *list->s.column},
                                                    {&list->s.row_begin, max_rows + 1, sizeof *list->s.row_begin}),
                                         err);
    json_line line = {name, 1, 0};
    for (const char *at = text + begin, *end = text + n_bytes; status == NQM_OK && at < end; ++line.number) {
        const char *stop = memchr(at, '\n', (size_t)(end - at));
        size_t n = stop ? (size_t)(stop - at) + 1 : (size_t)(end - at);
        line.at = at - text;
        if (count_blanks(at, n) < n)
            status = take_line(list, &line, at, n, err);
        at += n;
    }
    fill_pairs(list);
    return status;
}

/* ---- either ------------------------------------------------------------------------------------------------------ */

nqm_status nqm_pairs_parse(const char *text, size_t n_bytes, const char *name, nqm_pairs **pairs_ret, nqm_error *err) {
    *pairs_ret = NULL;
    pair_list *list = nqm_alloc(1, sizeof *list);
    nqm_sha256 sha;
    if (!list || !nqm_sha256_begin(&sha)) {
        nqm_free(list);
        return nqm_fail_nomem(err, sizeof *list);
    }
    list->pairs.state = &list->s;
    size_t begin = n_bytes >= 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0 ? 3 : 0; /* UTF-8 byte order mark */
    size_t first = begin + count_blanks(text + begin, n_bytes - begin);
    nqm_status status;
    if (first < n_bytes && (text[first] == '{' || text[first] == '[')) { /* an array is refused as its first line */
        status = take_json_lines(list, text, begin, n_bytes, name, err);
    } else {
        status = nqm_csv_parse(text, n_bytes, name, &list->s.csv, err);
        if (status == NQM_OK)
            status = take_csv(list, name, err);
    }
    if (status == NQM_OK)
        nqm_sha256_add(&sha, text, n_bytes);
    nqm_sha256_end(&sha, list->s.hash);
    list->pairs.pairs = list->s.pair;
    list->pairs.columns = list->s.column;
    list->pairs.sha256 = list->s.hash;
    list->s.path = status == NQM_OK ? nqm_strdup(name) : NULL;
    if (status == NQM_OK && !list->s.path)
        status = nqm_fail_nomem(err, strlen(name));
    if (status == NQM_OK)
        *pairs_ret = &list->pairs;
    else
        nqm_pairs_free(&list->pairs);
    return status;
}

nqm_status nqm_pairs_read(const char *path, nqm_pairs **pairs_ret, nqm_error *err) {
    NQM_MAKE(err, pairs_ret, path);
    nqm_map map;
    nqm_status status = nqm_map_open(path, &map, err);
    if (status != NQM_OK)
        return status;
    status = nqm_pairs_parse((const char *)map.data, map.n_bytes, map.path, pairs_ret, err);
    nqm_map_close(&map);
    return status;
}
