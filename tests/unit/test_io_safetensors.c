/* SPDX-License-Identifier: MIT
 *
 * safetensors files: written data are read back, aligned and with a valid checksum; inconsistent headers of every kind
 * are refused with a position. tests/unit/test_net_pytorch.c reads a file of another writer.
 */
#include "base/memory_test.h"
#include "io/io.h"
#include "support/check.h"
#include "support/damage.h"

/* ---- writing and reading back ------------------------------------------------------------------------------------ */

static const float weights[2][16] = {{1, 2, 3}, {-1}};
static const double odd[3] = {0.5, -1e300, 3};
static const uint8_t bytes[5] = {1, 2, 3, 4, 255};
static const int64_t scalar = -7;
static const nqm_tensor tensors[] = {
    {.name = "bytes", .dtype = NQM_U8, .n_dims = 1, .dims = {5}, .n_bytes = 5, .data = bytes},
    {.name = "odd", .dtype = NQM_F64, .n_dims = 2, .dims = {3, 1}, .n_bytes = 24, .data = odd},
    {.name = "weights", .dtype = NQM_F32, .n_dims = 2, .dims = {2, 16}, .n_bytes = 128, .data = weights},
    {.name = "scalar", .dtype = NQM_I64, .n_dims = 0, .n_bytes = 8, .data = &scalar},
    {.name = "empty", .dtype = NQM_F32, .n_dims = 2, .dims = {0, 4}, .n_bytes = 0, .data = weights},
};
enum { N_TENSORS = sizeof tensors / sizeof *tensors };
static const nqm_meta meta[] = {{"card", "A \"quoted\" card,\nwith lines and \xc3\xbc. \"sha256\":\"0000\""},
                                {"id", ""}};

/* The content of a valid file; free with nqm_free(). */
static unsigned char *valid_file(size_t *n_bytes, char sha256[65]) {
    nqm_map map;
    assert_int_equal(nqm_safetensors_write(scratch_path("out.safetensors"), N_TENSORS, tensors, 2, meta, sha256, NULL),
                     NQM_OK);
    assert_int_equal(nqm_map_open(scratch_path("out.safetensors"), &map, NULL), NQM_OK);
    unsigned char *copy = nqm_alloc(map.n_bytes, 1);
    memcpy(copy, map.data, map.n_bytes);
    *n_bytes = map.n_bytes;
    nqm_map_close(&map);
    return copy;
}

TEST(round_trip) {
    size_t n_bytes;
    char sha256[65], again[65];
    bool matches;
    unsigned char *file = valid_file(&n_bytes, sha256);
    nqm_safetensors *st;
    assert_int_equal(nqm_safetensors_parse(file, n_bytes, "f", &st, NULL), NQM_OK);
    assert_int_equal(nqm_safetensors_count(st), N_TENSORS);
    for (size_t i = 0; i < N_TENSORS; ++i) {
        const nqm_tensor *t = nqm_safetensors_find(st, tensors[i].name);
        assert_non_null(t);
        assert_int_equal(t->dtype, tensors[i].dtype);
        assert_int_equal(t->n_dims, tensors[i].n_dims);
        assert_memory_equal(t->dims, tensors[i].dims, t->n_dims * sizeof *t->dims);
        assert_int_equal(t->n_bytes, tensors[i].n_bytes);
        assert_memory_equal(t->data, tensors[i].data, t->n_bytes);
        if (!NQM_BIG_ENDIAN)
            assert_ptr_equal(t->data, file + t->byte_offset);
    }
    assert_int_equal(nqm_safetensors_find(st, "weights")->byte_offset % 64, 0);
    assert_string_equal(nqm_safetensors_at(st, 0)->name, "weights"); /* sizes that are multiples of 64 come first */
    assert_null(nqm_safetensors_find(st, "none"));
    assert_string_equal(nqm_safetensors_meta(st, "card"), meta[0].value);
    assert_string_equal(nqm_safetensors_meta(st, "id"), "");
    assert_null(nqm_safetensors_meta(st, "none"));
    assert_true(nqm_safetensors_checksum(st, again, &matches));
    assert_true(matches);
    assert_string_equal(again, sha256);
    nqm_safetensors_free(st);
    nqm_free(file);
}

