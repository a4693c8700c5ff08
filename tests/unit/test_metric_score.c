/* SPDX-License-Identifier: MIT
 *
 * From BRDFs to JOD with small models of known weights: all steps against a plain computation in double, both layouts,
 * policies for directions without a value, identical pairs, batches, errors of single tests, lack of memory.
 */
#include "brdf/brdf.h"
#include "math/math.h"
#include "metric/metric.h"
#include "percept/percept.h"
#include "support/allocations.h"
#include "support/check.h"
#include "support/predict.h"

#include <nqm/train.h>
#include <omp.h>

enum { N = 12, HIDDEN = 7 };

static nqm_directions *directions;

static struct nqm_model *make_model(nqm_layout layout, nqm_target target) {
    struct nqm_model *model = nqm_alloc(1, sizeof *model);
    const nqm_net_shape shape = {2, {nqm_features_width((int)layout, N), HIDDEN, 1}};
    assert_int_equal(nqm_params_create(&shape, &model->params, NULL), NQM_OK);
    nqm_params_init(&model->params, 4);
    model->params.layer[1].b[0] = 0.2f;
    assert_int_equal(
        nqm_directions_from_degrees(N, nqm_directions_get_info(directions).degrees, &model->directions, NULL), NQM_OK);
    for (size_t k = 0; k < 3; ++k) {
        model->features.mean[k] = 0.3f + 0.1f * (float)k;
        model->features.std[k] = 0.5f - 0.1f * (float)k;
    }
    model->features.layout = (int)layout;
    model->features.difference_scale = 3;
    model->target = (int)target;
    model->output.mean = target == NQM_TARGET_JOD ? 7 : 2;
    model->output.std = 1.5;
    model->output.lo = -3, model->output.hi = 1.8;
    model->curve = nqm_curve_published;
    return model;
}

/* The paper's formulas in double. */
static double expected_jod(const struct nqm_model *model, const float *ref, const float *test, const uint8_t *used) {
    double x[9 * N];
    size_t n = 3 * N;
    for (size_t i = 0; i < n; ++i) {
        double mean = (double)model->features.mean[i % 3], std = (double)model->features.std[i % 3];
        bool counts = !used || used[i / 3];
        double r = counts ? (log(cbrt((double)ref[i]) + 1) - mean) / std : 0;
        double t = counts ? (log(cbrt((double)test[i]) + 1) - mean) / std : 0;
        x[i] = r;
        x[n + i] = model->features.layout == NQM_LAYOUT_REF_TEST ? t : 3 * (t - r);
        if (model->features.layout == NQM_LAYOUT_REF_DIFF_ABSDIFF)
            x[2 * n + i] = 3 * fabs(t - r);
    }
    const nqm_layer *first = &model->params.layer[0], *last = &model->params.layer[1];
    size_t width = model->params.shape.sizes[0];
    double h[HIDDEN], mean = 0, variance = 0, z = (double)last->b[0];
    for (size_t j = 0; j < HIDDEN; ++j) {
        h[j] = (double)first->b[j];
        for (size_t i = 0; i < width; ++i)
            h[j] += (double)first->w[j * width + i] * x[i];
        mean += h[j] / HIDDEN;
    }
    for (size_t j = 0; j < HIDDEN; ++j)
        variance += (h[j] - mean) * (h[j] - mean) / HIDDEN;
    for (size_t j = 0; j < HIDDEN; ++j) {
        double v = (h[j] - mean) / sqrt(variance + 1e-5);
        z += (double)last->w[j] * v * 0.5 * erfc(-v / sqrt(2));
    }
    double target = model->output.mean +
                    model->output.std * (model->output.lo + (model->output.hi - model->output.lo) / (1 + exp(-z)));
    return model->target == NQM_TARGET_JOD ? target : nqm_curve_jod(&model->curve, exp(target));
}

/* ---- BRDFs with values and holes chosen by the tests ------------------------------------------------------------- */

typedef struct fake {
    double level;
    double hole_below_deg; /* no value for theta_h below this, in degrees */
    double dip_above_deg;  /* channel 0 is negative for theta_h above this, in degrees */
} fake;

static void eval_fake(const void *self, size_t n, const double *hd, double *rgb) {
    const fake *f = self;
    for (size_t i = 0; i < n; ++i) {
        double theta_h = hd[3 * i] * (180 / NQM_PI);
        rgb[3 * i] = theta_h < f->hole_below_deg ? NAN : theta_h > f->dip_above_deg ? -1 : f->level;
        rgb[3 * i + 1] = f->level * (1 + hd[3 * i + 1]);
        rgb[3 * i + 2] = f->level * exp(-theta_h);
    }
}

