/* SPDX-License-Identifier: MIT
 *
 * Files of several materials as pairs: names, rows, what has no partner, faulty names, lack of memory.
 */
#include "pairs/pairs.h"
#include "support/allocations.h"
#include "support/check.h"
#include "support/scratch.h"

static const char *write_file(const char *name, const char *a, const char *b) {
    char text[200];
    snprintf(text, sizeof text,
             "{\"asset\": {\"version\": \"2.0\"}, \"materials\": [{\"name\": \"%s\"}, {\"name\": \"%s\"}]}", a, b);
    return scratch_text(name, text);
}

TEST(materials_are_paired_by_name) {
    const char *old = write_file("old.gltf", "red", "gone"), *new = write_file("new.gltf", "new", "red");
    const nqm_named_pair given[] = {{"sgd:nickel", "ward:nickel"}, {old, new}, {"sgd:nickel", new}};
    const char *names[] = {NULL, "N", NULL};
    const nqm_pairs pairs = {.n = 3, .pairs = given, .names = names};
    nqm_pairs *made = NULL;
    nqm_status status = NQM_OK;
    long n = -1;
    EVERY_ALLOCATION(n, status, 0) {
        status = nqm_pairs_expand(&pairs, "transmission", &made, NULL);
        assert_true((status == NQM_OK) == (made != NULL));
    }
    const size_t rows[] = {0, 1, 1, 2, 2};
    assert_int_equal(made->n, 5);
    assert_memory_equal(made->rows, rows, sizeof rows);
    assert_string_equal(made->pairs[0].test, "ward:nickel");
    assert_string_equal(strrchr(made->pairs[2].ref, ':'), ":gone");
    assert_string_equal(strrchr(made->pairs[2].test, ':'), ":gone");
    assert_string_equal(made->names[1], "N:red");
    assert_true(made->pairs[3].ref == given[2].ref && !made->names[3] && made->left_out[0] && !made->left_out[1]);
    assert_non_null(strstr(made->left_out[0], "new.gltf:new is not compared"));
    nqm_pairs_cell cell;
    assert_false(nqm_pairs_get_cell(made, 0, 0, &cell));
    nqm_pairs_free(made);
    assert_int_equal(nqm_pairs_expand(&pairs, "glass", &made, NULL), NQM_ERR_ARG);
}

static nqm_status expand_text(const char *text, nqm_pairs **list, nqm_pairs **made, nqm_error *err) {
    *made = NULL;
    const nqm_status status = nqm_pairs_parse(text, strlen(text), "list", list, err);
    return status == NQM_OK ? nqm_pairs_expand(*list, NULL, made, err) : status;
}

TEST(names_of_lists) {
    nqm_pairs *list, *made;
    nqm_error err = {0};
    assert_int_equal(expand_text("reference,test,name\nr,A=ggx:alpha=.3,\nr,ggx:alpha=.2,B\n", &list, &made, &err),
                     NQM_OK);
    assert_string_equal(made->names[0], "A");
    assert_string_equal(made->pairs[0].test, "ggx:alpha=.3");
    assert_string_equal(made->names[1], "B");
    nqm_pairs_free(made);
    nqm_pairs_free(list);
    assert_int_equal(expand_text("reference,test\nr,A=x\nr,A=y\n", &list, &made, &err), NQM_ERR_FORMAT);
    assert_string_equal(err.message, "list: rows 1 and 2: two BRDFs have the name 'A'; give each a name of its own");
    nqm_pairs_free(list);
    assert_int_equal(expand_text("reference,test\nr,A\x01=x\n", &list, &made, &err), NQM_ERR_FORMAT);
    assert_null(made);
    nqm_pairs_free(list);
}

TEST(remarks_are_a_list) {
    char text[NQM_REMARKS_TEXT];
    nqm_model *model;
    assert_int_equal(nqm_model_load("transport", &model, NULL), NQM_OK);
    const nqm_score_result result = {.n_clamped[0] = 1, .n_invalid[1] = 2};
    nqm_pairs_remarks(model, NQM_INVALID_ZERO, NULL, "r", "t", &result, text);
    assert_string_equal(text, "r: negative channel at 1 of 1872 directions, taken as 0");
    const char *second = text + strlen(text) + 1;
    assert_string_equal(second, "t: no value at 2 of 1872 directions, taken as 0");
    assert_string_equal(second + strlen(second) + 1, "");
    nqm_pairs_remarks(model, NQM_INVALID_ZERO, NULL, NULL, "t", &result, text);
    assert_string_equal(text, second);
    nqm_model_free(model);
}
