/* SPDX-License-Identifier: MIT
 *
 * Words, shares and gates of scores at the ends of their ranges.
 */
#include "nqm/score/score.h"
#include "nqm/template.h"
#include "support/check.h"

static nqm_score_result scored(double jod, double low, double high) {
    return (nqm_score_result){.status = NQM_OK, .jod = jod, .jod_low = low, .jod_high = high};
}

/* "from 9.5 practically the same; from 9 hardly visible; from 8 visible; from 6 clearly visible; below very different" (README) */
TEST(words_begin_at_their_jod) {
    static const struct {
        double from;
        const char *words, *below;
    } ends[] = {{9.5, "practically the same", "hardly visible"},
                {9, "hardly visible", "visible"},
                {8, "visible", "clearly visible"},
                {6, "clearly visible", "very different"}};
    for (size_t i = 0; i < sizeof ends / sizeof *ends; ++i) {
        assert_string_equal(nqm_verdict_words(ends[i].from), ends[i].words);
        assert_string_equal(nqm_verdict_words(nextafter(ends[i].from, 0)), ends[i].below);
    }
}

TEST(verdicts_are_those_of_the_interval) {
    char text[NQM_VERDICT_TEXT];
    nqm_score_result r = scored(9.2, 8.5, 9.6);
    assert_string_equal(nqm_verdict(&r, text), "between practically the same and visible");
    r = scored(9.2, 9, 9.4);
    assert_string_equal(nqm_verdict(&r, text), "hardly visible");
    r = scored(9.2, NAN, NAN);
    assert_string_equal(nqm_verdict(&r, text), "hardly visible");
    r.identical = 1;
    assert_string_equal(nqm_verdict(&r, text), "identical");
    assert_true(nqm_verdict_preference(&r) == 0.5);
    r = scored(9, 9, 9);
    assert_true(fabs(nqm_verdict_preference(&r) - 0.75) < 1e-15);
    r = scored(10.5, 10, 11); /* above 10 the reference is no better */
    assert_true(nqm_verdict_preference(&r) == 0.5);
    r.status = NQM_ERR_IO;
    assert_string_equal(nqm_verdict(&r, text), "");
}

/* Each number of a result is in the column of its name, and one without a score is in none. */
TEST(columns_have_the_values_of_the_result) {
    nqm_score_result r = scored(9.2, 8.5, 9.6);
    nqm_texture_result t = {.median = 9.75, .far_jod = {9, 8, 9.5}};
    r.identical = 0, r.n_valid = 1800, r.similarity[0] = 9.1, r.metrics[NQM_METRIC_MAE] = 0.25;
    r.parts = (nqm_label){.shift = {-4, 0, 5}, .contrast = 0.5, .structure = 2};
    static const struct {
        const char *name, *object, *member;
        double value;
    } expected[] = {{"jod", "", "jod", 9.2},
                    {"identical", "", "identical", 0},
                    {"n_valid", "", "n_valid", 1800},
                    {"shift_p", "parts", "shift_itp.2", 5},
                    {"similarity_jod", "parts", "similarity_jod", 9.1},
                    {"mae", "metrics", "mae", 0.25},
                    {"median_jod", "texture", "median_jod", 9.75},
                    {"far_jod_high", "texture", "far_jod_high", 9.5}};
    size_t n_found = 0;
    nqm_column c;
    for (size_t i = 0; (c = nqm_score_column(i, &r, &t)).name; ++i) {
        if (strcmp(c.name, "verdict") == 0)
            assert_string_equal(c.text, "between practically the same and visible");
        for (size_t k = 0; k < i; ++k)
            assert_string_not_equal(nqm_score_column(k, NULL, NULL).name, c.name);
        for (size_t k = 0; k < sizeof expected / sizeof *expected; ++k)
            if (strcmp(c.name, expected[k].name) == 0) {
                assert_string_equal(c.object, expected[k].object);
                assert_string_equal(c.member, expected[k].member);
                assert_true(c.number == expected[k].value);
                assert_true(isnan(nqm_score_column(i, NULL, NULL).number));
                ++n_found;
            }
    }
    assert_int_equal(n_found, sizeof expected / sizeof *expected);
    r.status = NQM_ERR_IO;
    for (size_t i = 0; (c = nqm_score_column(i, &r, NULL)).name; ++i)
        if (c.kind == NQM_COLUMN_WHOLE || c.kind == NQM_COLUMN_FLAG)
            assert_true(isnan(c.number));
}

TEST(gates_let_their_own_value_pass) {
    const score_gate jod = {.jod = 9}, low = {.jod_low = 9}, both = {9, 8.5};
    nqm_score_result r = scored(9, 8.5, 9.4);
    assert_false(fails_gate(&jod, &r));
    assert_true(fails_gate(&low, &r));
    assert_false(fails_gate(&both, &r));
    r.jod = nextafter(9, 0);
    assert_true(fails_gate(&jod, &r) && fails_gate(&both, &r));
    assert_string_equal(gate_mark(&jod, &r), "FAIL");
    r = scored(9, 9, 9);
    assert_false(fails_gate(&low, &r));
    assert_string_equal(gate_mark(&low, &r), "pass");
    r.status = NQM_ERR_IO;
    assert_false(fails_gate(&both, &r));
    assert_string_equal(gate_mark(&low, &r), "");
}

static json_t *element(const void *user, size_t i) {
    return json_row("i:z of:s", i, (const char *)user);
}

/* Paths, numbers, percentages, lists, what is missing, elements that are made, and what XML escapes. */
TEST(templates_are_filled) {
    static const char text[] =
        "{{a.b.1:2f}} {{share:0p}} {{none:2f}}|{{#list}}{{.}};{{/list}}|{{#none}}no{{/none}}{{^none}}"
        "none{{/none}}|{{#two}}{{i}} {{of}} {{&name}} {{/two}}{{name}}";
    char *filled;
    size_t n;
    FILE *out = open_text(&filled, &n);
    fill_template(out, text, escape_xml,
                  json_row("a:{b:[ff]} share:f list:[ss] two:z name:s", 1.0, 2.345, 0.126, "x", "y", (size_t)2, "<&>"),
                  element, "of");
    fclose(out);
    assert_string_equal(filled, "2.35 13 \xe2\x80\x93|x;y;|none|0 of <&> 1 of <&> &lt;&amp;&gt;");
    free(filled);
}
