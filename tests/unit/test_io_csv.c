/* SPDX-License-Identifier: MIT
 *
 * The CSV reader: quoting, line ends, comments, ragged rows, numbers and the position of errors, and truncation at
 * every byte.
 */
#include "io/io.h"
#include "support/allocations.h"
#include "support/check.h"
#include "support/damage.h"

static nqm_status parse(const char *text, nqm_csv **csv, nqm_error *err) {
    return nqm_csv_parse(text, strlen(text), "t.csv", csv, err);
}

TEST(test_plain) {
    nqm_csv *csv;
    assert_int_equal(
        parse("# a comment, with a comma\nName, x ,y\n\n  \nfelt,1.5,-2e3\r\nsatin , .25,7\n#last\nleaf,,3", &csv,
              NULL),
        NQM_OK);
    assert_int_equal(nqm_csv_rows(csv), 3);
    assert_int_equal(nqm_csv_column(csv, "name"), 0);
    assert_int_equal(nqm_csv_column(csv, "X"), 1);
    assert_int_equal(nqm_csv_column(csv, "z"), -1);
    assert_int_equal(nqm_csv_column(csv, "nam"), -1);
    assert_string_equal(nqm_csv_text(csv, 0, 0), "felt");
    assert_string_equal(nqm_csv_text(csv, 1, 0), "satin");
    assert_string_equal(nqm_csv_text(csv, 2, 1), "");
    double value;
    assert_int_equal(nqm_csv_number(csv, 0, 2, &value, NULL), NQM_OK);
    assert_near(value, -2000, 0);
    assert_int_equal(nqm_csv_number(csv, 1, 1, &value, NULL), NQM_OK);
    assert_near(value, 0.25, 0);
    nqm_csv_free(csv);
}

TEST(test_quotes) {
    nqm_csv *csv;
    assert_int_equal(parse("\"a,b\",c\r\n\"says \"\"yes\"\"\",\"two\nlines\" \r\n\"\",\" 4 \"\n", &csv, NULL), NQM_OK);
    assert_int_equal(nqm_csv_rows(csv), 2);
    assert_int_equal(nqm_csv_column(csv, "a,b"), 0);
    assert_string_equal(nqm_csv_text(csv, 0, 0), "says \"yes\"");
    assert_string_equal(nqm_csv_text(csv, 0, 1), "two\nlines");
    assert_string_equal(nqm_csv_text(csv, 1, 0), "");
    double value;
    assert_int_equal(nqm_csv_number(csv, 1, 1, &value, NULL), NQM_OK);
    assert_near(value, 4, 0);
    nqm_csv_free(csv);
}

TEST(test_byte_order_mark) {
    nqm_csv *csv;
    assert_int_equal(parse("\xef\xbb\xbfmaterial\nfelt\n", &csv, NULL), NQM_OK);
    assert_int_equal(nqm_csv_column(csv, "material"), 0);
    nqm_csv_free(csv);
}

/* The header decides: a comma outside of quotes, else a semicolon, else a tab. */
TEST(test_separators) {
    static const struct {
        const char *text, *cell[2]; /* of the first row */
    } cases[] = {{"a;b\n1,5; x \n", {"1,5", "x"}}, {"# a, comment\n\"a,b\";c\n1;2\n", {"1", "2"}},
                 {"a\tb\n\t x y \n", {"", "x y"}}, {"a \t \"b\"\n\"1;2\"\t \"3\t4\"\n", {"1;2", "3\t4"}},
                 {"a;b\tc\n1;2\t\n", {"1", "2"}},  {"a;b,c\td\n1;,\t2\n", {"1;", "2"}}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        nqm_csv *csv;
        assert_int_equal(parse(cases[i].text, &csv, NULL), NQM_OK);
        assert_int_equal(nqm_csv_columns(csv), 2);
        for (int k = 0; k < 2; ++k)
            assert_string_equal(nqm_csv_text(csv, 0, k), cases[i].cell[k]);
        nqm_csv_free(csv);
    }
}

