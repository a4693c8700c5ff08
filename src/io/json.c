/* SPDX-License-Identifier: MIT
 *
 * The memory that a JSON text will take: jansson has no limit of its own, and its tree takes up to 100 times the bytes of a text
 * that consists of empty arrays.
 */
#include "io/io.h"

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
