/* SPDX-License-Identifier: MIT
 *
 * Losses of fits: words and values are those of the scalar metrics, gradients agree with central differences, every loss
 * recovers known parameters from random values, losses of the caller, given starts, faulty terms.
 */
#include "fit/fit.h"
#include "metric/metric.h"
#include "support/allocations.h"
#include "support/check.h"
#include "support/fitting.h"

enum { N = 200 };
static const char truth_ggx[] = "ggx:kd=0.3,0.02,0.1;ks=0.05,0.2,0.4;alpha=0.1;f0=0.3";
static const char truth_ward[] = "ward:kd=0.3,0.02,0.1;ks=0.05,0.2,0.4;alpha=0.1";

/* ---- a loss of the caller: the mean squared difference of cbrt(f + 0.01) ------------------------------------------- */

typedef struct roots {
    double wi[3 * N], wo[3 * N], goal[3 * N];
    size_t n_calls;
    nqm_fit_visual visual;
} roots;

static double roots_eval(void *user, const double *rgb, double *gradient) {
    roots *r = user;
    double sum = 0;
    ++r->n_calls;
    for (size_t i = 0; i < 3 * N; ++i) {
        double root = cbrt(rgb[i] + 0.01), difference = root - r->goal[i];
        sum += difference * difference;
        gradient[i] = 2 * difference / (3 * root * root) / (3 * N);
    }
    return sum / (3 * N);
}

static void make_roots(const char *truth, roots *r) {
    nqm_rng rng = nqm_rng_make(7, 0);
    nqm_brdf *ref = must_open(truth);
    *r = (roots){.visual = {.n = N, .eval = roots_eval, .user = r}};
    for (size_t i = 0; i < N; ++i) {
        double hd[3];
        nqm_encode_draw_dense(&rng, 1.2, 1.2, 6, hd);
        nqm_half_diff_to_directions(hd, r->wi + 3 * i, r->wo + 3 * i);
    }
    r->visual.wi = r->wi;
    r->visual.wo = r->wo;
    nqm_brdf_eval(ref, N, r->wi, r->wo, r->goal, NULL);
    for (size_t i = 0; i < 3 * N; ++i)
        r->goal[i] = cbrt(r->goal[i] + 0.01);
    nqm_brdf_free(ref);
}

/* ---- the table ---------------------------------------------------------------------------------------------------- */

TEST(words_are_those_of_the_metrics) {
    for (int m = 0; m < NQM_METRIC_COUNT; ++m)
        assert_string_equal(nqm_fit_loss_words[NQM_FIT_RMSE + m], nqm_metric_get_info((nqm_metric)m).name);
    assert_null(nqm_fit_loss_words[NQM_FIT_N_LOSSES]);
}

/* The values of all losses at directions of the half-vector list are those of nqm_metrics_compute(). */
TEST(values_are_those_of_the_metrics) {
    nqm_directions *directions;
    float rgb[2][3 * 500];
    double metrics[NQM_METRIC_COUNT], test_rgb[3 * 500];
    nqm_brdf *ref = must_open("sgd:nickel"), *test = must_open(truth_ward);
    assert_int_equal(nqm_directions_create(NULL, 0, NULL, &directions, NULL), NQM_OK);
    assert_int_equal(nqm_sample(ref, directions, NQM_INVALID_DROP, rgb[0], NULL, NULL, NULL), NQM_OK);
    assert_int_equal(nqm_sample(test, directions, NQM_INVALID_DROP, rgb[1], NULL, NULL, NULL), NQM_OK);
    assert_int_equal(nqm_metrics_compute(directions, rgb[0], rgb[1], NULL, metrics, NULL), NQM_OK);
    double wi[3 * 500], wo[3 * 500], ref_rgb[3 * 500];
    for (size_t i = 0; i < 500; ++i) {
        double hd[3];
        for (size_t k = 0; k < 3; ++k)
            hd[k] = nqm_directions_get_info(directions).degrees[3 * i + k] * acos(-1) / 180;
        nqm_half_diff_to_directions(hd, wi + 3 * i, wo + 3 * i);
    }
    nqm_brdf_eval(ref, 500, wi, wo, ref_rgb, NULL);
    nqm_brdf_eval(test, 500, wi, wo, test_rgb, NULL);
    const nqm_fit_target from = {.n = 500, .wi = wi, .wo = wo, .rgb = ref_rgb};
    for (int m = 0; m < NQM_METRIC_COUNT; ++m) {
        nqm_fit_target target;
        assert_int_equal(nqm_fit_target_under(&from, (nqm_fit_loss)(NQM_FIT_RMSE + m), &target, NULL), NQM_OK);
        assert_relative(nqm_fit_loss_value(&target, test_rgb, NULL), metrics[m], 1e-5);
        nqm_free(target.weight);
    }
    nqm_brdf_free(ref);
    nqm_brdf_free(test);
    nqm_directions_free(directions);
}