static void refuse(const char *text, int64_t byte, const char *words) {
    nqm_csv *csv = (nqm_csv *)(uintptr_t)1;
    nqm_error err = {0};
    assert_int_equal(parse(text, &csv, &err), NQM_ERR_FORMAT);
    assert_null(csv);
    assert_int_equal(err.byte_offset, byte);
    assert_non_null(strstr(err.message, "t.csv"));
    assert_non_null(strstr(err.message, words));
}

TEST(test_refusals) {
    refuse("", 0, "empty");
    refuse("\n# only talk\n", 0, "empty");
    refuse("a,b\n1,2\n3\n", 8, "line 3, byte 8: 1 fields where the header has 2");
    refuse("a,b\n1,2,3\n", 4, "3 fields");
    refuse("a,b\n1,\"2\n", 7, "does not end");
    refuse("a,b\n1,\"2\"3\n", 7, "does not end");
    refuse("a\n\"\"\"", 3, "does not end");
    nqm_error err = {0};
    nqm_csv *csv;
    assert_int_equal(nqm_csv_parse("a,b\n1,\0\n", 8, "t.csv", &csv, &err), NQM_ERR_FORMAT);
    assert_int_equal(err.byte_offset, 6);
}

TEST(test_numbers_name_their_place) {
    static const char *const bad[] = {"x", "", "1.5x", "nan", "inf", "1e999", "1 2"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        char text[64];
        snprintf(text, sizeof text, "# c\nname,JOD\nfelt,1\nleaf,%s\n", bad[i]);
        nqm_csv *csv;
        assert_int_equal(parse(text, &csv, NULL), NQM_OK);
        nqm_error err = {0};
        double value = -7;
        assert_int_equal(nqm_csv_number(csv, 1, 1, &value, &err), NQM_ERR_FORMAT);
        assert_near(value, -7, 0);
        assert_int_equal(err.byte_offset, 25);
        assert_non_null(strstr(err.message, "t.csv: line 4, byte 25: column 'JOD'"));
        nqm_csv_free(csv);
    }
}

TEST(test_every_cut_is_safe) {
    unsigned char text[] = "a,\"b\"\n1,\"x\"\"y\"\r\n\"2\n\",3\n#\n";
    survive_cuts("cut", (blob){text, sizeof text}, 1, read_csv);
}

TEST(test_files) {
    nqm_csv *csv;
    nqm_error err = {0};
    assert_int_equal(nqm_csv_load("/nowhere/t.csv", &csv, &err), NQM_ERR_IO);
    assert_non_null(strstr(err.message, "/nowhere/t.csv"));
    assert_int_equal(nqm_csv_load("/", &csv, NULL), NQM_ERR_IO);
    assert_int_equal(nqm_csv_load(test_vector("stats_expected.csv"), &csv, NULL), NQM_OK);
    assert_int_equal(nqm_csv_column(csv, "pearson"), 1);
    nqm_csv_free(csv);
}

TEST(test_open_descriptor) {
    enum { ROWS = 30000 };
    char path[32];
    FILE *file = tmpfile();
    assert_non_null(file);
    fputs("i\n", file);
    for (int i = 0; i < ROWS; ++i)
        fprintf(file, "%d\n", i);
    fflush(file);
    snprintf(path, sizeof path, "/dev/fd/%d", fileno(file)); /* the path that the tool uses for standard input */
    nqm_csv *csv;
    assert_int_equal(nqm_csv_load("-", &csv, NULL), NQM_ERR_IO); /* the library treats "-" as a file name */
    assert_int_equal(nqm_csv_load(path, &csv, NULL), NQM_OK);
    assert_int_equal(nqm_csv_rows(csv), ROWS);
    assert_string_equal(nqm_csv_text(csv, ROWS - 1, 0), "29999");
    nqm_csv_free(csv);
    fclose(file);
}

TEST(test_out_of_memory) {
    nqm_status status = NQM_OK;
    long n = -1;
    EVERY_ALLOCATION(n, status, 0) {
        nqm_csv *csv;
        status = parse("a,b\n1,2\n", &csv, NULL);
        assert_true((status == NQM_OK) == (csv != NULL));
        nqm_csv_free(csv);
    }
    assert_int_equal(n, 1);
}
