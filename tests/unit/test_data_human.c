/* SPDX-License-Identifier: MIT
 *
 * Human answers: scores become a dataset with the samples of the named BRDFs, choices are summed and evaluated as by
 * hand, and invalid files are refused with the row.
 */
#include "data/data.h"
#include "judge/judge.h"
#include "math/math.h"
#include "support/check.h"
#include "support/rows.h"
#include "support/scratch.h"

enum { N_DIRECTIONS = 40, N_RESAMPLES = 200 };

static nqm_directions *directions;

static int set_up(void **state) {
    (void)state;
    nqm_directions_options o = nqm_directions_options_default();
    o.n = N_DIRECTIONS;
    return nqm_directions_create(&o, 0, NULL, &directions, NULL) == NQM_OK ? 0 : -1;
}

static int tear_down(void **state) {
    (void)state;
    nqm_directions_free(directions);
    return 0;
}

static nqm_status load(const char *text, nqm_human **human, nqm_error *err) {
    const nqm_human_options o = {.directions = directions};
    return nqm_human_load(scratch_text("answers.csv", text), &o, human, err);
}

static nqm_human *must_load(const char *text) {
    nqm_human *human;
    nqm_error err = {0};
    if (load(text, &human, &err) != NQM_OK)
        fail_msg("%s", err.message);
    return human;
}

static nqm_evaluation *evaluate(const nqm_human *human) {
    const nqm_eval_options o = nqm_eval_options_default();
    nqm_evaluation *ev;
    assert_int_equal(nqm_evaluation_create(human->dataset, 0, NULL, NULL, &o, &ev, NULL), NQM_OK);
    return ev;
}

/* ---- scores ------------------------------------------------------------------------------------------------------ */

static void sample(const char *name, float *rgb) {
    nqm_brdf *brdf = must_open(name);
    assert_int_equal(nqm_sample(brdf, directions, NQM_INVALID_ERROR, rgb, NULL, NULL, NULL), NQM_OK);
    nqm_brdf_free(brdf);
}

/* The rows are not sorted by reference and test; one pair has two scores. */
static const char *const scores = "test,ignored,reference,material,kind,score\n"
                                  "lambert:kd=.3,x,lambert:kd=.2,grey,brighter,3\n"
                                  "lambert:kd=.1,x,lambert:kd=.4,grey,darker,1\n"
                                  "sgd:nickel,,sgd:nickel,metal,same,5\n"
                                  "lambert:kd=.3,x,lambert:kd=.2,grey,brighter,2\n"
                                  "ward:nickel,,sgd:nickel,metal,fit,4.5\n"
                                  "lambert:kd=.39,x,lambert:kd=.4,grey,darker,4\n";

TEST(scores_become_a_dataset) {
    nqm_human *human = must_load(scores);
    nqm_human_info info = nqm_human_get_info(human);
    assert_true(info.kind == NQM_HUMAN_SCORE && info.n_rows == 6 && info.n_refs == 3 && info.n_groups == 2);
    assert_true(info.n_triplets == 0 && isnan(info.ceiling_other_people));
    const nqm_dataset *d = human->dataset;
    assert_int_equal(nqm_dataset_get_info(d).n_pairs_in[NQM_SPLIT_TEST], 6);
    assert_int_equal(nqm_dataset_get_info(d).n_kinds, 4);
    nqm_evaluation *ev = evaluate(human);
    double sum = 0;
    for (size_t pair = 0; pair < 6; ++pair) {
        nqm_dataset_pair p = nqm_dataset_get_pair(d, pair);
        float ref[3 * N_DIRECTIONS], test[3 * N_DIRECTIONS];
        double metrics[NQM_METRIC_COUNT];
        sample(p.ref, ref);
        sample(p.test, test);
        assert_int_equal(nqm_metrics_compute(directions, ref, test, NULL, metrics, NULL), NQM_OK);
        for (size_t m = 0; m < NQM_METRIC_COUNT; ++m)
            assert_near(nqm_evaluation_values(ev, m)[pair], metrics[m], 0);
        assert_string_equal(p.group, strcmp(p.ref, "sgd:nickel") == 0 ? "metal" : "grey");
        if (strcmp(p.test, "ward:nickel") == 0)
            assert_true(p.jod == 4.5 && strcmp(p.kind, "fit") == 0);
        if (strcmp(p.test, "lambert:kd=.1") == 0)
            assert_true(p.jod == 1 && strcmp(p.kind, "darker") == 0);
        sum += p.jod;
    }
    assert_near(sum, 19.5, 1e-12);
    nqm_evaluation_free(ev);
    nqm_human_free(human);
}

/* The four greys differ from .2 by .01, .05, .1, .2, so that MAE orders them. */
#define GREYS(column, a, b, c, d)                                                                                      \
    "reference,test," column "\nlambert:kd=.2,lambert:kd=.21," a "\nlambert:kd=.2,lambert:kd=.25," b                   \
    "\nlambert:kd=.2,lambert:kd=.3," c "\nlambert:kd=.2,lambert:kd=.4," d "\n"