/* ---- gradients ---------------------------------------------------------------------------------------------------- */

static double value_at(nqm_fit_objective *objective, const nqm_values *values) {
    double value;
    assert_int_equal(nqm_fit_objective_value(objective, values, &value, NULL), NQM_OK);
    return value;
}

/* The gradient of a sum by the coordinates at the values of `at`. */
static void check_gradient(const nqm_fit_term *terms, size_t n_terms, const char *at, double tolerance) {
    const double h = 1e-5;
    char name[40];
    nqm_fit_options options = nqm_fit_options_default();
    options.n_directions = 400;
    const nqm_fit_entry *entry;
    nqm_fit_space space;
    nqm_fit_target target;
    nqm_fit_objective *objective;
    nqm_values values;
    double gradient[NQM_FIT_MAX_FREE], x[NQM_FIT_MAX_FREE], lowest[NQM_FIT_MAX_FREE], highest[NQM_FIT_MAX_FREE];
    nqm_brdf *ref = must_open("sgd:blue-rubber");
    snprintf(name, sizeof name, "%.*s", (int)strcspn(at, ":"), at);
    assert_int_equal(nqm_fit_entry_find(name, &entry, NULL), NQM_OK);
    assert_int_equal(nqm_fit_space_make(entry, &options, &space, NULL), NQM_OK);
    assert_int_equal(nqm_fit_target_make(ref, &options, &target, NULL), NQM_OK);
    assert_int_equal(nqm_fit_objective_make(&space, &target, n_terms, terms, &objective, NULL), NQM_OK);
    assert_int_equal(nqm_fit_read_spec(&space, at, &values, NULL), NQM_OK);
    const double value = value_at(objective, &values);
    assert_int_equal(nqm_fit_objective_gradient(objective, &space, &values, gradient, NULL), NQM_OK);
    nqm_fit_coordinates(&space, &values, x);
    nqm_fit_bounds(&space, lowest, highest);
    for (size_t k = 0; k < space.n; ++k) {
        if (x[k] - h < lowest[k] || x[k] + h > highest[k])
            continue; /* a default at the end of its range */
        nqm_values high = values, low = values;
        const double from = x[k];
        x[k] = from + h;
        nqm_fit_values(&space, x, &high);
        x[k] = from - h;
        nqm_fit_values(&space, x, &low);
        x[k] = from;
        const double difference = (value_at(objective, &high) - value_at(objective, &low)) / (2 * h);
        if (!(fabs(gradient[k] - difference) <= tolerance * fabs(difference) + 0.1 * tolerance * value))
            fail_msg("%s, loss %d, parameter %zu: %.9g instead of %.9g", at, (int)terms->loss, k, gradient[k],
                     difference);
    }
    nqm_fit_objective_free(objective);
    nqm_free(target.wi);
    nqm_brdf_free(ref);
}