static const nqm_brdf_class fake_class = {.format = "fake", .eval_half_diff = eval_fake, .free = free_nothing};

static nqm_brdf *wrap(fake *f) {
    nqm_brdf *brdf;
    assert_int_equal(nqm_brdf_wrap(&fake_class, f, &(nqm_brdf_info){.name = "fake"}, &brdf, NULL), NQM_OK);
    return brdf;
}

static fake plain = {0.3, 0, 90}, brighter = {0.5, 0, 90}, holed = {0.5, 4, 90}, dipped = {0.3, 0, 20},
            empty = {1, 91, 90}, dazzling = {1e9, 0, 90};
static nqm_brdf *b_plain, *b_brighter, *b_holed, *b_dipped, *b_empty, *b_dazzling;

static int setup(void **state) {
    (void)state;
    double degrees[N][3];
    for (size_t i = 0; i < N; ++i) {
        degrees[i][0] = 0.3 * (double)(i * i); /* 0 to 36.3 degrees; four are below 4, three above 20 */
        degrees[i][1] = 4 * (double)i;
        degrees[i][2] = 13 * (double)i;
    }
    assert_int_equal(nqm_directions_from_degrees(N, &degrees[0][0], &directions, NULL), NQM_OK);
    b_plain = wrap(&plain), b_brighter = wrap(&brighter), b_holed = wrap(&holed);
    b_dipped = wrap(&dipped), b_empty = wrap(&empty), b_dazzling = wrap(&dazzling);
    return 0;
}

static int teardown(void **state) {
    (void)state;
    nqm_brdf *all[] = {b_plain, b_brighter, b_holed, b_dipped, b_empty, b_dazzling};
    for (size_t i = 0; i < sizeof all / sizeof *all; ++i)
        nqm_brdf_free(all[i]);
    nqm_directions_free(directions);
    return 0;
}

static void sample(const nqm_brdf *brdf, nqm_invalid_policy policy, float *rgb, uint8_t *flag) {
    assert_int_equal(nqm_sample(brdf, directions, policy, rgb, flag, NULL, NULL), NQM_OK);
}

/* Scores have float sums. */
static void check_metrics(const double *metrics, const double *expected) {
    for (size_t m = 0; m < NQM_METRIC_COUNT; ++m)
        assert_relative(metrics[m], expected[m], 1e-6);
}

/* ---- tests ------------------------------------------------------------------------------------------------------- */

TEST(test_chain) {
    for (int layout = NQM_LAYOUT_REF_TEST; layout <= NQM_LAYOUT_REF_DIFF_ABSDIFF; ++layout)
        for (int target = NQM_TARGET_JOD; target <= NQM_TARGET_LOG_DELTA_E; ++target) {
            struct nqm_model *model = make_model((nqm_layout)layout, (nqm_target)target);
            float ref[3 * N], test[3 * N];
            sample(b_plain, NQM_INVALID_DROP, ref, NULL);
            sample(b_brighter, NQM_INVALID_DROP, test, NULL);
            double expected = expected_jod(model, ref, test, NULL), predicted;
            nqm_score_result result;
            const nqm_brdf *tests[] = {b_brighter};
            assert_int_equal(nqm_score(model, b_plain, 1, tests, NULL, &result, NULL), NQM_OK);
            assert_int_equal(result.status, NQM_OK);
            assert_near(result.jod, expected, 2e-5);
            predict_jod(model, 1, ref, test, &predicted);
            assert_near(predicted, expected, 2e-5);
            if (target == NQM_TARGET_JOD)
                assert_true(isnan(result.delta_e));
            else
                assert_near(nqm_curve_jod(&model->curve, result.delta_e), result.jod, 1e-12);
            assert_int_equal(result.identical, 0);
            assert_int_equal(result.n_valid, N);
            double metrics[NQM_METRIC_COUNT];
            assert_int_equal(nqm_metrics_compute(directions, ref, test, NULL, metrics, NULL), NQM_OK);
            check_metrics(result.metrics, metrics);
            nqm_model_free(model);
        }
}

/* Tests that differ more and more: the prediction is cut at its bound, until the bound is above the prediction. */
TEST(test_delta_e_keeps_to_its_bound) {
    struct nqm_model *model = make_model(NQM_LAYOUT_REF_TEST, NQM_TARGET_LOG_DELTA_E);
    float ref[3 * N], test[3 * N];
    size_t n_cut = 0, n_below = 0;
    sample(b_plain, NQM_INVALID_DROP, ref, NULL);
    for (int k = 0; k < 60; ++k) {
        fake different = {0.3 * (1 + 1e-4 * pow(1.15, k)), 0, 90};
        nqm_brdf *brdf = wrap(&different);
        const nqm_brdf *tests[] = {brdf};
        nqm_score_result result;
        sample(brdf, NQM_INVALID_DROP, test, NULL);
        const double bound = nqm_delta_e_bound(N, &(nqm_sample_pair){ref, test, NULL});
        assert_int_equal(nqm_score(model, b_plain, 1, tests, NULL, &result, NULL), NQM_OK);
        assert_true(result.delta_e <= bound);
        n_cut += result.delta_e == bound;
        n_below += result.delta_e < bound;
        nqm_brdf_free(brdf);
    }
    assert_true(n_cut > 5 && n_below > 5);
    nqm_model_free(model);
}

