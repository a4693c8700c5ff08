/* SPDX-License-Identifier: MIT
 *
 * JSON texts and memory. jansson has no limit of its own, and its tree takes up to 100 times the bytes of a text that
 * consists of empty arrays. When an allocation fails it leaves out a character or a value, or fails without a reason.
 */
#include "io/json.h"
#include "base/os.h"

#include <stdlib.h>
#include <string.h>

/* jansson has one allocator for the process: it stays the same, but failures are seen. */
static json_malloc_t allocate_block;
static _Thread_local bool has_failed;

static void *watched_malloc(size_t n) {
    void *block = allocate_block(n);
    has_failed |= !block;
    return block;
}

static void watch(void) {
    json_free_t release;
    json_get_alloc_funcs(&allocate_block, &release);
    json_set_alloc_funcs(watched_malloc, release);
}

void nqm_json_watch(void) {
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    pthread_once(&once, watch);
    has_failed = false;
}

bool nqm_json_has_failed(void) {
    return has_failed;
}

nqm_status nqm_json_load(const char *text, size_t n_bytes, size_t flags, json_t **json_ret, json_error_t *why,
                         nqm_error *err) {
    json_error_t own;
    why = why ? why : &own;
    nqm_json_watch();
    *json_ret = json_loadb(text, n_bytes, flags, why);
    if (has_failed || (!*json_ret && json_error_code(why) == json_error_out_of_memory)) {
        json_decref(*json_ret);
        *json_ret = NULL;
        return nqm_fail_nomem(err, n_bytes);
    }
    return *json_ret ? NQM_OK : nqm_fail(err, NQM_ERR_FORMAT, why->position, "invalid JSON: %s", why->text);
}

nqm_status nqm_json_parse(const char *text, json_t **json_ret, nqm_error *err) {
    *json_ret = NULL;
    if (!text || nqm_json_load(text, strlen(text), 0, json_ret, NULL, NULL) != NQM_ERR_NOMEM)
        return NQM_OK;
    return nqm_fail_nomem(err, strlen(text));
}

nqm_status nqm_json_read(const char *text, size_t n_bytes, size_t flags, const nqm_json_place *at, json_t **json_ret,
                         nqm_error *err) {
    json_error_t why = {.position = 0};
    *json_ret = NULL;
    nqm_status status = nqm_json_check(text, n_bytes, at->n_file, at->name, at->byte, err);
    if (status == NQM_OK)
        status = nqm_json_load(text, n_bytes, flags, json_ret, &why, err);
    if (status != NQM_ERR_FORMAT)
        return status;
    const int64_t byte = (int64_t)at->byte + (why.position > 0 ? why.position : 0);
    return nqm_fail(err, NQM_ERR_FORMAT, byte, "%s: byte %lld: invalid JSON: %s", at->name, (long long)byte, why.text);
}

/* Bytes of jansson's blocks on 64-bit systems: what a value or a member costs is counted at the character that comes with it. */
enum { OBJECT = 240, ARRAY = 144, MEMBER = 160, ELEMENT = 56, MAX_RATIO = 8 };

static size_t cost_of(char c) {
    return c == '{' ? OBJECT : c == '[' ? ARRAY : c == ':' ? MEMBER : c == ',' ? ELEMENT : 0;
}

nqm_status nqm_json_check(const char *text, size_t n_bytes, size_t n_file, const char *name, size_t byte,
                          nqm_error *err) {
    const size_t most = NQM_JSON_ROOM + MAX_RATIO * n_file;
    size_t n = n_bytes; /* the strings */
    bool is_string = false;
    for (size_t i = 0; i < n_bytes; ++i) {
        if (text[i] == '"')
            is_string = !is_string;
        else if (is_string)
            i += text[i] == '\\';
        else
            n += cost_of(text[i]);
        if (n > most)
            return nqm_fail(err, NQM_ERR_LIMIT, (int64_t)(byte + i),
                            "%s: the values of this JSON up to byte %zu take more than %zu KB, the limit for %zu bytes",
                            name, byte + i, most >> 10, n_file);
    }
    return NQM_OK;
}

/* ---- options ----------------------------------------------------------------------------------------------------- */

static json_t *value_json(const nqm_option *o, const void *options) {
    const void *field = (const char *)options + o->offset;
    const size_t *list = field;
    char text[NQM_OPTION_TEXT_MAX];
    if (o->kind == NQM_OPTION_DOUBLE)
        return json_real(*(const double *)field);
    if (o->kind == NQM_OPTION_SIZE)
        return json_integer((json_int_t)*list);
    if (o->kind == NQM_OPTION_BOOL)
        return json_boolean(*(const int *)field != 0);
    if (o->kind != NQM_OPTION_SIZES)
        return json_string(nqm_option_format(o, options, text));
    json_t *array = json_array();
    for (size_t i = 1; i <= list[0]; ++i)
        if (json_array_append_new(array, json_integer((json_int_t)list[i])) != 0) {
            json_decref(array);
            return NULL;
        }
    return array;
}

json_t *nqm_json_from_options(const nqm_option_table *table, const void *options) {
    json_t *json = json_object();
    char text[NQM_OPTION_TEXT_MAX];
    for (size_t i = 0; json && i < table->n; ++i) {
        const nqm_option *o = &table->rows[i];
        const char *zero = o->words ? o->words[0] : "0";
        if (o->storage == NQM_NOT_STORED ||
            (o->storage == NQM_STORED_UNLESS_ZERO && strcmp(nqm_option_format(o, options, text), zero) == 0))
            continue;
        if (json_object_set_new(json, o->key, value_json(o, options)) != 0) {
            json_decref(json);
            json = NULL;
        }
    }
    return json;
}

char *nqm_json_text(json_t *json, size_t n_digits) {
    char *dump = json ? json_dumps(json, JSON_COMPACT | JSON_REAL_PRECISION(n_digits)) : NULL;
    char *text = dump ? nqm_strdup(dump) : NULL;
    free(dump);
    json_decref(json);
    return text;
}

/* ---- positions: nothing here reads past the end, whatever the text is ---------------------------------------------- */

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
        const bool is_it = end - at == n_key + 2 && memcmp(json->text + at + 1, key, n_key) == 0;
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