static nqm_agreement judge_mae(const char *text, const nqm_eval_options *options) {
    nqm_agreement results[NQM_METRIC_COUNT];
    nqm_human *human = must_load(text);
    nqm_evaluation *ev = evaluate(human);
    assert_int_equal(nqm_evaluation_judge(ev, options, results, NULL), NQM_OK);
    nqm_evaluation_free(ev);
    nqm_human_free(human);
    return results[NQM_METRIC_MAE];
}

TEST(scores_have_a_ceiling) {
    const struct {
        const char *text;
        double ceiling;
    } of[] = {{GREYS("score", "1", "2", "3", "4"), NAN},
              /* variance 5/3; noise (.01 + .04 + .09 + 1/4) / 4 */
              {GREYS("sd,n,score", "0.2,4,1", "0.4,4,2", "0.6,4,3", "1,4,4"), sqrt(1 - 0.39 / 4 / (5. / 3))},
              /* the rows of .21 repeat: 1 and 3, so that the noise is 2; variance 7/3 */
              {GREYS("score", "1", "4", "4", "3") "lambert:kd=.2,lambert:kd=.21,3\n", sqrt(1 - 2 / 1.5)}};
    for (size_t i = 0; i < sizeof of / sizeof *of; ++i) {
        nqm_human *human = must_load(of[i].text);
        const double ceiling = nqm_human_get_info(human).ceiling;
        if (isnan(of[i].ceiling) && i == 0)
            assert_true(isnan(ceiling));
        else
            assert_near(ceiling, isnan(of[i].ceiling) ? 0 : of[i].ceiling, 1e-12);
        nqm_human_free(human);
    }
}

TEST(scores_of_every_kind_are_judged) {
    nqm_eval_options o = nqm_eval_options_default();
    o.order_margin = 0;
    nqm_agreement a = judge_mae(GREYS("score", "90", "70", "60", "-3"), &o);
    assert_near(a.spearman.value, 1, 1e-12);
    assert_near(a.spearman_mean_by_material.value, 1, 1e-12);
    assert_true(a.n == 4 && a.n_materials == 1 && a.n_ordered == 6 && a.order.value == 1 && isnan(a.spearman.ci95[0]));
    a = judge_mae(GREYS("distance", "1", "2", "4", "3"), &o); /* a distance: higher is worse */
    assert_near(a.spearman.value, 0.8, 1e-12);
    assert_near(a.order.value, 5.0 / 6, 1e-12);
    a = judge_mae(GREYS("JOD", "9.9", "9", "8", "10.2"), &o);
    assert_near(a.spearman.value, -0.2, 1e-12);
    o.jod_from = 9.5;
    a = judge_mae(GREYS("jod", "9.9", "9", "8", "10.2"), &o);
    assert_int_equal(a.n, 2);
    a = judge_mae(GREYS("score", "9.9", "9", "8", "10.2"), &o); /* scores without JOD are not selected by range */
    assert_int_equal(a.n, 4);
}

/* ---- choices ----------------------------------------------------------------------------------------------------- */

/* Distance from .2 increases from .21 to .3 to .4. Rows 1, 2 and 5 are the same triplet. */
static const char *const choices = "reference,test_a,test_b,n_a,n_b\n"
                                   "lambert:kd=.2,lambert:kd=.21,lambert:kd=.3,7,1\n"
                                   "lambert:kd=.2,lambert:kd=.3,lambert:kd=.21,2,6\n"
                                   "lambert:kd=.2,lambert:kd=.4,lambert:kd=.3,3,1\n"
                                   "lambert:kd=.5,lambert:kd=.6,lambert:kd=.8,2,2\n"
                                   "lambert:kd=.2,lambert:kd=.21,lambert:kd=.3,0,0\n"
                                   "lambert:kd=.7,lambert:kd=.8,lambert:kd=.6,1,0\n"
                                   "lambert:kd=.9,lambert:kd=.91,lambert:kd=.95,3,1\n";

TEST(choices_are_added_up) {
    nqm_human *human = must_load(choices);
    nqm_human_info info = nqm_human_get_info(human);
    assert_true(info.kind == NQM_HUMAN_CHOICE && info.n_rows == 7 && info.n_triplets == 5 && info.n_refs == 4);
    assert_near(info.n_choices, 16 + 4 + 4 + 1 + 4, 0);
    assert_near(info.ceiling, (13 + 3 + 2 + 1 + 3) / 29.0, 1e-12);
    /* Agreement with the majority of the other people. 13 to 3: 13 agree. 3 to 1: three agree. 2 to 2: nobody agrees,
     * because each faces 1 against 2. */
    assert_near(info.ceiling_other_people, (13 + 3 + 3) / 28.0, 1e-12);
    assert_int_equal(nqm_dataset_get_info(human->dataset).n_pairs, 3 + 2 + 2 + 2);
    nqm_human_free(human);
}

