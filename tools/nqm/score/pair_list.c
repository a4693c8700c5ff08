/* SPDX-License-Identifier: MIT
 *
 * Reads lists of pairs, with any further columns, from CSV and JSON Lines. The cells of a row are contiguous. Texts of
 * a CSV are borrowed from its reader; texts of JSON Lines are owned by the list. Cells take few bytes, because those of a file
 * may have one or two.
 */
#include "nqm/score/pair_list.h"
#include "argument/argument.h"
#include "io/options_json.h"
#include "nqm/tool.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum { VALUE_IS_JSON = 1 << 16, MIN_JSON_ROW = 27 }; /* bytes of a line with two names of one character */

void nqm_pair_list_free(nqm_pair_list *list) {
    if (!list)
        return;
    for (size_t i = 0; !list->csv && i < list->n_columns; ++i)
        nqm_free((void *)(uintptr_t)list->column[i]);
    nqm_names_free(&list->text);
    nqm_free(list->cell);
    nqm_free(list->pair);
    nqm_csv_free(list->csv);
    nqm_free(list);
}

size_t nqm_pair_list_cells(const nqm_pair_list *list, size_t row) {
    row = list->expanded ? list->expanded[row].origin : row;
    return list->csv ? list->n_columns : list->row_begin[row + 1] - list->row_begin[row];
}

/* Read a cell as it is in the file. */
static nqm_list_cell read_cell(const nqm_pair_list *list, size_t row, size_t i) {
    if (list->csv)
        return (nqm_list_cell){.column = i, .text = nqm_csv_text(list->csv, row, (int)i)};
    const size_t at = list->row_begin[row] + i;
    return (nqm_list_cell){.column = list->cell[at] & ~(uint32_t)VALUE_IS_JSON,
                           .text = nqm_name(&list->text, at),
                           .is_json = (list->cell[at] & VALUE_IS_JSON) != 0};
}

