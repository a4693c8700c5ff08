/* SPDX-License-Identifier: MIT
 *
 * Corrects the checksum of a safetensors file, without which a reader looks at no mutated input any further.
 */
#include "fuzz.h"
#include "io/io.h"

blob fuzz_with_checksum(const uint8_t *data, size_t n_bytes) {
    static const char key[] = "\"sha256\":\"";
    enum { KEY = sizeof key - 1, DIGITS = 64 };
    blob b = blob_of(n_bytes, (const char *)data);
    nqm_safetensors *st;
    char hex[DIGITS + 1];
    bool matches;
    if (nqm_safetensors_parse(b.data, b.n_bytes, "fuzz", &st, NULL) != NQM_OK)
        return b;
    const bool known = nqm_safetensors_checksum(st, hex, &matches);
    nqm_safetensors_free(st);
    for (size_t i = 0; known && i + KEY + DIGITS <= b.n_bytes; ++i)
        if (memcmp(b.data + i, key, KEY) == 0) {
            memcpy(b.data + i + KEY, hex, DIGITS);
            break;
        }
    return b;
}