TEST(test_policies) {
    struct nqm_model *model = make_model(NQM_LAYOUT_REF_DIFF_ABSDIFF, NQM_TARGET_JOD);
    const nqm_brdf *tests[] = {b_holed};
    for (int policy = NQM_INVALID_DROP; policy <= NQM_INVALID_NEAREST; ++policy) {
        nqm_score_options options = {.invalid = (nqm_invalid_policy)policy, .min_valid_fraction = 0.5, .metrics = 1};
        nqm_score_result result;
        assert_int_equal(nqm_score(model, b_plain, 1, tests, &options, &result, NULL), NQM_OK);
        assert_int_equal(result.status, NQM_OK);
        assert_int_equal(result.n_valid, N - 4);
        assert_int_equal(result.n_invalid[1], 4);
        assert_int_equal(result.n_invalid[0], 0);
        float ref[3 * N], test[3 * N];
        uint8_t flag[N], used[N];
        sample(b_plain, options.invalid, ref, NULL);
        sample(b_holed, options.invalid, test, flag);
        for (size_t i = 0; i < N; ++i)
            used[i] = policy != NQM_INVALID_DROP || flag[i] == NQM_VALUE_OK;
        assert_near(result.jod, expected_jod(model, ref, test, used), 2e-5);
        double metrics[NQM_METRIC_COUNT];
        assert_int_equal(nqm_metrics_compute(directions, ref, test, used, metrics, NULL), NQM_OK);
        check_metrics(result.metrics, metrics);
    }
    nqm_model_free(model);
}

TEST(test_reference_with_holes) {
    struct nqm_model *model = make_model(NQM_LAYOUT_REF_TEST, NQM_TARGET_JOD);
    const nqm_brdf *tests[] = {b_brighter, b_dipped};
    nqm_score_options options = {.invalid = NQM_INVALID_DROP, .min_valid_fraction = 0.5, .metrics = 1};
    nqm_score_result results[2];
    assert_int_equal(nqm_score(model, b_holed, 2, tests, &options, results, NULL), NQM_OK);
    assert_int_equal(results[0].identical, 1); /* equal at all directions where both have a value */
    assert_near(results[0].metrics[NQM_METRIC_RMSE], 0, 0);
    assert_int_equal(results[0].n_invalid[0], 4);
    assert_int_equal(results[1].identical, 0);
    assert_int_equal(results[1].n_clamped[1], 3);
    assert_int_equal(results[1].n_clamped[0], 0);
    options.invalid = NQM_INVALID_ERROR;
    nqm_error err = {0};
    assert_int_equal(nqm_score(model, b_holed, 2, tests, &options, results, &err), NQM_ERR_INCOMPATIBLE);
    assert_non_null(strstr(err.message, "fake: no value at 4 of 12"));
    assert_int_equal(nqm_score(model, b_empty, 2, tests, NULL, results, &err), NQM_ERR_INCOMPATIBLE);
    options.min_valid_fraction = 1.5;
    assert_int_equal(nqm_score(model, b_plain, 2, tests, &options, results, &err), NQM_ERR_ARG);
    nqm_model_free(model);
}

TEST(test_faults_stay_with_their_test) {
    struct nqm_model *model = make_model(NQM_LAYOUT_REF_TEST, NQM_TARGET_JOD);
    const nqm_brdf *tests[] = {b_brighter, b_empty, b_holed, b_plain, b_dazzling};
    nqm_score_result results[5], alone;
    assert_int_equal(nqm_score(model, b_plain, 5, tests, NULL, results, NULL), NQM_OK);
    assert_int_equal(results[0].status, NQM_OK);
    assert_int_equal(results[1].status, NQM_ERR_INCOMPATIBLE);
    assert_int_equal(results[2].status, NQM_ERR_INCOMPATIBLE); /* 8 of 12 valid, 0.9 needed */
    assert_int_equal(results[2].n_valid, 8);
    for (size_t i = 1; i < 3; ++i) {
        assert_true(isnan(results[i].jod));
        assert_true(isnan(results[i].metrics[NQM_METRIC_LOG_DIFF]));
        assert_int_equal(results[i].identical, 0);
    }
    assert_int_equal(results[3].identical, 1);
    assert_int_equal(results[0].n_unusual[1], 0);
    assert_int_equal(results[4].n_unusual[1], N);
    assert_int_equal(results[4].n_unusual[0], 0);
    assert_int_equal(nqm_score(model, b_plain, 1, tests, NULL, &alone, NULL), NQM_OK);
    assert_true(alone.jod == results[0].jod);
    nqm_model_free(model);
}