/* The checksum is the SHA-256 of the file with the checksum's digits set to zeros, and detects a change of any bit. */
TEST(checksum) {
    size_t n_bytes;
    char sha256[65], hex[65];
    unsigned char *file = valid_file(&n_bytes, sha256), *zeroed = nqm_alloc(n_bytes, 1);
    memcpy(zeroed, file, n_bytes);
    bool found = false;
    for (size_t i = 0; i + 64 <= n_bytes; ++i)
        if (memcmp(zeroed + i, sha256, 64) == 0) {
            assert_false(found);
            found = true;
            memset(zeroed + i, '0', 64);
        }
    assert_true(found);
    nqm_sha256 sha;
    assert_true(nqm_sha256_begin(&sha));
    nqm_sha256_add(&sha, zeroed, n_bytes);
    nqm_sha256_end(&sha, hex);
    assert_string_equal(hex, sha256);
    for (size_t i = 0; i < n_bytes; ++i) {
        nqm_safetensors *st;
        bool matches = false;
        file[i] ^= 1;
        if (nqm_safetensors_parse(file, n_bytes, "f", &st, NULL) == NQM_OK) {
            if (nqm_safetensors_checksum(st, hex, &matches))
                assert_false(matches);
            nqm_safetensors_free(st);
        }
        file[i] ^= 1;
    }
    nqm_free(zeroed);
    nqm_free(file);
}

TEST(truncated_anywhere) {
    size_t n_bytes;
    unsigned char *file = valid_file(&n_bytes, NULL);
    refuse_cuts("cut.file", (blob){file, n_bytes}, 1, read_safetensors);
    nqm_free(file);
}

/* ---- inconsistent headers ---------------------------------------------------------------------------------------- */

static nqm_status parse_header(const char *json, size_t n_data, nqm_error *err) {
    size_t n_json = strlen(json), n = 8 + n_json + n_data;
    unsigned char *file = malloc(n);
    memset(file, 0, n);
    nqm_store_u64(file, n_json);
    memcpy(file + 8, json, n_json);
    nqm_safetensors *st;
    nqm_status status = nqm_safetensors_parse(file, n, "lie", &st, err);
    assert_true((status == NQM_OK) == (st != NULL));
    nqm_safetensors_free(st);
    free(file);
    return status;
}

#define A(shape, from, to)      "\"a\":{\"dtype\":\"F32\",\"shape\":" shape ",\"data_offsets\":[" from "," to "]}"
#define ONLY_A(shape, from, to) "{" A(shape, from, to) "}"

/* Headers of files with n_data bytes of data that are refused with the same message. */
static const struct {
    const char *message;
    size_t n_data;
    const char *json[4];
} false_header[] = {
    {"header", 0, {"", "{\"a\":", "{} x"}},
    {"header", 8, {"{" A("[1]", "0", "4") "," A("[1]", "4", "8") "}"}}, /* the same name twice */
    {"not an object", 0, {"[]", "{\"__metadata__\":[]}"}},
    {"not a string", 0, {"{\"__metadata__\":{\"k\":1}}"}},
    {"dtype is none of", 0, {"{\"a\":3}", "{\"a\":{}}"}},
    {"dtype is none of", 4, {"{\"a\":{\"dtype\":\"F8\",\"shape\":[4],\"data_offsets\":[0,4]}}"}},
    {"list of at most 6 sizes",
     4,
     {ONLY_A("3", "0", "4"), ONLY_A("[1,1,1,1,1,1,1]", "0", "4"), ONLY_A("[-1]", "0", "4"), ONLY_A("[1.0]", "0", "4")}},
    {"two sizes",
     4,
     {ONLY_A("[1]", "-4", "0"), "{\"a\":{\"dtype\":\"F32\",\"shape\":[1],\"data_offsets\":[0]}}",
      "{\"a\":{\"dtype\":\"F32\",\"shape\":[1]}}"}},
    {"beyond the end",
     4,
     {ONLY_A("[1]", "4", "0"), ONLY_A("[2]", "0", "8"), ONLY_A("[1]", "9223372036854775803", "9223372036854775807")}},
    {"shape does not match",
     4,
     {ONLY_A("[2]", "0", "4"), ONLY_A("[2147483648,2147483648]", "0", "4"),
      ONLY_A("[4611686018427387905]", "0", "4")}}, /* 4 n wraps to 4 */
    {"overlaps", 5, {"{" A("[1]", "0", "4") ",\"b\":{\"dtype\":\"U8\",\"shape\":[2],\"data_offsets\":[3,5]}}"}},
    {"gap", 6, {"{" A("[1]", "0", "4") ",\"b\":{\"dtype\":\"U8\",\"shape\":[1],\"data_offsets\":[5,6]}}"}},
    {"gap", 5, {ONLY_A("[1]", "1", "5")}},
    {"after the last", 5, {ONLY_A("[1]", "0", "4")}},
    {"after the last", 1, {"{}"}},
};

