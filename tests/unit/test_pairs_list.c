/* SPDX-License-Identifier: MIT
 *
 * Lists of pairs: both formats, further columns and their types, order, errors with their positions, lack of memory.
 */
#include "pairs/pairs.h"
#include "support/allocations.h"
#include "support/check.h"

static nqm_pairs *parse(const char *text) {
    nqm_pairs *list;
    nqm_error err = {0};
    if (nqm_pairs_parse(text, strlen(text), "list", &list, &err) != NQM_OK)
        fail_msg("%s", err.message);
    return list;
}

static void assert_fault(const char *text, nqm_status status, const char *message) {
    nqm_pairs *list;
    nqm_error err = {0};
    assert_int_equal(nqm_pairs_parse(text, strlen(text), "list", &list, &err), status);
    assert_null(list);
    if (!strstr(err.message, message))
        fail_msg("'%s' lacks '%s'", err.message, message);
}

static void assert_cell(const nqm_pairs *list, size_t row, size_t i, size_t column, const char *text, int is_json) {
    nqm_pairs_cell cell;
    assert_true(nqm_pairs_get_cell(list, row, i, &cell));
    assert_int_equal(cell.column, column);
    assert_string_equal(cell.text, text);
    assert_int_equal(cell.is_json, is_json);
}

TEST(test_csv) {
    nqm_pairs *list = parse("\xef\xbb\xbfnote,Test,REFERENCE\r\n\"a, \"\"b\"\"\",t.binary,r\n,\"caf\xc3\xa9,1\",s\n");
    assert_int_equal(list->n, 2);
    assert_int_equal(list->n_columns, 3);
    assert_string_equal(list->columns[1], "Test");
    const nqm_named_pair *pairs = list->pairs;
    assert_string_equal(pairs[0].ref, "r");
    assert_string_equal(pairs[0].test, "t.binary");
    assert_string_equal(pairs[1].ref, "s");
    assert_string_equal(pairs[1].test, "caf\xc3\xa9,1");
    assert_cell(list, 0, 0, 0, "a, \"b\"", 0);
    assert_cell(list, 1, 0, 0, "", 0);
    assert_cell(list, 1, 2, 2, "s", 0);
    nqm_pairs_free(list);
    list = parse("reference,test\n");
    assert_int_equal(list->n, 0);
    nqm_pairs_free(list);
}

TEST(test_json_lines) {
    nqm_pairs *list = parse(" \n{\"test\":\"t\",\"reference\":\"r\",\"score\":8.1,\"n\":12,\"tags\":[1,\"b\"]}\n\n"
                            "{\"reference\":\"caf\\u00e9\",\"test\":\"u\",\"extra\":null,\"score\":\"8\"}");
    assert_int_equal(list->n, 2);
    assert_int_equal(list->n_columns, 6);
    assert_string_equal(list->columns[0], "test");
    assert_string_equal(list->columns[5], "extra");
    assert_string_equal(list->pairs[1].ref, "caf\xc3\xa9");
    assert_cell(list, 0, 2, 2, "8.1", 1);
    assert_cell(list, 0, 3, 3, "12", 1);
    assert_cell(list, 0, 4, 4, "[1,\"b\"]", 1);
    assert_cell(list, 1, 2, 5, "null", 1);
    assert_cell(list, 1, 3, 2, "8", 0);
    nqm_pairs_free(list);
}

TEST(test_hash) {
    nqm_pairs *list = parse("reference,test\na,b\n");
    /* printf 'reference,test\na,b\n' | sha256sum */
    assert_string_equal(list->sha256, "203ef345fb998f03d2d802473b9a24f0e7634f95f3d7a9ded5e3a18e26383be3");
    nqm_pairs_free(list);
}

TEST(test_faults) {
    assert_fault("", NQM_ERR_FORMAT, "empty");
    assert_fault("ref,test\na,b\n", NQM_ERR_FORMAT, "'reference'");
    assert_fault("reference,tests\na,b\n", NQM_ERR_FORMAT, "'test'");
    assert_fault("reference,test\na\n", NQM_ERR_FORMAT, "line 2");
    assert_fault("{\"reference\":\"a\",\"test\":\"b\"}\n{\"reference\":\"a\"}\n", NQM_ERR_FORMAT, "line 2, byte 29");
    assert_fault("\xef\xbb\xbf{\"reference\":\"a\"}", NQM_ERR_FORMAT, "line 1, byte 3");
    assert_fault("{\"reference\":\"a\",\"test\":3}\n", NQM_ERR_FORMAT, "no string \"test\"");
    assert_fault("reference,test\na,b\na,\n", NQM_ERR_FORMAT, "row 2, byte 21: column 'test' is empty");
    assert_fault("{\"reference\":\"\",\"test\":\"b\"}\n", NQM_ERR_FORMAT, "line 1, byte 0: no string \"reference\"");
    assert_fault("{\"reference\":\"a\",\"test\":\"b\"}\n[1]\n", NQM_ERR_FORMAT, "line 2");
    assert_fault("{\"reference\":\"a\",\"test\":\"b\"", NQM_ERR_FORMAT, "line 1");
    assert_fault("{\"reference\":\"a\",\"test\":\"b\",\"test\":\"c\"}", NQM_ERR_FORMAT, "uplicate");
    nqm_pairs *list;
    nqm_error err = {0};
    assert_int_equal(nqm_pairs_read("nowhere.csv", &list, &err), NQM_ERR_IO);
    assert_null(list);
}

TEST(test_too_many_columns) {
    size_t room = 40 * (size_t)(NQM_LIST_MAX_COLUMNS + 10), n = 0;
    char *text = nqm_alloc(room, 1);
    for (int i = 0; i < NQM_LIST_MAX_COLUMNS; ++i)
        n += (size_t)snprintf(text + n, room - n, "{\"reference\":\"a\",\"test\":\"b\",\"x%d\":1}\n", i);
    assert_fault(text, NQM_ERR_LIMIT, "line 1023");
    nqm_free(text);
}

TEST(test_out_of_memory) {
    static const char *const texts[] = {"reference,test,x\na,b,c\n", "{\"reference\":\"a\",\"test\":\"b\",\"x\":[1]}"};
    for (size_t t = 0; t < 2; ++t) {
        nqm_pairs *list = NULL;
        nqm_status status = NQM_OK;
        long n = -1;
        EVERY_ALLOCATION(n, status, 0) {
            status = nqm_pairs_parse(texts[t], strlen(texts[t]), "list", &list, NULL);
            assert_true((status == NQM_OK) == (list != NULL));
        }
        nqm_pairs_free(list);
    }
}
