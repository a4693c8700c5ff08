/* SPDX-License-Identifier: MIT
 *
 * Each allocation of jansson fails once while a text is read or written: reader or writer says so; none reads or writes
 * another text, or blames it. The tool ends.
 */
#include "io/io.h"
#include "io/json.h"
#include "material/material.h"
#include "nqm/score/score.h"
#include "support/check.h"
#include "support/scratch.h"
#include "train/train.h"

#include <sys/wait.h>

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

TEST(every_allocation_fails) {
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

/* ---- writing ----------------------------------------------------------------------------------------------------- */

/* Returns whether the allocation that was to fail was made. */
static bool end_failing(void) {
    const bool has_failed = countdown < 0;
    countdown = -1;
    return has_failed;
}

TEST(no_tensor_file_lacks_a_value) {
    const float value[6] = {1, 2, 3, 4, 5, 6};
    const nqm_tensor tensor = {
        .name = "a", .dtype = NQM_F32, .n_dims = 3, .dims = {1, 2, 3}, .n_bytes = 24, .data = value};
    const nqm_meta meta = {"key", "some words that are here"};
    bool has_failed = true;
    for (long n = 0; has_failed; ++n) {
        nqm_error err = {0};
        countdown = n;
        const nqm_status status =
            nqm_safetensors_write(scratch_path("file.safetensors"), 1, &tensor, 1, &meta, NULL, &err);
        has_failed = end_failing();
        if (status != (has_failed ? NQM_ERR_NOMEM : NQM_OK))
            fail_msg("allocation %ld: %d, %s", n, status, err.message);
        assert_true(has_failed || n > 10);
    }
}

TEST(no_list_of_sizes_lacks_one) {
    nqm_train_options options;
    assert_int_equal(nqm_train_options_recipe("nqm", &options, NULL), NQM_OK);
    json_t *all = nqm_train_options_json(&options);
    bool has_failed = true;
    for (long n = 0; has_failed; ++n) {
        countdown = n;
        json_t *json = nqm_train_options_json(&options);
        has_failed = end_failing();
        assert_true(has_failed ? !json : json_equal(json, all));
        json_decref(json);
    }
    json_decref(all);
}

/* In a child process for each allocation, which ends with the tool's exit code. */
TEST(no_remark_of_the_tool_is_missing) {
    nqm_model *model;
    assert_int_equal(nqm_model_builtin("default", &model, NULL), NQM_OK);
    const remark_terms terms = {.model = model};
    const nqm_named_pair pair = {"ref", "test"};
    const nqm_score_result result = {.n_clamped[0] = 1, .n_invalid[1] = 2, .novelty = 2, .jod_high = 1};
    int code = EXIT_LIMIT;
    for (long n = 0; code == EXIT_LIMIT; ++n) {
        const pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0) {
            stop_without_json_memory();
            countdown = n;
            _exit(json_array_size(json_remarks(&terms, &pair, "ref", "test", &result)) == 3 ? EXIT_OK : EXIT_FAILURE);
        }
        int state_of_child;
        assert_int_equal(waitpid(child, &state_of_child, 0), child);
        assert_true(WIFEXITED(state_of_child));
        code = WEXITSTATUS(state_of_child);
        assert_true(code == EXIT_LIMIT || n > 3);
    }
    nqm_model_free(model);
    assert_int_equal(code, EXIT_OK);
}

static int make_failing(void **state) {
    (void)state;
    json_set_alloc_funcs(failing_malloc, free);
    return 0;
}

TEST_FILE(make_failing, NULL)