TEST(gradients_are_those_of_differences) {
    static const char albedos[] = "kd=0.02,0.05,0.2;ks=0.3,0.2,0.1";
    roots r;
    make_roots("sgd:blue-rubber", &r);
    for (int loss = 0; loss < NQM_FIT_N_LOSSES; ++loss) {
        const nqm_fit_term terms[] = {{.weight = 1.5, .loss = (nqm_fit_loss)loss}, {.weight = 2, .visual = &r.visual}};
        static const char *const shapes[] = {"ggx:alpha=0.15;f0=0.2", "ward:alpha=0.15", "smooth:B=900;C=1.1;eta=1.6",
                                             "lafortune:cz=0.97;n=20"};
        for (size_t i = 0; i < sizeof shapes / sizeof *shapes; ++i) {
            char at[120];
            snprintf(at, sizeof at, "%s;%s", shapes[i], albedos);
            check_gradient(terms, 2, at, 1e-6);
        }
        check_gradient(terms, 1, "ggx:kd=0.02,0.05,0.2;ks=0.3,0.2,0.1;alpha=0.15;f0=0.2", 1e-6);
        check_gradient(terms, 2, /* forward differences of f_r */
                       "gltf:base_color=0.4,0.3,0.3;metallic=0.6;roughness=0.5;clearcoat=0.4;clearcoat_roughness=0.3;"
                       "sheen_color=0.2,0.15,0.1;sheen_roughness=0.5",
                       1e-4);
    }
}

/* ---- fits --------------------------------------------------------------------------------------------------------- */

static void check_recovery(const nqm_fit_report *r, const char *truth, const char *model) {
    check_spec_values(r->spec, truth, "alpha", 5e-3);
    check_spec_values(r->spec, truth, "kd", 1e-2);
    if (strcmp(model, "ward") == 0)
        check_spec_values(r->spec, truth, "ks", 1e-2);
    assert_true(r->loss < 1e-3);
}

TEST(every_loss_finds_the_truth_from_random_values) {
    for (int loss = 0; loss < NQM_FIT_N_LOSSES; ++loss) {
        nqm_fit_options options = nqm_fit_options_default();
        options.loss = (nqm_fit_loss)loss;
        options.n_directions = 500;
        const nqm_fit_report ward = fit_from_random(truth_ward, "ward", &options, 3);
        const nqm_fit_report ggx = fit_from_random(truth_ggx, "ggx", &options, 3);
        check_recovery(&ward, truth_ward, "ward");
        check_recovery(&ggx, truth_ggx, "ggx");
    }
}

TEST(mean_absolute_losses_beat_the_fit_by_squares) {
    static const nqm_fit_loss absolute[] = {NQM_FIT_MAE, NQM_FIT_MA_CRWE, NQM_FIT_MA_LOGE, NQM_FIT_MA_LOGWE};
    nqm_fit_options options = nqm_fit_options_default();
    nqm_brdf *ref = must_open("sgd:nickel");
    nqm_fit_target target;
    for (int k = 0; k < 4; ++k) {
        options.loss = (nqm_fit_loss)(absolute[k] - 1); /* root mean square of the same */
        nqm_fit_report start = fit_spec("sgd:nickel", "ward", &options);
        options.loss = absolute[k];
        nqm_fit_report r = fit_spec("sgd:nickel", "ward", &options);
        assert_int_equal(nqm_fit_target_make(ref, &options, &target, NULL), NQM_OK);
        assert_true(r.loss < 0.999 * loss_of_spec(&target, start.spec));
        nqm_free(target.wi);
    }
    nqm_brdf_free(ref);
}

TEST(a_loss_of_the_caller_alone_and_in_a_sum) {
    roots r;
    make_roots(truth_ggx, &r);
    const nqm_fit_term sum[] = {{.weight = 1, .loss = NQM_FIT_LOG_DIFF}, {.weight = 0.5, .visual = &r.visual}};
    nqm_fit_options options = nqm_fit_options_default();
    options.n_directions = 1500;
    options.terms = sum;
    for (int k = 0; k < 3; ++k) {
        options.terms = k ? sum + 1 : sum;
        options.n_terms = k ? 1 : 2;
        const nqm_fit_report found =
            k == 2 ? fit_from_random(truth_ggx, "ggx", &options, 8) : fit_spec(truth_ggx, "ggx", &options);
        check_recovery(&found, truth_ggx, "ggx");
    }
    assert_true(r.n_calls > 20);
}

