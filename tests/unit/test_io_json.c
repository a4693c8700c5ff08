/* SPDX-License-Identifier: MIT
 *
 * Each allocation of jansson fails once while a text is read: the reader says so, and neither reads another text nor blames it.
 */
#include "io/io.h"
#include "io/options_json.h"
#include "material/material.h"
#include "support/check.h"

#include <stdlib.h>
#include <string.h>

static long countdown = -1; /* allocations until one fails */

/* Installed before the library sees jansson's allocator, which it keeps. */
static void *failing_malloc(size_t n) {
    return countdown >= 0 && countdown-- == 0 ? NULL : malloc(n);
}

static nqm_status read_materials(const char *text, size_t n, nqm_error *err) {
    const nqm_map map = {.data = (const unsigned char *)text, .n_bytes = n, .path = "text"};
    nqm_materials *materials;
    const nqm_status status = nqm_materials_read(&map, &materials, err);
    if (status == NQM_OK && !nqm_materials_get(materials, 0).spec)
        fail_msg("a material that is refused: %s", nqm_materials_get(materials, 0).refusal);
    if (status == NQM_OK)
        nqm_materials_free(materials);
    return status;
}

static nqm_status read_tensors(const char *text, size_t n, nqm_error *err) {
    unsigned char bytes[512] = {(unsigned char)n};
    nqm_safetensors *st;
    memcpy(bytes + 8, text, n);
    const nqm_status status = nqm_safetensors_parse(bytes, n + 8, "text", &st, err);
    if (status == NQM_OK)
        nqm_safetensors_free(st);
    return status;
}

static nqm_status read_value(const char *text, size_t n, nqm_error *err) {
    (void)n;
    json_t *value;
    const nqm_status status = nqm_json_parse(text, &value, err);
    if (status == NQM_OK)
        assert_string_equal(json_string_value(json_array_get(value, 0)), "a name that is longer than jansson's buffer");
    json_decref(value);
    return status;
}

static const struct {
    const char *text;
    nqm_status (*read)(const char *text, size_t n, nqm_error *err);
} texts[] = {
    {"[\"a name that is longer than jansson's buffer\"]", read_value},
    {"{\"asset\":{\"version\":\"2.0\"},\"materials\":[{\"name\":\"a\",\"pbrMetallicRoughness\":{\"metallicFactor\":0."
     "25,"
     "\"roughnessFactor\":0.5}}]}",
     read_materials},
    {"{\"type\":\"scene\",\"a\":{\"type\":\"roughplastic\",\"alpha\":0.2,\"int_ior\":1.5,\"distribution\":\"ggx\"}}",
     read_materials},
    {"{\"__metadata__\":{\"a\":\"some words that are here\"}}", read_tensors},
};

static void every_allocation_fails(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof texts / sizeof *texts; ++i) {
        nqm_error err = {0};
        assert_int_equal(texts[i].read(texts[i].text, strlen(texts[i].text), &err), NQM_OK);
        bool has_failed = true;
        for (long n = 0; has_failed; ++n) {
            countdown = n;
            const nqm_status status = texts[i].read(texts[i].text, strlen(texts[i].text), &err);
            has_failed = countdown < 0;
            countdown = -1;
            if (status != (has_failed ? NQM_ERR_NOMEM : NQM_OK))
                fail_msg("text %zu, allocation %ld: %d, %s", i, n, status, err.message);
            assert_true(has_failed || n > 4);
        }
    }
}

int main(void) {
    json_set_alloc_funcs(failing_malloc, free);
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_allocation_fails)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
