/* SPDX-License-Identifier: MIT
 *
 * Words, shares and gates of scores at the ends of their ranges.
 */
#include "nqm/score/score.h"
#include "nqm/show/html.h"
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
        assert_string_equal(jod_words(ends[i].from), ends[i].words);
        assert_string_equal(jod_words(nextafter(ends[i].from, 0)), ends[i].below);
    }
}

TEST(verdicts_are_those_of_the_interval) {
    char text[VERDICT_TEXT];
    nqm_score_result r = scored(9.2, 8.5, 9.6);
    assert_string_equal(verdict_words(&r, text), "between practically the same and visible");
    r = scored(9.2, 9, 9.4);
    assert_string_equal(verdict_words(&r, text), "hardly visible");
    r = scored(9.2, NAN, NAN);
    assert_string_equal(verdict_words(&r, text), "hardly visible");
    r.identical = 1;
    assert_string_equal(verdict_words(&r, text), "identical");
    assert_true(preference_share(&r) == 0.5);
    r = scored(9, 9, 9);
    assert_true(fabs(preference_share(&r) - 0.75) < 1e-15);
    r = scored(10.5, 10, 11); /* above 10 the reference is no better */
    assert_true(preference_share(&r) == 0.5);
    r.status = NQM_ERR_IO;
    assert_string_equal(verdict_words(&r, text), "");
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

TEST(people_are_percentages) {
    json_t *people = html_people(0.126);
    assert_string_equal(json_string_value(people), "13\xc2\xa0%");
    json_decref(people);
}
