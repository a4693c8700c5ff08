/* SPDX-License-Identifier: MIT
 *
 * The nearest of several names (base.h).
 */
#include "base/base.h"
#include "support/check.h"

static const char *advice(const char *wanted) {
    static const char *const names[] = {
        "score", "rank", "fail-under", "directions", "ggx", "ward", "the-longest-name-has-forty-characters--!", NULL};
    static nqm_nearest nearest;
    nearest = nqm_nearest_begin(wanted);
    for (size_t i = 0; names[i]; ++i)
        nqm_nearest_add(&nearest, names[i]);
    return nearest.advice;
}

TEST(misspelt_names_are_near) {
    assert_string_equal(advice("scroe"), " (did you mean 'score'?)"); /* exchanged */
    assert_string_equal(advice("scor"), " (did you mean 'score'?)");  /* too short */
    assert_string_equal(advice("rannk"), " (did you mean 'rank'?)");  /* too long */
    assert_string_equal(advice("GGX"), " (did you mean 'ggx'?)");     /* case */
    assert_string_equal(advice("fail_udner"), " (did you mean 'fail-under'?)");
    assert_string_equal(advice("derections"), " (did you mean 'directions'?)");
    assert_string_equal(advice("the-longest-name-has-forty-charactres--!"),
                        " (did you mean 'the-longest-name-has-forty-characters--!'?)");
}

TEST(other_names_are_not) {
    assert_string_equal(advice("xyzzy"), "");
    assert_string_equal(advice(""), "");
    assert_string_equal(advice("drwa"), ""); /* 'ward' needs more than one change */
    assert_string_equal(advice("a name that is far longer than any word of the tool may be"), "");
}

TEST(texts_are_equal_in_any_case) {
    assert_true(nqm_equal_any_case("Normal_DX", "nORMAL_dx", SIZE_MAX));
    assert_true(nqm_equal_any_case("", "", SIZE_MAX));
    assert_true(nqm_equal_any_case("data:image", "DATA:", 5));
    assert_false(nqm_equal_any_case("data", "DATA:", 5));
    assert_false(nqm_equal_any_case("data:", "data", SIZE_MAX));
    assert_false(nqm_equal_any_case("[", "{", SIZE_MAX));               /* 32 apart, as a letter and its capital are */
    assert_false(nqm_equal_any_case("\xc3\xa4", "\xc3\x84", SIZE_MAX)); /* only ASCII letters have a case here */
}
