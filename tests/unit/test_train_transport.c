/* SPDX-License-Identifier: MIT
 *
 * Training of models that correct estimates by light transport: targets, the matrix in the model, predictions recomputed from
 * the network's output, training without the matrix, equal bits after resuming, and the refused target.
 */
#include "judge/judge.h"
#include "kernel/kernel.h"
#include "math/math.h"
#include "metric/sums.h"
#include "sample/loops.h"
#include "support/check.h"
#include "support/predict.h"
#include "support/toy_dataset.h"
#include "support/training.h"

#include <omp.h>

enum { N = 16, OUTPUTS = 1 + NQM_LABEL_PARTS };

static const char checkpoint[] = "test_train_transport.checkpoint", model_path[] = "test_train_transport.model";

static nqm_dataset *toy;

static int make_toy(void **state) {
    (void)state;
    toy_options o = toy_options_default();
    o.with_transport = true;
    o.n_groups = 48; /* enough validation materials for a calibration */
    toy = toy_dataset(&o);
    omp_set_num_threads(1); /* these networks are too small to use more threads */
    return 0;
}

static int drop_toy(void **state) {
    (void)state;
    nqm_dataset_free(toy);
    unlink(checkpoint);
    unlink(model_path);
    return 0;
}

static const float *ref_of(size_t pair) {
    return toy->ref_rgb + toy->pair_ref[pair] * 3 * N;
}

static const float *test_of(size_t pair) {
    return toy->test_rgb + pair * 3 * N;
}

static nqm_label estimate_of(size_t pair) {
    const nqm_transport transport = nqm_dataset_transport(toy);
    return transport_estimate(&transport, ref_of(pair), test_of(pair), NULL);
}

/* Normalised targets are the differences of label and estimate; their range is at most 6 standard deviations. */
TEST(targets_are_corrections) {
    const nqm_train_options o = small_recipe("nqm", 24, 6);
    nqm_examples e;
    assert_int_equal(nqm_examples_create(toy, &o, 64, &e, NULL), NQM_OK);
    assert_int_equal(e.n_outputs, OUTPUTS);
    for (size_t i = 0; i < e.rows.n_train + e.rows.n_validation; ++i) {
        const size_t pair = e.rows.row[i].pair;
        const nqm_label estimate = estimate_of(pair);
        double expected[OUTPUTS], base[OUTPUTS];
        expected[0] = log(fmax(toy->delta_e[pair], 0.05));
        nqm_parts_to_targets(toy->parts + pair * NQM_LABEL_PARTS, 0.05, expected + 1);
        nqm_estimate_targets(&estimate, base);
        for (size_t k = 0; k < OUTPUTS; ++k) {
            const double correction = e.output[k].mean + e.output[k].std * (double)e.target[i * OUTPUTS + k];
            assert_near(base[k] + correction, expected[k], 1e-5);
        }
    }
    for (size_t k = 0; k < OUTPUTS; ++k)
        assert_true(e.output[k].lo >= -6 && e.output[k].hi <= 6 && e.output[k].lo < e.output[k].hi);
    nqm_examples_free(&e);
}

/* The network's outputs for a pair, with features composed here. */
static void outputs_of(const nqm_model *model, size_t pair, const nqm_transport *transport, float *z) {
    enum { WIDTH = 9 * N + NQM_SCALAR_COUNT };
    float ref_t[3 * N], test_t[3 * N], x[WIDTH];
    double scalars[NQM_SCALAR_COUNT];
    const nqm_inference_net *net;
    nqm_inference_work *work;
    nqm_features_transform(3 * N, ref_of(pair), ref_t);
    nqm_features_transform(3 * N, test_of(pair), test_t);
    nqm_features_compose(&model->features, N, ref_t, test_t, NULL, x);
    compute_scalars(toy->directions, transport, ref_of(pair), test_of(pair), NULL, scalars);
    nqm_scalars_whiten(&model->scalars, scalars, x + 9 * N);
    assert_int_equal(nqm_model_inference(model, &net, NULL), NQM_OK);
    assert_int_equal(nqm_inference_work_create(net, 1, &work, NULL), NQM_OK);
    nqm_inference_run(work, 1, x, WIDTH, z);
    nqm_inference_work_free(work);
}

