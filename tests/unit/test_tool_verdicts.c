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
