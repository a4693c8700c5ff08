/* SPDX-License-Identifier: MIT
 *
 * Arguments that are fitted when they are opened: the same as nqm_fit(), within perturbations and mixtures, points on the path of
 * an optimiser, overfitted networks, tables; wrong settings; the bases of an argument.
 */
#include "brdf/brdf.h"
#include "fit/fit.h"
#include "support/check.h"
#include "support/rows.h"

static nqm_brdf *open_fit(const char *argument, const nqm_fit_context *context) {
    nqm_error err = {0};
    nqm_brdf *brdf;
    if (nqm_fit_open(argument, context, &brdf, &err) != NQM_OK)
        fail_msg("%s: %s", argument, err.message);
    return brdf;
}

static void eval(const nqm_brdf *brdf, double rgb[3]) {
    nqm_brdf_eval_half_diff(brdf, 1, (const double[]){0.1, 0.5, 1}, rgb, NULL);
}

static void assert_same(const char *argument, const char *expected) {
    nqm_brdf *a = open_fit(argument, NULL), *b = must_open(expected);
    double x[3], y[3];
    eval(a, x);
    eval(b, y);
    for (size_t c = 0; c < 3; ++c)
        assert_near(x[c], y[c], 0);
    nqm_brdf_free(a);
    nqm_brdf_free(b);
}

#define REF "sgd:nickel"

TEST(a_fit_is_that_of_the_library) {
    nqm_fit_options options = nqm_fit_options_default();
    nqm_fit_report report;
    char text[2200];
    nqm_brdf *ref = must_open(REF);
    options.n_directions = 500;
    options.seed = 7;
    options.loss = NQM_FIT_CUBE_ROOT;
    assert_int_equal(nqm_fit(ref, "ward", &options, &report, NULL, NULL), NQM_OK);
    nqm_brdf_free(ref);
#define FIT "fit:model=ward;samples=500;seed=7;loss=cube-root;of=" REF
    assert_same(FIT, report.spec);
    snprintf(text, sizeof text, "perturb:scale=2;of=%s", report.spec);
    assert_same("perturb:scale=2;of=" FIT, text);
    snprintf(text, sizeof text, "between:t=0.25;with=(%s);of=ggx:alpha=0.2", report.spec);
    assert_same("between:t=0.25;with=(" FIT ");of=ggx:alpha=0.2", text);
    snprintf(text, sizeof text, "between:t=0.25;with=(ggx:alpha=0.2);of=%s", report.spec);
    assert_same("between:t=0.25;with=(ggx:alpha=0.2);of=" FIT, text);
    assert_same("perturb:scale=2;of=" REF, "perturb:scale=2;of=" REF); /* without a fit */
}

TEST(a_path_begins_anywhere_and_ends_at_the_fit) {
    nqm_brdf *ref = must_open(REF);
    nqm_fit_options options = nqm_fit_options_default();
    char spec[2048];
    options.n_directions = 500;
    options.seed = 3;
    assert_int_equal(nqm_fit_path(ref, "ggx", &options, 3, 2, spec, NULL), NQM_OK);
    assert_same("fit:model=ggx;samples=500;seed=3;steps=2;of=" REF, spec);
    nqm_brdf_free(ref);
}

TEST(tables_and_networks) {
    const double own[] = {1, 20, 30, 5, 10, 80, 30, 40, 50};
    const nqm_fit_context context = {.n_own = 3, .own_deg = own};
    double x[3], y[3];
    nqm_brdf *source = must_open("ggx:kd=0.3,0.1,0;ks=1;alpha=0.3"), *brdf;
    brdf = open_fit("fit:model=table;of=ggx:kd=0.3,0.1,0;ks=1;alpha=0.3", NULL);
    assert_string_equal(nqm_brdf_get_info(brdf).format, "table");
    eval(source, x);
    eval(brdf, y);
    assert_near(y[0], x[0], 0.02 * x[0]);
    nqm_brdf_free(brdf);
    nqm_brdf_free(source);

    nqm_error err = {0};
    assert_int_equal(nqm_fit_open("fit:model=nbrdf;own=2;of=" REF, NULL, &brdf, &err), NQM_ERR_ARG);
    assert_non_null(strstr(err.message, "use 'at'"));
    double rgb[2][3];
    static const char *const two[] = {"fit:model=nbrdf;own=9;of=" REF, "fit:model=nbrdf;at=3;of=" REF};
    for (size_t i = 0; i < 2; ++i) {
        brdf = open_fit(two[i], &context);
        assert_string_equal(nqm_brdf_get_info(brdf).format, "nbrdf");
        eval(brdf, rgb[i]);
        nqm_brdf_free(brdf);
    }
    assert_true(rgb[0][0] != rgb[1][0]);
}

TEST(wrong_settings_are_named) {
    EVERY_ROW(row, "wrong settings of fit:") {
        nqm_error err = {0};
        nqm_brdf *brdf;
        assert_int_not_equal(nqm_fit_open(row[0], NULL, &brdf, &err), NQM_OK);
        if (!strstr(err.message, row[1]))
            fail_msg("%s: %s", row[0], err.message);
        assert_null(brdf);
    }
}

static nqm_status note(void *user, const char *base, nqm_error *err) {
    char *text = user;
    (void)err;
    strcat(strcat(text, base), "|");
    return NQM_OK;
}

TEST(bases_are_visited) {
    EVERY_ROW(row, "bases of specs") {
        char text[200] = "";
        assert_int_equal(nqm_argument_visit_bases(row[0], note, text, NULL), NQM_OK);
        assert_string_equal(text, row[1]);
    }
    char deep[400] = "", text[200] = "";
    for (size_t i = 0; i < 20; ++i)
        strcat(deep, "perturb:mix=1;of=");
    assert_int_equal(nqm_argument_visit_bases(strcat(deep, "a"), note, text, NULL), NQM_ERR_ARG);
}