/* The same kind of data with one row per person. */
TEST(single_choices_are_counted) {
    nqm_human *human = must_load("reference,test_a,test_b,choice\n"
                                 "lambert:kd=.2,lambert:kd=.21,lambert:kd=.3,a\n"
                                 "lambert:kd=.2,lambert:kd=.3,lambert:kd=.21,B\n"
                                 "lambert:kd=.2,lambert:kd=.3,lambert:kd=.21,a\n"
                                 "lambert:kd=.2,lambert:kd=.3,lambert:kd=.4,a\n");
    nqm_human_info info = nqm_human_get_info(human);
    assert_int_equal(info.n_triplets, 2);
    assert_near(info.ceiling, 0.75, 1e-12);
    assert_near(info.ceiling_other_people, 1.0 / 3,
                1e-12); /* 2 to 1: a tie for each of the two (1/2 each), no agreement for the third */
    nqm_human_free(human);
}

/* Predicted choices over all choices in one resample; references are indexed in the order of their names, .2, .5,
 * .7, .9. */
static double resampled_share(size_t index, const double *met, const double *made) {
    nqm_rng rng = nqm_rng_make(4, index);
    double sum_met = 0, sum_made = 0;
    for (size_t k = 0; k < 4; ++k) {
        size_t g = nqm_rng_below(&rng, 4);
        sum_met += met[g];
        sum_made += made[g];
    }
    return sum_met / sum_made;
}

TEST(choices_are_judged) {
    nqm_human *human = must_load(choices);
    nqm_evaluation *ev = evaluate(human);
    nqm_choice_agreement r[NQM_METRIC_COUNT];
    nqm_eval_options o = nqm_eval_options_default();
    o.n_bootstrap = N_RESAMPLES;
    o.seed = 4;
    assert_int_equal(nqm_human_judge_choices(human, ev, &o, r, NULL), NQM_OK);
    /* By MAE, .21 is closer to .2 than .3, .3 than .4, and .6 is closer to .5 than .8. The distances of .8 and .6
     * from .7 are equal up to rounding. */
    const double *mae = nqm_evaluation_values(ev, NQM_METRIC_MAE); /* pairs are sorted by name: .6 is 5, .8 is 6 */
    double of_last = mae[6] < mae[5] ? 1 : mae[6] > mae[5] ? 0 : 0.5;
    const double met[4] = {13 + 1, 2, of_last, 3}, made[4] = {20, 4, 1, 4};
    assert_string_equal(r[NQM_METRIC_MAE].name, "mae");
    assert_near(r[NQM_METRIC_MAE].agreement.value, (met[0] + met[1] + met[2] + met[3]) / 29, 1e-12);
    assert_near(r[NQM_METRIC_MAE].majority, (1 + 0 + of_last + 1) / 4, 1e-12); /* 2 to 2 has no majority */
    double share[N_RESAMPLES];
    for (size_t i = 0; i < N_RESAMPLES; ++i)
        share[i] = resampled_share(i, met, made);
    assert_near(r[NQM_METRIC_MAE].agreement.ci95[0], nqm_quantile(N_RESAMPLES, share, 0.025), 1e-12);
    assert_near(r[NQM_METRIC_MAE].agreement.ci95[1], nqm_quantile(N_RESAMPLES, share, 0.975), 1e-12);
    int n_best = 0;
    for (size_t m = 0; m < NQM_METRIC_COUNT; ++m)
        n_best += r[m].best_of_family;
    assert_int_equal(n_best, 4);
    nqm_difference d;
    assert_int_equal(nqm_human_contrast_choices(human, ev, &o, NQM_METRIC_MAE, NQM_METRIC_MAE, &d, NULL), NQM_OK);
    assert_true(d.value == 0 && d.ci95[0] == 0 && d.ci95[1] == 0 && d.share_below_0 == 0);
    assert_int_equal(nqm_human_contrast_choices(human, ev, &o, 0, NQM_METRIC_COUNT, &d, NULL), NQM_ERR_ARG);
    nqm_human *scored = must_load(scores);
    assert_int_equal(nqm_human_judge_choices(scored, ev, &o, r, NULL), NQM_ERR_ARG);
    nqm_human_free(scored);
    nqm_evaluation_free(ev);
    nqm_human_free(human);
}

/* ---- errors ------------------------------------------------------------------------------------------------------ */

TEST(faults_name_file_and_row) {
    EVERY_ROW(row, "faulty answers") {
        nqm_human *human = (nqm_human *)&human;
        nqm_error err = {0};
        nqm_status status = load(row[0], &human, &err);
        if (status != status_of(row[1]) || human || !strstr(err.message, row[2]) || !strstr(err.message, "answers.csv"))
            fail_msg("%s: status %d, '%s'", row[0], status, err.message);
    }
    nqm_human *human;
    const nqm_human_options o = {.root = NULL};
    assert_int_equal(nqm_human_load(scratch_path("nowhere.csv"), &o, &human, NULL), NQM_ERR_IO);
}

static int stop(void *user, const char *stage, double done, double total) {
    (void)user, (void)stage, (void)done, (void)total;
    return 1;
}

TEST(stops_when_asked) {
    const nqm_human_options o = {.directions = directions, .progress = stop};
    nqm_human *human;
    assert_int_equal(nqm_human_load(scratch_text("s.csv", scores), &o, &human, NULL), NQM_ERR_CANCELLED);
    assert_null(human);
}

TEST_FILE(set_up, tear_down)
