/* SPDX-License-Identifier: MIT
 *
 * Material files in memory: copies of exactly that size, so that sanitizers detect a read past the end.
 */
#include "support/material_text.h"
#include "support/check.h"

static nqm_status read_copy(const char *path, const void *data, size_t n, nqm_materials **materials, nqm_error *err) {
    unsigned char *copy = malloc(n ? n : 1);
    assert_non_null(copy);
    memcpy(copy, data, n);
    const nqm_status status = nqm_materials_read(&(nqm_map){.data = copy, .n_bytes = n, .path = path}, materials, err);
    free(copy);
    return status;
}

nqm_materials *bytes_as_materials(const char *path, const void *data, size_t n) {
    nqm_materials *materials = NULL;
    nqm_error err = {0};
    if (read_copy(path, data, n, &materials, &err) != NQM_OK)
        fail_msg("%s", err.message);
    return materials;
}

nqm_materials *text_as_materials(const char *path, const char *text) {
    return bytes_as_materials(path, text, strlen(text));
}

void refuse_bytes(const char *path, const void *data, size_t n, nqm_status status, int64_t byte, const char *words) {
    nqm_materials *materials = NULL;
    nqm_error err = {0};
    assert_int_equal(read_copy(path, data, n, &materials, &err), status);
    assert_null(materials);
    if (!strstr(err.message, words) || (byte >= 0 && err.byte_offset != byte))
        fail_msg("'%s' at byte %lld instead of '%s'", err.message, (long long)err.byte_offset, words);
}
