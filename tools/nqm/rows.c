/* SPDX-License-Identifier: MIT
 *
 * The implementation of rows.h.
 */
#include "nqm/rows.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

const json_t *value_at(const json_t *json, const char *path) {
    char key[40];
    while (json && *path) {
        const size_t n = strcspn(path, ".");
        snprintf(key, sizeof key, "%.*s", (int)n, path);
        path += n + (path[n] == '.');
        if (!json_is_array(json)) {
            json = json_object_get(json, key);
        } else if (isdigit((unsigned char)*key)) {
            json = json_array_get(json, (size_t)atoi(key));
        } else {
            const json_t *list = json;
            json = NULL;
            for (size_t i = 0; !json && i < json_array_size(list); ++i) {
                const json_t *entry = json_array_get(list, i);
                const char *with = json_string_value(json_object_get(entry, "with"));
                if ((with && strcmp(with, key) == 0) || json_is_true(json_object_get(entry, key)))
                    json = entry;
            }
        }
    }
    return json;
}

double number_at(const json_t *json, const char *path) {
    const json_t *value = value_at(json, path);
    return json_is_number(value) ? json_number_value(value) : (double)NAN;
}

char *join_texts(const json_t *texts) {
    char *joined;
    size_t n;
    FILE *out = open_text(&joined, &n);
    for (size_t i = 0; i < json_array_size(texts); ++i)
        fprintf(out, "%s%s", i ? "; " : "", json_string_value(json_array_get(texts, i)));
    close_text(out, &joined, &n);
    return joined;
}

/* Texts of a list are separated by "; ". */
static void print_csv_value(FILE *out, const json_t *value) {
    char *joined = json_is_array(value) ? join_texts(value) : NULL;
    const char *text = joined ? joined : json_string_value(value);
    if (text)
        print_csv_text(out, text);
    else if (json_is_boolean(value))
        fputc(json_is_true(value) ? '1' : '0', out);
    else if (json_is_integer(value))
        fprintf(out, "%lld", (long long)json_integer_value(value));
    else if (json_is_real(value))
        print_csv_number(out, json_real_value(value));
    free(joined);
}

static const char *find_text(const row_text *texts, const char *column) {
    while (texts && texts->column && strcmp(texts->column, column) != 0)
        ++texts;
    return texts ? texts->text : NULL;
}

void print_csv_line(FILE *out, const char *columns, const json_t *row, const row_text *texts) {
    while (*columns) {
        char heading[160];
        if (*columns == ',')
            fputc(*columns++, out);
        const size_t n = strcspn(columns, ",");
        snprintf(heading, sizeof heading, "%.*s", (int)n, columns);
        columns += n;
        char *path = strchr(heading, '=');
        if (path)
            *path++ = '\0';
        const char *text = row ? find_text(texts, heading) : heading;
        if (text)
            print_csv_text(out, text);
        else
            print_csv_value(out, value_at(row, path ? path : heading));
    }
    fputc('\n', out);
}

/* ---- columns of scores ------------------------------------------------------------------------------------------- */

static bool is_wanted(const nqm_column *c, unsigned groups, const bool *metrics) {
    return (groups >> c->group & 1) && (c->group != NQM_COLUMN_METRIC || !metrics || metrics[c->metric]);
}

static json_t *column_json(const nqm_column *c) {
    if (c->kind == NQM_COLUMN_TEXT)
        return json_string(c->text);
    if (c->kind == NQM_COLUMN_REAL || isnan(c->number))
        return json_number(c->number);
    return c->kind == NQM_COLUMN_FLAG ? json_boolean(c->number != 0) : json_integer((json_int_t)c->number);
}

/* The object or list of this name, made when it is not there. */
static json_t *inner(json_t *object, const char *key, size_t n_key, json_t *make(void)) {
    char name[40];
    snprintf(name, sizeof name, "%.*s", (int)n_key, key);
    if (n_key && !json_object_get(object, name))
        json_object_set_new(object, name, make());
    return n_key ? json_object_get(object, name) : object;
}

json_t *set_columns(json_t *row, unsigned groups, const bool *metrics, const nqm_score_result *score,
                    const nqm_texture_result *texture) {
    const unsigned of_parts = COLUMNS_PARTS | COLUMNS_OF_LABEL | COLUMNS_SIMILARITY;
    if (isnan(score->parts.structure))
        groups &= ~of_parts;
    for (size_t i = 0;; ++i) {
        const nqm_column c = nqm_pairs_column(i, score, texture);
        if (!c.name)
            return row;
        if (!is_wanted(&c, groups, metrics))
            continue;
        json_t *object = inner(row, c.object, strlen(c.object), json_object);
        const size_t n = strcspn(c.member, ".");
        if (c.member[n])
            json_array_append_new(inner(object, c.member, n, json_array), column_json(&c));
        else
            json_object_set_new(object, c.member, column_json(&c));
    }
}

char *list_columns(const char *first, unsigned groups, const bool *metrics, const char *last) {
    char *text;
    size_t n;
    nqm_column c;
    FILE *out = open_text(&text, &n);
    fputs(first, out);
    for (size_t i = 0; (c = nqm_pairs_column(i, NULL, NULL)).name; ++i)
        if (is_wanted(&c, groups, metrics))
            fprintf(out, ",%s=%s%s%s", c.name, c.object, *c.object ? "." : "", c.member);
        else if (c.group == NQM_COLUMN_TEXTURE && groups & COLUMNS_BARE_TEXTURE)
            fprintf(out, ",%s", c.name);
    fputs(last, out);
    close_text(out, &text, &n);
    return text;
}

/* ---- order ------------------------------------------------------------------------------------------------------- */

typedef struct keyed {
    double key;
    size_t i;
} keyed;

static int by_key(const void *a, const void *b) {
    const keyed *x = a, *y = b;
    if (x->key != y->key)
        return x->key < y->key ? -1 : 1;
    return x->i < y->i ? -1 : 1;
}

size_t *order_by(size_t n, const double *keys, double sign) {
    keyed *all = allocate(n, sizeof *all);
    size_t *order = allocate(n, sizeof *order);
    for (size_t i = 0; i < n; ++i)
        all[i] = (keyed){isnan(keys[i]) ? (double)INFINITY : sign * keys[i], i};
    qsort(all, n, sizeof *all, by_key);
    for (size_t i = 0; i < n; ++i)
        order[i] = all[i].i;
    free(all);
    return order;
}