nqm_list_cell nqm_pair_list_cell(const nqm_pair_list *list, size_t row, size_t i) {
    nqm_list_cell cell = read_cell(list, list->expanded ? list->expanded[row].origin : row, i);
    if (list->expanded && list->expanded[row].is_made) {
        const char *name = list->column[cell.column];
        if (strcasecmp(name, "reference") == 0)
            cell.text = list->pair[row].ref;
        else if (strcasecmp(name, "test") == 0)
            cell.text = list->pair[row].test;
    }
    return cell;
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

static nqm_status take_csv(nqm_pair_list *list, const char *name, nqm_error *err) {
    int ref = nqm_csv_column(list->csv, "reference"), test = nqm_csv_column(list->csv, "test");
    if (ref < 0 || test < 0)
        return nqm_fail(err, NQM_ERR_FORMAT, 0,
                        "%s: byte 0: the header names no column '%s': a list begins with the line reference,test", name,
                        ref < 0 ? "reference" : "test");
    size_t n_rows = nqm_csv_rows(list->csv), n_columns = nqm_csv_columns(list->csv);
    if (n_columns > NQM_LIST_MAX_COLUMNS)
        return nqm_fail(err, NQM_ERR_LIMIT, 0, "%s: %zu columns (byte 0); a list has at most %d", name, n_columns,
                        (int)NQM_LIST_MAX_COLUMNS);
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&list->pair, n_rows, sizeof *list->pair}, {&list->column, n_columns, sizeof *list->column}), err);
    if (status != NQM_OK)
        return status;
    for (size_t k = 0; k < n_columns; ++k)
        list->column[list->n_columns++] = nqm_csv_header(list->csv, (int)k);
    for (size_t row = 0; status == NQM_OK && row < n_rows; ++row) {
        status = take_csv_name(list->csv, row, ref, name, &list->pair[row].ref, err);
        if (status == NQM_OK)
            status = take_csv_name(list->csv, row, test, name, &list->pair[row].test, err);
        ++list->n_rows;
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

/* Append a value. */
static nqm_status add_value(nqm_pair_list *list, size_t column, const json_t *value, nqm_error *err) {
    uint32_t *cell = nqm_grow(list->cell, &list->max_cells, list->n_cells + 1, sizeof *cell);
    char number[32], *dump = NULL;
    const char *text = json_string_value(value);
    if (cell)
        list->cell = cell;
    if (json_is_real(value))
        text = nqm_format_double(number, sizeof number, json_real_value(value));
    else if (!text)
        text = dump = json_dumps(value, JSON_COMPACT | JSON_ENCODE_ANY);
    nqm_status status =
        cell && text ? nqm_names_add(&list->text, text, strlen(text), err) : nqm_fail_nomem(err, sizeof *cell);
    if (status == NQM_OK)
        list->cell[list->n_cells++] = (uint32_t)column | (json_is_string(value) ? 0 : (uint32_t)VALUE_IS_JSON);
    free(dump);
    return status;
}

static nqm_status take_members(nqm_pair_list *list, const json_line *line, json_t *object, nqm_error *err) {
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
    list->row_begin[++list->n_rows] = list->n_cells;
    return NQM_OK;
}

static nqm_status take_line(nqm_pair_list *list, const json_line *line, const char *text, size_t n, nqm_error *err) {
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
static void fill_pairs(nqm_pair_list *list) {
    for (size_t row = 0; row < list->n_rows; ++row)
        for (size_t i = 0; i < nqm_pair_list_cells(list, row); ++i) {
            const nqm_list_cell cell = nqm_pair_list_cell(list, row, i);
            if (strcmp(list->column[cell.column], "reference") == 0)
                list->pair[row].ref = cell.text;
            else if (strcmp(list->column[cell.column], "test") == 0)
                list->pair[row].test = cell.text;
        }
}

static nqm_status take_json_lines(nqm_pair_list *list, const char *text, size_t begin, size_t n_bytes, const char *name,
                                  nqm_error *err) {
    size_t max_rows = 1, line_begin = 0;
    for (size_t i = 0; i < n_bytes; ++i)
        if (text[i] == '\n') {
            max_rows += i - line_begin >= MIN_JSON_ROW;
            line_begin = i + 1;
        }
    nqm_status status = nqm_alloc_arrays(NQM_ARRAYS({&list->pair, max_rows, sizeof *list->pair},
                                                    {&list->column, NQM_LIST_MAX_COLUMNS, sizeof *list->column},
                                                    {&list->row_begin, max_rows + 1, sizeof *list->row_begin}),
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

nqm_status nqm_pair_list_parse(const char *text, size_t n_bytes, const char *name, nqm_pair_list **list_ret,
                               nqm_error *err) {
    *list_ret = NULL;
    nqm_pair_list *list = nqm_alloc(1, sizeof *list);
    nqm_sha256 sha;
    if (!list || !nqm_sha256_begin(&sha)) {
        nqm_free(list);
        return nqm_fail_nomem(err, sizeof *list);
    }
    size_t begin = n_bytes >= 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0 ? 3 : 0; /* UTF-8 byte order mark */
    size_t first = begin + count_blanks(text + begin, n_bytes - begin);
    nqm_status status;
    if (first < n_bytes && (text[first] == '{' || text[first] == '[')) { /* an array is refused as its first line */
        status = take_json_lines(list, text, begin, n_bytes, name, err);
    } else {
        status = nqm_csv_parse(text, n_bytes, name, &list->csv, err);
        if (status == NQM_OK)
            status = take_csv(list, name, err);
    }
    if (status == NQM_OK)
        nqm_sha256_add(&sha, text, n_bytes);
    nqm_sha256_end(&sha, list->sha256);
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

/* ---- pairs of files of several materials ------------------------------------------------------------------------- */

/* "ignore:...:FILE" with --ignore, which is owned. */
static void reflect(const char **argument, bool *is_owned) {
    const char *taken = reflecting(*argument);
    if (taken == *argument)
        return;
    if (*is_owned)
        free((void *)(uintptr_t)*argument);
    *argument = taken;
    *is_owned = true;
}

static void add_pair(expansion *e, nqm_named_pair pair, const char *name, size_t origin, bool is_made) {
    e->pairs = must_have(nqm_grow(e->pairs, &e->max_n, e->n + 1, sizeof *e->pairs));
    expanded_pair *added = &e->pairs[e->n++];
    *added = (expanded_pair){pair, name, origin, is_made, {is_made, is_made}};
    reflect(&added->pair.ref, &added->is_owned[0]);
    reflect(&added->pair.test, &added->is_owned[1]);
}

static void add_materials(expansion *e, const nqm_named_pair *pair, const char *name, size_t origin,
                          const nqm_materials *ref, const nqm_materials *test) {
    const nqm_materials *named = ref ? ref : test;
    for (size_t i = 0; i < nqm_materials_count(named); ++i) {
        const char *material = nqm_materials_get(named, i).name;
        char *test_member = join_with_colon(pair->test, material); /* if the file lacks it, opening it says so */
        char *ref_member = join_with_colon(pair->ref, ref ? material : "");
        add_pair(e, (nqm_named_pair){ref_member, test_member}, name ? join_with_colon(name, material) : NULL, origin,
                 true);
    }
    for (size_t i = 0, n; ref && i < nqm_materials_count(test); ++i) {
        const char *material = nqm_materials_get(test, i).name;
        nqm_materials_named(ref, material, &n);
        if (n == 0)
            report(EXIT_OK, "%s:%s is not compared: %s has no material of this name", pair->test, material, pair->ref);
    }
}

void expand_pairs(size_t n, const nqm_named_pair *pairs, const char *const *names, expansion *e) {
    *e = (expansion){0};
    for (size_t i = 0; i < n; ++i) {
        nqm_argument *ref = parse_argument(pairs[i].ref), *test = parse_argument(pairs[i].test);
        const nqm_materials *library = nqm_argument_library(test);
        if (library)
            add_materials(e, &pairs[i], names ? names[i] : NULL, i, nqm_argument_library(ref), library);
        else
            add_pair(e, pairs[i], names ? names[i] : NULL, i, false);
        nqm_argument_free(ref);
        nqm_argument_free(test);
    }
}

void free_expansion(expansion *e) {
    for (size_t i = 0; i < e->n; ++i) {
        const expanded_pair *p = &e->pairs[i];
        if (p->is_owned[0])
            free((void *)(uintptr_t)p->pair.ref);
        if (p->is_owned[1])
            free((void *)(uintptr_t)p->pair.test);
        if (p->is_made)
            free((void *)(uintptr_t)p->name);
    }
    nqm_free(e->pairs);
    *e = (expansion){0};
}

void expand_list(const nqm_pair_list *list, const char *const *names, expanded_list *x) {
    expand_pairs(list->n_rows, list->pair, names, &x->expansion);
    const size_t n = x->expansion.n;
    x->pair = allocate(n, sizeof *x->pair);
    for (size_t i = 0; i < n; ++i)
        x->pair[i] = x->expansion.pairs[i].pair;
    x->list = *list;
    x->list.n_rows = n;
    x->list.pair = x->pair;
    x->list.expanded = x->expansion.pairs;
}

void free_expanded_list(expanded_list *x) {
    free(x->pair);
    free_expansion(&x->expansion);
}

/* ---- refusals ---------------------------------------------------------------------------------------------------- */

bool has_same_refusal(const nqm_named_pair *pair) {
    nqm_argument *ref = parse_argument(pair->ref), *test = parse_argument(pair->test);
    nqm_material_info a, b;
    const bool is = nqm_argument_material(ref, &a) && nqm_argument_material(test, &b) && a.refusal && b.refusal &&
                    strcmp(a.refusal, b.refusal) == 0;
    nqm_argument_free(ref);
    nqm_argument_free(test);
    return is;
}
