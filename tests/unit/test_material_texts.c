/* SPDX-License-Identifier: MIT
 *
 * The texts of tests/vectors/materials.txt: each is accepted with its spec, or refused at its byte, with its words; and no beginning of one
 * is read past its end.
 */
#include "material/material.h"
#include "support/brdf_files.h"
#include "support/check.h"

typedef struct material_text {
    char *format, *verdict, *byte, *words, *text; /* as in the file */
} material_text;

static nqm_status read_bytes(const material_text *t, size_t n, nqm_materials **materials, nqm_error *err) {
    char path[64];
    unsigned char *copy = malloc(n ? n : 1); /* exactly as long, for sanitizers */
    assert_non_null(copy);
    memcpy(copy, t->text, n);
    snprintf(path, sizeof path, "x.%s", t->format);
    const nqm_map map = {.data = copy, .n_bytes = n, .path = path};
    *err = (nqm_error){0};
    const nqm_status status = nqm_materials_read(&map, materials, err);
    free(copy);
    return status;
}

static void check(const material_text *t) {
    nqm_materials *materials = NULL;
    nqm_error err;
    const size_t n = strlen(t->text);
    const nqm_status status = read_bytes(t, n, &materials, &err);
    const char *message = err.message;
    int64_t byte = err.byte_offset;
    if (strcmp(t->verdict, "error") == 0) {
        assert_int_equal(status, NQM_ERR_FORMAT);
        assert_null(materials);
    } else {
        assert_int_equal(status, NQM_OK);
        assert_int_equal(nqm_materials_count(materials), 1);
        const nqm_material_info info = nqm_materials_get(materials, 0);
        const bool is_accepted = strcmp(t->verdict, "accepted") == 0;
        if (!is_accepted == (info.spec != NULL))
            fail_msg("%s\n%s: %s", t->text, t->verdict, info.spec ? info.spec : info.refusal);
        message = is_accepted ? info.spec : info.refusal;
        byte = is_accepted ? 0 : info.byte_offset;
        if (is_accepted) {
            assert_string_equal(info.spec, t->words);
            nqm_brdf_free(must_open(info.spec));
        }
    }
    if (!strstr(message, t->words) || byte != atoll(t->byte))
        fail_msg("%s\n'%s' at %lld instead of '%s' at %s", t->text, message, (long long)byte, t->words, t->byte);
    nqm_materials_free(materials);
    for (size_t k = 0; k < n; ++k) { /* what is cut anywhere */
        const bool is_read = read_bytes(t, k, &materials, &err) == NQM_OK;
        assert_true(is_read == (materials != NULL) && (is_read || err.message[0]));
        nqm_materials_free(materials);
    }
}

/* End the string at the next `c`; what is after it. */
static char *cut(char *text, char c) {
    char *end = strchr(text, c);
    assert_non_null(end);
    *end = '\0';
    return end + 1;
}

TEST(every_text) {
    blob file = blob_load(test_vector("materials.txt"));
    char *all = malloc(file.n_bytes + 1), *at;
    size_t n = 0;
    memcpy(all, file.data, file.n_bytes);
    all[file.n_bytes] = '\0';
    for (char *next = strstr(all, "\n= "); (at = next); ++n) {
        material_text t = {.format = at + 3};
        next = strstr(t.format, "\n= ");
        if (next)
            *next = '\0';
        else
            t.format[strlen(t.format) - 1] = '\0'; /* the last line */
        t.verdict = cut(t.format, ' ');
        t.byte = cut(t.verdict, ' ');
        t.words = cut(t.byte, ' ');
        t.text = cut(t.words, '\n');
        check(&t);
    }
    assert_true(n > 260);
    free(all);
    blob_free(&file);
}