/* Predictions are the estimate plus the outputs; a part is checked, too. */
static void check_predictions(const nqm_model *model, bool has_transport) {
    const nqm_transport transport = nqm_model_transport(model);
    nqm_predictor *predictor;
    size_t n_checked = 0;
    assert_int_equal(nqm_predictor_create(model, 1, &predictor, NULL), NQM_OK);
    for (size_t pair = 0; pair < toy->n_pairs; pair += 5) {
        const nqm_sample_pair p = {ref_of(pair), test_of(pair), NULL};
        const nqm_label estimate = estimate_of(pair), *base = has_transport ? &estimate : NULL;
        nqm_prediction got;
        float z[OUTPUTS];
        double expected;
        nqm_predictor_run(predictor, 1, &p, &got, NULL);
        outputs_of(model, pair, &transport, z);
        const double expected_jod = nqm_model_jod(model, (double)z[0], base, &expected);
        const nqm_label expected_label = nqm_model_label(model, z, base);
        if (isfinite(nqm_delta_e_bound(N, &p))) /* nearly equal samples: a bound may decide */
            continue;
        assert_relative(got.delta_e, expected, 1e-6);
        assert_near(got.jod, expected_jod, 1e-6);
        assert_near(got.label.shift[0], expected_label.shift[0], 1e-5 * (1 + fabs(got.label.shift[0])));
        assert_near(got.label.structure, expected_label.structure, 1e-5 * (1 + got.label.structure));
        ++n_checked;
    }
    assert_true(n_checked > 10);
    nqm_predictor_free(predictor);
}

/* The report of the training is about the predictions that users get: features must not differ between the two. */
static void check_report(const nqm_model *model, const nqm_train_report *report) {
    size_t n = 0, *pairs = nqm_alloc(toy->n_pairs, sizeof *pairs);
    nqm_prediction *all = nqm_alloc(toy->n_pairs, sizeof *all);
    double *jod = nqm_alloc(toy->n_pairs, sizeof *jod), *label = nqm_alloc(toy->n_pairs, sizeof *label);
    for (size_t i = 0; i < toy->n_pairs; ++i)
        if (nqm_dataset_pair_split(toy, i) == NQM_SPLIT_VALIDATION)
            pairs[n++] = i;
    const nqm_dataset_prediction p = {.dataset = toy, .model = model, .n = n, .pairs = pairs, .to = all};
    assert_int_equal(nqm_dataset_predict(&p, NULL), NQM_OK);
    for (size_t i = 0; i < n; ++i) {
        jod[i] = all[pairs[i]].jod;
        label[i] = toy->jod[pairs[i]];
    }
    assert_near(nqm_spearman(n, jod, label), report->validation_spearman,
                0.01); /* predictions keep to nqm_delta_e_bound() */
    nqm_free(pairs);
    nqm_free(all);
    nqm_free(jod);
    nqm_free(label);
}

TEST(models_correct_the_estimate) {
    const nqm_train_options o = small_recipe("nqm", 24, 6);
    nqm_train_report report;
    nqm_model *model = train_model(toy, &o, &report), *loaded;
    assert_int_equal(model->n_transport, N);
    assert_memory_equal(model->transport, toy->transport, N * 3 * NQM_TRANSPORT_POINTS * sizeof *model->transport);
    assert_memory_equal(model->transport_points, toy->transport_points,
                        3 * NQM_TRANSPORT_POINTS * sizeof *model->transport_points);
    check_predictions(model, true);
    check_report(model, &report);
    assert_int_equal(nqm_model_save(model, model_path, NULL), NQM_OK);
    assert_int_equal(nqm_model_load(model_path, &loaded, NULL), NQM_OK);
    check_predictions(loaded, true);
    nqm_model_free(loaded);
    nqm_model_free(model);
}

