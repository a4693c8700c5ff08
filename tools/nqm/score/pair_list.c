/* SPDX-License-Identifier: MIT
 *
 * Reads lists of pairs, with any further columns, from CSV and JSON Lines. The cells of a row are contiguous. Texts of
 * a CSV are borrowed from its reader; texts of JSON Lines are owned by the list.
 */
#include "nqm/score/pair_list.h"

#include <jansson.h>
#include <stdlib.h>
#include <string.h>

void nqm_pair_list_free(nqm_pair_list *list) {
    if (!list)
        return;
    for (size_t i = 0; !list->csv && i < list->n_cells; ++i)
        nqm_free((void *)(uintptr_t)list->cell[i].text);
    for (size_t i = 0; !list->csv && i < list->n_columns; ++i)
        nqm_free((void *)(uintptr_t)list->column[i]);
    nqm_free(list->pair);
    nqm_csv_free(list->csv);
    nqm_free(list);
}

static nqm_status make_room(nqm_pair_list *list, size_t n_rows, size_t n_columns, size_t max_cells, nqm_error *err) {
    return nqm_alloc_arrays(NQM_ARRAYS({&list->pair, n_rows, sizeof *list->pair},
                                       {&list->column, n_columns, sizeof *list->column},
                                       {&list->cell, max_cells, sizeof *list->cell},
                                       {&list->row_begin, n_rows + 1, sizeof *list->row_begin}),
                            err);
}

/* ---- CSV --------------------------------------------------------------------------------------------------------- */

static nqm_status take_csv(nqm_pair_list *list, const char *name, nqm_error *err) {
    int ref = nqm_csv_column(list->csv, "reference"), test = nqm_csv_column(list->csv, "test");
    if (ref < 0 || test < 0)
        return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: byte 0: the header names no column '%s'", name,
                        ref < 0 ? "reference" : "test");
    size_t n_rows = nqm_csv_rows(list->csv), n_columns = nqm_csv_columns(list->csv);
    nqm_status status = make_room(list, n_rows, n_columns, n_rows * n_columns, err);
    if (status != NQM_OK)
        return status;
    for (size_t k = 0; k < n_columns; ++k)
        list->column[list->n_columns++] = nqm_csv_header(list->csv, (int)k);
    for (size_t row = 0; row < n_rows; ++row) {
        for (size_t k = 0; k < n_columns; ++k)
            list->cell[list->n_cells++] = (nqm_list_cell){.column = k, .text = nqm_csv_text(list->csv, row, (int)k)};
        list->pair[row] = (nqm_named_pair){nqm_csv_text(list->csv, row, ref), nqm_csv_text(list->csv, row, test)};
        list->row_begin[++list->n_rows] = list->n_cells;
    }
    return NQM_OK;
}

/* ---- JSON Lines -------------------------------------------------------------------------------------------------- */

/* One line of the text, for messages. */
typedef struct json_line {
    const char *name; /* of the file */
    size_t number;    /* from 1 */
    int64_t at;       /* byte offset of its first character */
} json_line;

/* Find the column with a name; add it if it is new. */
static nqm_status find_column(nqm_pair_list *list, const json_line *line, const char *name, size_t *column_ret,
                              nqm_error *err) {
    for (size_t k = 0; k < list->n_columns; ++k)
        if (strcmp(list->column[k], name) == 0) {
            *column_ret = k;
            return NQM_OK;
        }
    if (list->n_columns == NQM_LIST_MAX_COLUMNS)
        return nqm_fail(err, NQM_ERR_LIMIT, line->at, "%s: line %zu: more than %d different members", line->name,
                        line->number, (int)NQM_LIST_MAX_COLUMNS);
    list->column[list->n_columns] = nqm_strdup(name);
    if (!list->column[list->n_columns])
        return nqm_fail_nomem(err, strlen(name));
    *column_ret = list->n_columns++;
    return NQM_OK;
}

/* The text of a value; NULL when out of memory. nqm_free() it. */
static char *text_of(const json_t *value) {
    if (json_is_string(value))
        return nqm_strdup(json_string_value(value));
    char number[32];
    if (json_is_real(value))
        return nqm_strdup(nqm_format_double(number, sizeof number, json_real_value(value)));
    char *dump = json_dumps(value, JSON_COMPACT | JSON_ENCODE_ANY);
    char *text = dump ? nqm_strdup(dump) : NULL;
    free(dump);
    return text;
}

