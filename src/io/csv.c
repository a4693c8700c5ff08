/* SPDX-License-Identifier: MIT
 *
 * CSV with a header line (io.h). The parser copies the text once, then unquotes and NUL-terminates the fields in place, so that the
 * offset of a field in the copy is its byte offset in the file, which messages report.
 */
#include "io/io.h"

#include <string.h>

/* One block; the arrays follow the struct. */
struct nqm_csv {
    char *name;      /* name in messages */
    char *text;      /* the file, split into fields */
    uint32_t *field; /* (1 + n_rows, n_columns) offset of each field in text; row 0 is the header */
    uint32_t *line;  /* (1 + n_rows) line of the file in which a record begins, from 1 */
    size_t n_columns, n_records;
};

typedef struct scanner {
    char *text; /* text[n] is NUL */
    size_t n, at, line;
    char separator; /* of fields */
} scanner;

static bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\r';
}

/* Whether the character at the cursor is a blank inside a field. */
static bool at_blank(const scanner *s) {
    return is_blank(s->text[s->at]) && s->text[s->at] != s->separator;
}

static void skip_blanks(scanner *s) {
    while (s->at < s->n && at_blank(s))
        ++s->at;
}

/* Move the cursor to the next line that contains a record; false at the end of the text. */
static bool next_record(scanner *s) {
    while (s->at < s->n) {
        size_t begin = s->at;
        skip_blanks(s);
        if (s->at < s->n && s->text[s->at] != '\n' && s->text[s->at] != '#') {
            s->at = begin;
            return true;
        }
        while (s->at < s->n && s->text[s->at] != '\n')
            ++s->at;
        if (s->at < s->n)
            ++s->at;
        ++s->line;
    }
    return false;
}

/* Move the cursor from an unquoted field to the separator after it; returns the end of the field. */
static size_t pass_plain(scanner *s) {
    size_t end = s->at;
    for (; s->at < s->n && s->text[s->at] != s->separator && s->text[s->at] != '\n'; ++s->at)
        if (!at_blank(s))
            end = s->at + 1;
    return end;
}

/* The same for a field that it unquotes, with the cursor after the opening quote. SIZE_MAX when the closing quote is
 * missing, or when anything but blanks is between it and the next separator. */
static size_t pass_quoted(scanner *s) {
    size_t end = s->at;
    for (;; ++s->at) {
        if (s->at >= s->n)
            return SIZE_MAX;
        char c = s->text[s->at];
        if (c == '"' && s->text[++s->at] != '"')
            break;
        s->line += c == '\n';
        s->text[end++] = c;
    }
    skip_blanks(s);
    return s->at >= s->n || s->text[s->at] == s->separator || s->text[s->at] == '\n' ? end : SIZE_MAX;
}

/* Split one record into fields and append their offsets at csv->field[*n_fields]. */
static nqm_status cut_record(nqm_csv *csv, scanner *s, size_t *n_fields, nqm_error *err) {
    size_t first = *n_fields, begin = s->at, line = s->line;
    csv->line[csv->n_records] = (uint32_t)line;
    char separator;
    do {
        skip_blanks(s);
        bool quoted = s->at < s->n && s->text[s->at] == '"';
        size_t at = s->at += quoted;
        csv->field[(*n_fields)++] = (uint32_t)at;
        const size_t end = quoted ? pass_quoted(s) : pass_plain(s);
        if (end == SIZE_MAX)
            return nqm_fail(err, NQM_ERR_FORMAT, (int64_t)at,
                            "%s: line %zu, byte %zu: a quoted field does not end properly", csv->name, line, at);
        separator = s->text[s->at];
        s->text[end] = '\0';
        if (s->at < s->n)
            ++s->at;
    } while (separator == s->separator);
    ++s->line;
    size_t n_cut = *n_fields - first;
    if (csv->n_records == 0)
        csv->n_columns = n_cut;
    if (n_cut > NQM_CSV_MAX_COLUMNS)
        return nqm_fail(err, NQM_ERR_LIMIT, (int64_t)begin, "%s: %zu columns (byte %zu); at most %d are read",
                        csv->name, n_cut, begin, (int)NQM_CSV_MAX_COLUMNS);
    if (n_cut != csv->n_columns)
        return nqm_fail(err, NQM_ERR_FORMAT, (int64_t)begin,
                        "%s: line %zu, byte %zu: %zu fields where the header has %zu", csv->name, line, begin, n_cut,
                        csv->n_columns);
    ++csv->n_records;
    return NQM_OK;
}

static scanner begin_scan(char *text, size_t n_bytes, char separator) {
    scanner s = {.text = text, .n = n_bytes, .line = 1, .separator = separator};
    if (n_bytes >= 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0)
        s.at = 3; /* UTF-8 byte order mark, which spreadsheets write */
    return s;
}

/* The separator of the header: a comma if it has one outside of quotes, else a semicolon, else a tab. */
static char find_separator(const char *text, size_t n_bytes) {
    bool is_quoted = false, has_semicolon = false, has_tab = false;
    scanner s = begin_scan((char *)(uintptr_t)text, n_bytes, '\0'); /* only read */
    if (!next_record(&s))
        return ',';
    for (size_t i = s.at; i < n_bytes && (is_quoted || text[i] != '\n'); ++i) {
        is_quoted ^= text[i] == '"';
        if (is_quoted)
            continue;
        if (text[i] == ',')
            return ',';
        has_semicolon |= text[i] == ';';
        has_tab |= text[i] == '\t';
    }
    return has_semicolon ? ';' : has_tab ? '\t' : ',';
}

