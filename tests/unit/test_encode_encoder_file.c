/* SPDX-License-Identifier: MIT
 *
 * Files of learned encoders: a written file is read back with its references; a file of another kind, a changed byte, a
 * value that is not finite and a tensor of another shape are errors.
 */
#include "encode/encode.h"
#include "support/check.h"
#include "support/encoder_files.h"
#include "support/scratch.h"

static void write_file(const float *values) {
    const nqm_tensor tensor = {
        .name = "atoms", .dtype = NQM_F32, .n_dims = 2, .dims = {2, 3}, .n_bytes = 6 * sizeof *values, .data = values};
    write_encoder(scratch_path("encoder"), "sparse", 1, &tensor);
}

/* Parse the file with `change` added to its byte `at` (negative: from the end). */
static nqm_status parse(long at, int change, const char *kind, nqm_error *err) {
    nqm_map map;
    nqm_safetensors *st;
    assert_int_equal(nqm_map_open(scratch_path("encoder"), &map, NULL), NQM_OK);
    unsigned char *bytes = nqm_alloc(map.n_bytes, 1);
    memcpy(bytes, map.data, map.n_bytes);
    bytes[at < 0 ? (long)map.n_bytes + at : at] += (unsigned char)change;
    nqm_status status = nqm_encoder_parse(bytes, map.n_bytes, "x", kind, &st, err);
    if (status == NQM_OK)
        nqm_safetensors_free(st);
    else
        assert_null(st);
    nqm_free(bytes);
    nqm_map_close(&map);
    return status;
}

static const float good[6] = {1, 2, 3, 4, 5, 6};

TEST(a_file_is_read_back) {
    nqm_map map;
    nqm_safetensors *st;
    const nqm_tensor *tensor;
    write_file(good);
    assert_int_equal(nqm_map_open(scratch_path("encoder"), &map, NULL), NQM_OK);
    assert_int_equal(nqm_encoder_parse(map.data, map.n_bytes, scratch_path("encoder"), "sparse", &st, NULL), NQM_OK);
    assert_string_equal(nqm_safetensors_meta(st, "references"), "[\"rgl/\\\"quoted\\\".bsdf\",\"sgd:nickel\"]");
    const nqm_tensor any = {.name = "atoms", .n_dims = 2, .dims = {2, 0}};
    const nqm_tensor others[] = {{.name = "atoms", .n_dims = 2, .dims = {3, 2}},
                                 {.name = "atoms", .n_dims = 1, .dims = {6}},
                                 {.name = "codes", .n_dims = 1, .dims = {6}}};
    assert_int_equal(nqm_safetensors_floats(st, &any, NQM_ERR_MODEL, &tensor, NULL), NQM_OK);
    assert_memory_equal(tensor->data, good, sizeof good);
    nqm_error err = {0};
    for (size_t i = 0; i < 3; ++i)
        assert_int_equal(nqm_safetensors_floats(st, &others[i], NQM_ERR_MODEL, &tensor, &err), NQM_ERR_MODEL);
    assert_non_null(strstr(err.message, "codes"));
    nqm_safetensors_free(st);
    nqm_map_close(&map);
}

TEST(other_files_are_refused) {
    nqm_error err = {0};
    write_file(good);
    assert_int_equal(parse(0, 0, "sparse", &err), NQM_OK);
    assert_int_equal(parse(0, 0, "hyper", &err), NQM_ERR_MODEL);
    assert_non_null(strstr(err.message, "hyper"));
    assert_int_equal(parse(-1, 1, "sparse", &err), NQM_ERR_MODEL);
    assert_non_null(strstr(err.message, "checksum"));
    const float bad[6] = {1, 2, NAN, 4, 5, 6};
    write_file(bad);
    assert_int_equal(parse(0, 0, "sparse", &err), NQM_ERR_MODEL);
    assert_non_null(strstr(err.message, "finite"));
}

TEST(embedded_files_are_found_by_name) {
    size_t n;
    assert_null(nqm_encoder_bytes("nothing", &n));
    for (const nqm_embedded_file *file = nqm_embedded_encoders; file->name; ++file) {
        nqm_safetensors *st;
        const unsigned char *bytes = nqm_encoder_bytes(file->name, &n);
        assert_int_equal(nqm_encoder_parse(bytes, n, file->name, file->name, &st, NULL), NQM_OK);
        assert_non_null(nqm_safetensors_meta(st, "references"));
        nqm_safetensors_free(st);
    }
}
