/* SPDX-License-Identifier: MIT
 *
 * JSON texts and memory. jansson has no limit of its own, and its tree takes up to 100 times the bytes of a text that
 * consists of empty arrays. When an allocation fails it leaves out a character or a value, or fails without a reason.
 */
#include "io/io.h"
#include "io/options_json.h"

#include <pthread.h>

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