static void check_false_header(const char *json, size_t n_data, const char *message) {
    nqm_error err = {0};
    nqm_status status = parse_header(json, n_data, &err);
    if (status != NQM_ERR_FORMAT || !strstr(err.message, message))
        print_error("%s: %s\n", json, err.message);
    assert_int_equal(status, NQM_ERR_FORMAT);
    assert_non_null(strstr(err.message, message));
    assert_non_null(strstr(err.message, "lie: "));
    assert_true(err.byte_offset >= 0);
}

TEST(false_headers) {
    for (size_t i = 0; i < sizeof false_header / sizeof *false_header; ++i)
        for (size_t k = 0; k < 4 && false_header[i].json[k]; ++k)
            check_false_header(false_header[i].json[k], false_header[i].n_data, false_header[i].message);
    assert_int_equal(parse_header("{}", 0, NULL), NQM_OK);
    assert_int_equal(parse_header(ONLY_A("[1]", "0", "4") "  ", 4, NULL), NQM_OK);
}

/* A header length beyond the file or the format's limit is refused before any allocation. */
TEST(claimed_header_lengths) {
    static const uint64_t claims[] = {9, 100000001, (uint64_t)1 << 62, UINT64_MAX};
    for (size_t i = 0; i < sizeof claims / sizeof *claims; ++i) {
        unsigned char file[16] = {0};
        nqm_safetensors *st;
        nqm_error err = {0};
        nqm_store_u64(file, claims[i]);
        nqm_alloc_fail_after(0);
        assert_int_equal(nqm_safetensors_parse(file, sizeof file, "f", &st, &err), NQM_ERR_FORMAT);
        nqm_alloc_fail_after(-1);
        assert_int_equal(err.byte_offset, 0);
    }
}

/* The byte after a file that ends with the length of its header decides nothing. */
TEST(text_of_eight_bytes) {
    static const char text[] = "a,b\n1,2\n{";
    nqm_safetensors *st;
    nqm_error err = {0};
    assert_int_equal(nqm_safetensors_parse((const unsigned char *)text, 8, "f", &st, &err), NQM_ERR_FORMAT);
    assert_non_null(strstr(err.message, "begins like CSV"));
}

/* ---- invalid data for the writer --------------------------------------------------------------------------------- */

TEST(refused_contents) {
    nqm_error err = {0};
    nqm_tensor twice[2] = {tensors[0], tensors[0]}, wrong = tensors[0];
    wrong.dims[0] = 6;
    const nqm_meta reserved = {"sha256", "x"}, not_utf8 = {"k", "\xff"}, same[2] = {{"k", "1"}, {"k", "2"}};
    const char *path = scratch_path("refused.safetensors");
    assert_int_equal(nqm_safetensors_write(path, 2, twice, 0, NULL, NULL, &err), NQM_ERR_ARG);
    assert_int_equal(nqm_safetensors_write(path, 1, &wrong, 0, NULL, NULL, &err), NQM_ERR_ARG);
    assert_int_equal(nqm_safetensors_write(path, 1, tensors, 1, &reserved, NULL, &err), NQM_ERR_ARG);
    assert_int_equal(nqm_safetensors_write(path, 1, tensors, 1, &not_utf8, NULL, &err), NQM_ERR_ARG);
    assert_int_equal(nqm_safetensors_write(path, 1, tensors, 2, same, NULL, &err), NQM_ERR_ARG);
    assert_int_equal(access(path, F_OK), -1);
    assert_int_equal(nqm_safetensors_write("no/such/folder/f", 1, tensors, 0, NULL, NULL, &err), NQM_ERR_IO);
    assert_non_null(strstr(err.message, "no/such/folder/f"));
}

TEST(out_of_memory) {
    size_t n_bytes;
    unsigned char *file = valid_file(&n_bytes, NULL);
    nqm_safetensors *st;
    nqm_alloc_fail_after(0);
    assert_int_equal(nqm_safetensors_parse(file, n_bytes, "f", &st, NULL), NQM_ERR_NOMEM);
    assert_null(st);
    for (long n = 0; n < 3; ++n) {
        nqm_alloc_fail_after(n);
        assert_int_equal(
            nqm_safetensors_write(scratch_path("refused.safetensors"), N_TENSORS, tensors, 2, meta, NULL, NULL),
            NQM_ERR_NOMEM);
        assert_int_equal(access(scratch_path("refused.safetensors"), F_OK), -1);
    }
    nqm_alloc_fail_after(-1);
    nqm_free(file);
}