/* Upper bounds of the numbers of records and fields. Blank lines are not counted, so that each record has two bytes. */
static void count_fields(const char *text, size_t n_bytes, char separator, size_t *n_records, size_t *n_fields) {
    size_t n_separators = 0, n_lines = 1;
    bool is_empty = true;
    for (size_t i = 0; i < n_bytes; ++i) {
        n_separators += text[i] == separator;
        n_lines += text[i] == '\n' && !is_empty;
        is_empty = text[i] == '\n' || (is_empty && is_blank(text[i]) && text[i] != separator);
    }
    *n_records = n_lines;
    *n_fields = n_separators + n_lines;
}

nqm_status nqm_csv_parse(const char *text, size_t n_bytes, const char *name, nqm_csv **csv_ret, nqm_error *err) {
    *csv_ret = NULL;
    if (n_bytes > UINT32_MAX)
        return nqm_fail(err, NQM_ERR_LIMIT, 0, "%s: %zu bytes of CSV (byte 0); less than 4 GiB are read", name,
                        n_bytes);
    const char *nul = n_bytes ? memchr(text, '\0', n_bytes) : NULL;
    if (nul && n_bytes > 1 && (memcmp(text, "\xff\xfe", 2) == 0 || memcmp(text, "\xfe\xff", 2) == 0))
        return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: text in UTF-16 (byte 0); save it as UTF-8", name);
    if (nul) {
        const char *kind = nqm_file_kind((const unsigned char *)text, n_bytes);
        return nqm_fail(err, NQM_ERR_FORMAT, nul - text, "%s: byte %zu is 0: not a text file%s%s", name,
                        (size_t)(nul - text), kind ? ", it begins like " : "", kind ? kind : "");
    }
    size_t n_fields, n_records, n_name = strlen(name) + 1;
    const char separator = find_separator(text, n_bytes);
    count_fields(text, n_bytes, separator, &n_records, &n_fields);
    nqm_csv *csv, arrays = {0};
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&csv, 1, sizeof *csv}, {&arrays.name, n_name, 1}, {&arrays.text, n_bytes + 1, 1},
                   {&arrays.field, n_fields, sizeof(uint32_t)}, {&arrays.line, n_records, sizeof(uint32_t)}),
        err);
    if (status != NQM_OK)
        return status;
    *csv = arrays;
    memcpy(csv->name, name, n_name);
    if (n_bytes)
        memcpy(csv->text, text, n_bytes);
    scanner s = begin_scan(csv->text, n_bytes, separator);
    n_fields = 0;
    while (status == NQM_OK && next_record(&s))
        status = cut_record(csv, &s, &n_fields, err);
    if (status == NQM_OK && csv->n_records == 0)
        status = nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: no header line: the file is empty", name);
    if (status == NQM_OK)
        *csv_ret = csv;
    else
        nqm_csv_free(csv);
    return status;
}

nqm_status nqm_csv_load(const char *path, nqm_csv **csv_ret, nqm_error *err) {
    *csv_ret = NULL;
    nqm_map map;
    nqm_status status = nqm_map_open(path, &map, err);
    if (status == NQM_OK)
        status = nqm_csv_parse((const char *)map.data, map.n_bytes, path, csv_ret, err);
    nqm_map_close(&map);
    return status;
}

void nqm_csv_free(nqm_csv *csv) {
    nqm_free(csv);
}

size_t nqm_csv_rows(const nqm_csv *csv) {
    return csv->n_records - 1;
}

size_t nqm_csv_columns(const nqm_csv *csv) {
    return csv->n_columns;
}

const char *nqm_csv_header(const nqm_csv *csv, int column) {
    return csv->text + csv->field[column];
}

int nqm_csv_column(const nqm_csv *csv, const char *column_name) {
    for (size_t column = 0; column < csv->n_columns; ++column)
        if (nqm_equal_any_case(csv->text + csv->field[column], column_name, SIZE_MAX))
            return (int)column;
    return -1;
}

const char *nqm_csv_text(const nqm_csv *csv, size_t row, int column) {
    return csv->text + csv->field[(row + 1) * csv->n_columns + (size_t)column];
}

size_t nqm_csv_byte(const nqm_csv *csv, size_t row, int column) {
    return (size_t)(nqm_csv_text(csv, row, column) - csv->text);
}

nqm_status nqm_csv_number(const nqm_csv *csv, size_t row, int column, double *value_ret, nqm_error *err) {
    const char *text = nqm_csv_text(csv, row, column), *end = text;
    double value;
    bool parsed = nqm_parse_double(text, &end, &value);
    while (is_blank(*end)) /* quoted fields keep their blanks */
        ++end;
    if (!parsed || *end) {
        size_t at = nqm_csv_byte(csv, row, column);
        return nqm_fail(err, NQM_ERR_FORMAT, (int64_t)at,
                        "%s: line %u, byte %zu: column '%s' needs a finite number%s, not '%.40s'", csv->name,
                        (unsigned)csv->line[row + 1], at, csv->text + csv->field[column],
                        strchr(text, ',') ? " with a decimal point" : "", text);
    }
    *value_ret = value;
    return NQM_OK;
}