static nqm_status take_members(nqm_pair_list *list, const json_line *line, json_t *object, nqm_error *err) {
    const char *key;
    json_t *value;
    nqm_named_pair *pair = &list->pair[list->n_rows];
    json_object_foreach(object, key, value) {
        nqm_list_cell *cell = &list->cell[list->n_cells];
        nqm_status status = find_column(list, line, key, &cell->column, err);
        if (status != NQM_OK)
            return status;
        cell->is_json = !json_is_string(value);
        cell->text = text_of(value);
        if (!cell->text)
            return nqm_fail_nomem(err, 0);
        ++list->n_cells;
        if (strcmp(key, "reference") == 0 && !cell->is_json)
            pair->ref = cell->text;
        if (strcmp(key, "test") == 0 && !cell->is_json)
            pair->test = cell->text;
    }
    if (!pair->ref || !pair->test)
        return nqm_fail(err, NQM_ERR_FORMAT, line->at, "%s: line %zu, byte %lld: no string \"%s\"", line->name,
                        line->number, (long long)line->at, pair->ref ? "test" : "reference");
    list->row_begin[++list->n_rows] = list->n_cells;
    return NQM_OK;
}

static nqm_status take_line(nqm_pair_list *list, const json_line *line, const char *text, size_t n, nqm_error *err) {
    json_error_t fault;
    json_t *object = json_loadb(text, n, JSON_REJECT_DUPLICATES, &fault);
    if (!object) {
        long long at = line->at + (fault.position > 0 ? fault.position : 0);
        return nqm_fail(err, NQM_ERR_FORMAT, at, "%s: line %zu, byte %lld: no JSON object: %.120s", line->name,
                        line->number, at, fault.text);
    }
    nqm_status status = json_is_object(object)
                            ? take_members(list, line, object, err)
                            : nqm_fail(err, NQM_ERR_FORMAT, line->at, "%s: line %zu, byte %lld: no JSON object",
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

static nqm_status take_json_lines(nqm_pair_list *list, const char *text, size_t begin, size_t n_bytes, const char *name,
                                  nqm_error *err) {
    size_t n_lines = 1, n_members = 0; /* n_members: upper bound, the number of colons */
    for (size_t i = 0; i < n_bytes; ++i) {
        n_lines += text[i] == '\n';
        n_members += text[i] == ':';
    }
    nqm_status status = make_room(list, n_lines, NQM_LIST_MAX_COLUMNS, n_members, err);
    json_line line = {name, 1, 0};
    for (const char *at = text + begin, *end = text + n_bytes; status == NQM_OK && at < end; ++line.number) {
        const char *stop = memchr(at, '\n', (size_t)(end - at));
        size_t n = stop ? (size_t)(stop - at) + 1 : (size_t)(end - at);
        line.at = at - text;
        if (count_blanks(at, n) < n)
            status = take_line(list, &line, at, n, err);
        at += n;
    }
    return status;
}

/* ---- either ------------------------------------------------------------------------------------------------------ */

nqm_status nqm_pair_list_parse(const char *text, size_t n_bytes, const char *name, nqm_pair_list **list_ret,
                               nqm_error *err) {
    *list_ret = NULL;
    nqm_pair_list *list = nqm_alloc(1, sizeof *list);
    nqm_sha256 sha;
    if (!list || !nqm_sha256_begin(&sha)) {
        nqm_free(list);
        return nqm_fail_nomem(err, sizeof *list);
    }
    nqm_sha256_add(&sha, text, n_bytes);
    nqm_sha256_end(&sha, list->sha256);
    size_t begin = n_bytes >= 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0 ? 3 : 0; /* UTF-8 byte order mark */
    size_t first = begin + count_blanks(text + begin, n_bytes - begin);
    nqm_status status;
    if (first < n_bytes && text[first] == '{') {
        status = take_json_lines(list, text, begin, n_bytes, name, err);
    } else {
        status = nqm_csv_parse(text, n_bytes, name, &list->csv, err);
        if (status == NQM_OK)
            status = take_csv(list, name, err);
    }
    if (status == NQM_OK)
        *list_ret = list;
    else
        nqm_pair_list_free(list);
    return status;
}

nqm_status nqm_pair_list_load(const char *path, nqm_pair_list **list_ret, nqm_error *err) {
    *list_ret = NULL;
    nqm_map map;
    nqm_status status = nqm_map_open(path, &map, err);
    if (status != NQM_OK)
        return status;
    status = nqm_pair_list_parse((const char *)map.data, map.n_bytes, map.path, list_ret, err);
    nqm_map_close(&map);
    return status;
}
