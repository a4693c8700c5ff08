/* SPDX-License-Identifier: MIT
 *
 * Byte positions in a valid JSON text: values are skipped, not read. Nothing here reads past the end, whatever the text is.
 */
#include "io/json_where.h"

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

static size_t skip_blanks(const nqm_json_source *json, size_t at) {
    while (at < json->n && memchr(" \t\r\n", json->text[at], 4))
        ++at;
    return at;
}

size_t nqm_json_begin(const nqm_json_source *json) {
    return skip_blanks(json, 0);
}

/* After the string whose quote is at `at`. */
static size_t skip_string(const nqm_json_source *json, size_t at) {
    for (++at; at < json->n && json->text[at] != '"'; ++at)
        at += json->text[at] == '\\';
    return at < json->n ? at + 1 : json->n;
}

size_t nqm_json_end(const nqm_json_source *json, size_t at) {
    size_t depth = 0;
    do {
        const char c = at < json->n ? json->text[at] : 0;
        if (c == '"') {
            at = skip_string(json, at);
            continue;
        }
        depth += c == '{' || c == '[';
        if (depth == 0 && (c == 0 || strchr(",]} \t\r\n", c)))
            return at;
        depth -= c == '}' || c == ']';
        ++at;
        if (depth == 0 && (c == '}' || c == ']'))
            return at;
    } while (at < json->n);
    return json->n;
}

/* After the bracket or comma at `at`: the next element or key; SIZE_MAX at the end. */
static size_t enter(const nqm_json_source *json, size_t at) {
    at = skip_blanks(json, at + 1);
    return at < json->n && json->text[at] != ']' && json->text[at] != '}' ? at : SIZE_MAX;
}

size_t nqm_json_first(const nqm_json_source *json, size_t at) {
    return at < json->n && json->text[at] == '[' ? enter(json, at) : SIZE_MAX;
}

size_t nqm_json_next(const nqm_json_source *json, size_t at) {
    at = skip_blanks(json, nqm_json_end(json, at));
    return at < json->n && json->text[at] == ',' ? enter(json, at) : SIZE_MAX;
}

void nqm_json_outline(const nqm_json_source *json, char *outline) {
    enum { INNER = 2 };
    size_t depth = 0;
    memcpy(outline, json->text, json->n);
    for (size_t at = 0; at < json->n;) {
        const char c = json->text[at];
        const bool opens = c == '{' || c == '[', closes = c == '}' || c == ']';
        if (opens && depth == INNER) {
            outline[at] = '0';
            for (const size_t end = nqm_json_end(json, at); ++at < end;)
                outline[at] = outline[at] == '\n' ? '\n' : ' ';
            continue;
        }
        depth += opens;
        depth -= closes && depth;
        at = c == '"' ? skip_string(json, at) : at + 1;
    }
}

/* The position of the value of a member of the object at `at`; SIZE_MAX: none (also for keys that are written with escapes). */
static size_t find_member(const nqm_json_source *json, size_t at, const char *key) {
    const size_t n_key = strlen(key);
    if (at >= json->n || json->text[at] != '{')
        return SIZE_MAX;
    for (at = enter(json, at); at < json->n && json->text[at] == '"'; at = nqm_json_next(json, at)) {
        const size_t end = skip_string(json, at);
        const int is_it = end - at == n_key + 2 && memcmp(json->text + at + 1, key, n_key) == 0;
        at = skip_blanks(json, skip_blanks(json, end) + 1); /* the colon */
        if (is_it)
            return at < json->n ? at : SIZE_MAX;
    }
    return SIZE_MAX;
}

size_t nqm_json_path(const nqm_json_source *json, size_t at, const char *path) {
    char key[64];
    while (*path) {
        const size_t n = strcspn(path, ".");
        if (n >= sizeof key)
            return at;
        memcpy(key, path, n);
        key[n] = 0;
        const size_t next = find_member(json, at, key);
        if (next == SIZE_MAX)
            return at;
        at = next;
        path += n + (path[n] == '.');
    }
    return at;
}