TEST(test_batches_and_threads) {
    enum { MANY = 2 * NQM_PREDICT_BATCH + 5 };
    struct nqm_model *model = make_model(NQM_LAYOUT_REF_DIFF_ABSDIFF, NQM_TARGET_LOG_DELTA_E);
    float *ref = nqm_alloc(MANY, 3 * N * sizeof *ref), *test = nqm_alloc(MANY, 3 * N * sizeof *test);
    double jod[MANY], single_thread[MANY];
    nqm_rng rng = nqm_rng_make(6, 0);
    for (size_t i = 0; i < MANY * 3 * N; ++i) {
        ref[i] = (float)nqm_rng_uniform(&rng);
        test[i] = (float)nqm_rng_uniform(&rng);
    }
    predict_jod(model, MANY, ref, test, jod);
    for (size_t i = 0; i < MANY; ++i)
        assert_near(jod[i], expected_jod(model, ref + 3 * N * i, test + 3 * N * i, NULL), 5e-5);
    int threads = omp_get_max_threads();
    omp_set_num_threads(1);
    predict_jod(model, MANY, ref, test, single_thread);
    omp_set_num_threads(threads);
    assert_memory_equal(jod, single_thread, sizeof jod);
    nqm_free(ref);
    nqm_free(test);
    nqm_model_free(model);
}

TEST(test_many_tests) {
    enum { MANY = NQM_PREDICT_BATCH + 3 };
    struct nqm_model *model = make_model(NQM_LAYOUT_REF_TEST, NQM_TARGET_JOD);
    const nqm_brdf *tests[MANY];
    nqm_score_result *results = nqm_alloc(MANY, sizeof *results);
    for (size_t i = 0; i < MANY; ++i)
        tests[i] = i % 3 == 0 ? b_plain : i % 3 == 1 ? b_brighter : b_dipped;
    assert_int_equal(nqm_score(model, b_plain, MANY, tests, NULL, results, NULL), NQM_OK);
    for (size_t i = 3; i < MANY; ++i) {
        assert_true(results[i].jod == results[i % 3].jod);
        assert_int_equal(results[i].identical, i % 3 == 0);
    }
    assert_int_equal(nqm_score(model, b_plain, 0, NULL, NULL, NULL, NULL), NQM_OK);
    nqm_free(results);
    nqm_model_free(model);
}

TEST(test_facts) {
    struct nqm_model *model = make_model(NQM_LAYOUT_REF_TEST, NQM_TARGET_JOD);
    nqm_model_info info = nqm_model_get_info(model);
    assert_int_equal(info.n_parameters, 72 * HIDDEN + 3 * HIDDEN + HIDDEN + 1);
    assert_int_equal(info.n_layers, 2);
    assert_int_equal(info.layer_sizes[0], 72);
    assert_near(info.jod_min, 7 - 1.5 * 3, 1e-12);
    assert_near(info.jod_max, 7 + 1.5 * 1.8, 1e-12);
    assert_string_equal(nqm_directions_id(info.directions), nqm_directions_id(directions));
    nqm_model_free(model);
    model = make_model(NQM_LAYOUT_REF_TEST, NQM_TARGET_LOG_DELTA_E);
    info = nqm_model_get_info(model);
    assert_near(info.jod_min, nqm_curve_jod(&nqm_curve_published, exp(2 + 1.5 * 1.8)), 1e-12);
    assert_near(info.jod_max, nqm_curve_jod(&nqm_curve_published, exp(2 - 1.5 * 3)), 1e-12);
    nqm_model_free(model);
}

TEST(test_out_of_memory) {
    struct nqm_model *model = make_model(NQM_LAYOUT_REF_TEST, NQM_TARGET_JOD);
    const nqm_brdf *tests[] = {b_brighter};
    nqm_status status = NQM_OK;
    long n = -1;
    EVERY_ALLOCATION(n, status, 0) {
        nqm_score_result result = {0};
        status = nqm_score(model, b_plain, 1, tests, NULL, &result, NULL);
        status = status == NQM_OK ? result.status : status;
    }
    assert_true(n < 60);
    nqm_model_free(model);
}

TEST_FILE(setup, teardown)