TEST(a_given_start_is_polished) {
    roots r;
    make_roots(truth_ggx, &r);
    const nqm_fit_term term = {.weight = 1, .visual = &r.visual};
    nqm_fit_options options = nqm_fit_options_default();
    options.start = "ggx:kd=0.2;ks=0.2;alpha=0.15;f0=0.2";
    for (size_t n_terms = 0; n_terms < 2; ++n_terms) {
        options.terms = &term;
        options.n_terms = n_terms;
        const nqm_fit_report found = fit_spec(truth_ggx, "ggx", &options);
        check_recovery(&found, truth_ggx, "ggx");
    }
    nqm_fit_report report;
    nqm_error err = {0};
    nqm_brdf *ref = must_open(truth_ggx);
    static const char *const faulty[] = {"ward:kd=0.2;ks=0.2;alpha=0.1", "ggx:alpha=wide", "ggx:", "ggx"};
    for (int k = 0; k < 4; ++k) {
        options.start = faulty[k];
        assert_int_equal(nqm_fit(ref, "ggx", &options, &report, NULL, &err), NQM_ERR_ARG);
    }
    nqm_brdf_free(ref);
}

/* ---- failures ----------------------------------------------------------------------------------------------------- */

static double no_number(void *user, const double *rgb, double *gradient) {
    (void)user;
    (void)rgb;
    (void)gradient;
    return NAN;
}

TEST(faulty_terms_are_refused) {
    roots r;
    make_roots(truth_ward, &r);
    nqm_fit_visual empty = r.visual, broken = r.visual;
    empty.n = 0;
    broken.eval = no_number;
    const nqm_fit_term terms[] = {{.weight = 0},
                                  {.weight = INFINITY},
                                  {.weight = 1, .loss = NQM_FIT_N_LOSSES},
                                  {.weight = 1, .visual = &empty},
                                  {.weight = 1, .visual = &broken}};
    nqm_brdf *ref = must_open(truth_ward);
    nqm_fit_report report;
    for (int k = 0; k < 5; ++k) {
        nqm_fit_options options = nqm_fit_options_default();
        options.n_directions = 200;
        options.terms = &terms[k];
        options.n_terms = 1;
        assert_int_equal(nqm_fit(ref, "ward", &options, &report, NULL, NULL), k < 4 ? NQM_ERR_ARG : NQM_ERR_NUMERIC);
    }
    nqm_brdf_free(ref);
}

/* Fails allocation 0, 1, 2, 3, 5, 7, 10, ... of thousands. */
TEST(memory_runs_out) {
    roots r;
    make_roots(truth_ward, &r);
    const nqm_fit_term sum[] = {{.weight = 1, .loss = NQM_FIT_LOG_DIFF}, {.weight = 1, .visual = &r.visual}};
    nqm_fit_options options = nqm_fit_options_default();
    options.n_directions = 200;
    options.start = "ward:kd=0.1;ks=0.1;alpha=0.3";
    options.terms = sum;
    options.n_terms = 2;
    nqm_brdf *brdf = must_open("sgd:nickel");
    nqm_status status = NQM_OK;
    long n = -1;
    EVERY_ALLOCATION(n, status, 3) {
        nqm_fit_report report;
        nqm_error err = {0};
        status = nqm_fit(brdf, "ward", &options, &report, NULL, &err);
        assert_int_equal(err.status, status);
    }
    nqm_brdf_free(brdf);
}

static int stop_in_polish(void *user, const char *stage, double done, double total) {
    (void)done;
    (void)total;
    *(bool *)user = strcmp(stage, "polish") == 0;
    return *(bool *)user;
}

static double slow(void *user, const double *rgb, double *gradient) {
    const double begin = nqm_clock_s();
    while (nqm_clock_s() < begin + 0.03)
        ;
    return roots_eval(user, rgb, gradient);
}

TEST(a_polish_can_be_stopped) {
    roots r;
    bool stopped = false;
    make_roots("sgd:nickel", &r);
    r.visual.eval = slow;
    const nqm_fit_term term = {.weight = 1, .visual = &r.visual};
    nqm_fit_options options = nqm_fit_options_default();
    nqm_fit_report report;
    options.terms = &term;
    options.n_terms = 1;
    options.progress = stop_in_polish;
    options.progress_user = &stopped;
    nqm_brdf *ref = must_open("sgd:nickel");
    assert_int_equal(nqm_fit(ref, "ggx", &options, &report, NULL, NULL), NQM_ERR_CANCELLED);
    assert_true(stopped);
    nqm_brdf_free(ref);
}