/* Without the option the model knows nothing of the matrix, and neither do its features. */
TEST(without_transport) {
    nqm_train_options o = small_recipe("nqm", 24, 6);
    nqm_train_report report;
    o.input.transport = 0;
    nqm_model *model = train_model(toy, &o, &report);
    assert_null(model->transport);
    for (size_t k = NQM_SCALAR_ESTIMATE; k < NQM_SCALAR_COUNT; ++k) {
        assert_true(model->scalars.mean[k] == 0);
        assert_true(model->scalars.std[k] == 1);
    }
    check_predictions(model, false);
    check_report(model, &report);
    nqm_model_free(model);
}

/* The novelty of a pair in an evaluation is that of a score: its features come from the model's matrix, not the dataset's. */
TEST(novelty_by_the_models_matrix) {
    for (int with_transport = 0; with_transport < 2; ++with_transport) {
        nqm_train_options o = small_recipe("nqm", 24, 6);
        o.input.transport = with_transport;
        nqm_model *model = train_model(toy, &o, NULL);
        const nqm_transport transport = nqm_model_transport(model);
        nqm_evaluation *ev;
        assert_true(model->n_novelty > 0);
        const nqm_eval_options all = nqm_eval_options_default();
        assert_int_equal(nqm_evaluation_create(toy, 1, (const nqm_model *const[]){model}, NULL, &all, &ev, NULL),
                         NQM_OK);
        for (size_t pair = 0; pair < toy->n_pairs; pair += 7) {
            double scalars[NQM_SCALAR_COUNT];
            compute_scalars(toy->directions, &transport, ref_of(pair), test_of(pair), NULL, scalars);
            assert_near(ev->predictions[pair].novelty, nqm_model_novelty(model, scalars), 1e-12);
        }
        nqm_evaluation_free(ev);
        nqm_model_free(model);
    }
}

/* The content of a model's file as its checksum. */
static void checksum_of(const nqm_model *model, char sha256[65]) {
    nqm_model *loaded;
    assert_int_equal(nqm_model_save(model, model_path, NULL), NQM_OK);
    assert_int_equal(nqm_model_load(model_path, &loaded, NULL), NQM_OK);
    memcpy(sha256, loaded->sha256, 65);
    nqm_model_free(loaded);
}

TEST(resumes_to_the_same_bits) {
    nqm_train_options o = small_recipe("nqm", 24, 6);
    char whole[65], resumed[65];
    nqm_model *model;
    o.optimiser.schedule = NQM_SCHEDULE_PLATEAU; /* only this schedule permits another number of epochs */
    for (int n_threads = 1; n_threads <= 2; ++n_threads) {
        omp_set_num_threads(n_threads);
        o.optimiser.epochs = 6;
        o.run.checkpoint = NULL;
        o.run.resume = 0;
        model = train_model(toy, &o, NULL);
        checksum_of(model, n_threads == 1 ? whole : resumed);
        nqm_model_free(model);
    }
    assert_string_equal(whole, resumed);
    unlink(checkpoint);
    o.run.checkpoint = checkpoint;
    o.optimiser.epochs = 3;
    nqm_model_free(train_model(toy, &o, NULL));
    o.run.resume = 1;
    o.optimiser.epochs = 6;
    model = train_model(toy, &o, NULL);
    checksum_of(model, resumed);
    assert_string_equal(whole, resumed);
    nqm_model_free(model);
    /* the same without the matrix is another training */
    nqm_error err = {0};
    o.input.transport = 0;
    assert_int_equal(nqm_train(toy, &o, &model, NULL, &err), NQM_ERR_INCOMPATIBLE);
    assert_non_null(strstr(err.message, "transport"));
    omp_set_num_threads(1);
}

TEST(the_target_is_a_delta_e) {
    nqm_train_options o = small_recipe("nqm", 24, 6);
    nqm_model *model;
    nqm_error err = {0};
    o.labels.target = NQM_TARGET_JOD;
    assert_int_equal(nqm_train(toy, &o, &model, NULL, &err), NQM_ERR_ARG);
    assert_null(model);
    assert_non_null(strstr(err.message, "transport"));
    assert_non_null(strstr(err.message, "log_delta_e"));
    o.input.transport = 0;
    o.labels.parts_weight = 0;
    model = train_model(toy, &o, NULL);
    assert_null(model->transport);
    nqm_model_free(model);
}

TEST_FILE(make_toy, drop_toy)
