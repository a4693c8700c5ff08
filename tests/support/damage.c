/* SPDX-License-Identifier: MIT
 *
 * Readers of bytes, and the loops over what is cut or changed.
 */
#include "support/damage.h"
#include "support/check.h"

#include "material/material.h"

nqm_status read_csv(const nqm_map *map, nqm_error *err) {
    nqm_csv *csv;
    const nqm_status status = nqm_csv_parse((const char *)map->data, map->n_bytes, map->path, &csv, err);
    assert_true((status == NQM_OK) == (csv != NULL));
    nqm_csv_free(csv);
    return status;
}

nqm_status read_mesh(const nqm_map *map, nqm_error *err) {
    nqm_mesh mesh;
    const nqm_status status = nqm_mesh_parse(map, &mesh, err);
    assert_true((status == NQM_OK) == (mesh.position != NULL));
    nqm_mesh_free(&mesh);
    return status;
}

nqm_status read_safetensors(const nqm_map *map, nqm_error *err) {
    nqm_safetensors *st;
    const nqm_status status = nqm_safetensors_parse(map->data, map->n_bytes, map->path, &st, err);
    assert_true((status == NQM_OK) == (st != NULL));
    assert_true(status == NQM_OK || err->byte_offset >= 0);
    nqm_safetensors_free(st);
    return status;
}

nqm_status read_materials(const nqm_map *map, nqm_error *err) {
    nqm_materials *materials;
    const nqm_status status = nqm_materials_read(map, &materials, err);
    assert_true((status == NQM_OK) == (materials != NULL));
    assert_true(status == NQM_OK || err->byte_offset >= 0);
    nqm_materials_free(materials);
    return status;
}

nqm_status read_brdf(const nqm_map *map, nqm_error *err) {
    nqm_brdf *brdf;
    char path[400];
    snprintf(path, sizeof path, "%.*s", (int)strcspn(map->path, ":"), map->path);
    blob_save(&(blob){(unsigned char *)(uintptr_t)map->data, map->n_bytes}, path);
    const nqm_status status = nqm_brdf_open(map->path, &brdf, err);
    assert_true((status == NQM_OK) == (brdf != NULL));
    nqm_brdf_free(brdf);
    return status;
}

nqm_status read_brdf_ends(const nqm_map *map, nqm_error *err) {
    const nqm_status status = read_brdf(map, err);
    assert_true(status == NQM_OK || err->byte_offset == 0 || err->byte_offset == (int64_t)map->n_bytes);
    return status;
}

/* Read the first n bytes with byte `at` changed by `bits`; returns the status of an error that is told. */
static nqm_status read_part(const char *path, blob whole, size_t n, size_t at, unsigned char bits, byte_reader read) {
    void *copy = NULL;
    nqm_error err = {.byte_offset = -1};
    assert_int_equal(posix_memalign(&copy, 64, n ? n : 1), 0);
    memcpy(copy, whole.data, n);
    if (bits)
        ((unsigned char *)copy)[at] ^= bits;
    const nqm_status status = read(&(nqm_map){.data = copy, .n_bytes = n, .path = path}, &err);
    const bool is_named = strncmp(err.message, path, strcspn(path, ":")) == 0; /* without the member of an archive */
    if (status != NQM_OK && (err.status != status || !is_named || err.byte_offset < -1 || err.byte_offset > (int64_t)n))
        fail_msg("%s, %zu of %zu bytes: '%s' at %lld", path, n, whole.n_bytes, err.message, (long long)err.byte_offset);
    free(copy);
    return status;
}

static size_t after(size_t n, size_t step) {
    return n + (n < 500 ? 1 : step);
}

static void cut_anywhere(const char *path, blob whole, size_t step, byte_reader read, bool may_be_valid) {
    for (size_t n = 0; n < whole.n_bytes; n = after(n, step)) {
        const nqm_status status = read_part(path, whole, n, 0, 0, read);
        if (status != NQM_ERR_FORMAT && !(may_be_valid && status == NQM_OK))
            fail_msg("%s, %zu of %zu bytes: %s", path, n, whole.n_bytes, nqm_status_text(status));
    }
}

void refuse_cuts(const char *path, blob whole, size_t step, byte_reader read) {
    cut_anywhere(path, whole, step, read, false);
}

void survive_cuts(const char *path, blob whole, size_t step, byte_reader read) {
    cut_anywhere(path, whole, step, read, true);
}

void survive_changes(const char *path, blob whole, size_t step, byte_reader read) {
    static const unsigned char bits[] = {0xff, 0x80, 0x01};
    for (size_t at = 0; at < whole.n_bytes; at = after(at, step))
        for (size_t i = 0; i < sizeof bits; ++i) {
            const nqm_status status = read_part(path, whole, whole.n_bytes, at, bits[i], read);
            if (status != NQM_OK && status != NQM_ERR_FORMAT && status != NQM_ERR_LIMIT)
                fail_msg("%s, byte %zu ^ %d: %s", path, at, bits[i], nqm_status_text(status));
        }
}
