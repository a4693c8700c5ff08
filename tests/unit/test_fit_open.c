/* SPDX-License-Identifier: MIT
 *
 * Arguments that are fitted when they are opened: the same as nqm_fit(), within perturbations and mixtures, points on the path of
 * an optimiser, overfitted networks, tables; wrong settings; the bases of an argument.
 */
#include "brdf/brdf.h"
#include "fit/open.h"
#include "support/check.h"

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
    static const char *const bad[][2] = {
        {"fit:model=ggx", "'of='"},
        {"fit:of=" REF, "'of='"},
        {"fit:seed=1;of=" REF, "a model is missing"},
        {"fit:model=gxg;of=" REF, "gxg"},
        {"fit:model=ggx;sed=1;of=" REF, "did you mean 'seed'?"},
        {"fit:model=ggx;ggx;of=" REF, "'ggx' is no setting"},
        {"fit:model=ggx;steps=1.5;of=" REF, "steps needs a whole number"},
        {"fit:model=ggx;steps=1001;of=" REF, "steps needs a whole number"},
        {"fit:model=ggx;at=3;of=" REF, "nbrdf"},
        {"fit:model=nbrdf;at=0;of=" REF, "at needs"},
        {"fit:model=ggx;loss=l2;of=" REF, "l2"},
        {"fit:model=ggx;samples=3;of=" REF, "samples"},
        {"fit:model=nbrdf;steps=3;of=" REF, "not an analytic model"},
        {"fit:model=ggx;of=sgd:nickl", "nickl"},
        {"perturb:scal=2;of=fit:model=ward;samples=200;of=" REF, "scal"},
        {"between:t=2;with=(" REF ");of=fit:model=table;of=" REF, "t"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        nqm_error err = {0};
        nqm_brdf *brdf;
        assert_int_not_equal(nqm_fit_open(bad[i][0], NULL, &brdf, &err), NQM_OK);
        if (!strstr(err.message, bad[i][1]))
            fail_msg("%s: %s", bad[i][0], err.message);
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
    static const char *const cases[][2] = {
        {"ggx:alpha=1", "ggx:alpha=1|"},
        {"perturb:scale=2;of=fit:model=ggx;of=a.bsdf", "a.bsdf|"},
        {"between:t=1;with=(perturb:scale=2;of=a:b);of=fit:model=ggx;of=c.zip:d", "a:b|c.zip:d|"},
        {"between:t=1;of=a", "between:t=1;of=a|"}, /* nqm_brdf_open() says what is wrong */
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        char text[200] = "";
        assert_int_equal(nqm_fit_visit_bases(cases[i][0], note, text, NULL), NQM_OK);
        assert_string_equal(text, cases[i][1]);
    }
    char deep[400] = "", text[200] = "";
    for (size_t i = 0; i < 20; ++i)
        strcat(deep, "perturb:mix=1;of=");
    assert_int_equal(nqm_fit_visit_bases(strcat(deep, "a"), note, text, NULL), NQM_ERR_ARG);
}
