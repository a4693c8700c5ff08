/* SPDX-License-Identifier: MIT
 *
 * Evaluation of the parts of labels against correlations of single predictions, the estimate by light transport, and
 * subsets of pairs.
 */
#include "judge/judge.h"
#include "math/math.h"
#include "metric/metric.h"
#include "support/check.h"
#include "support/predict.h"
#include "support/toy_dataset.h"
#include "support/training.h"

#include <omp.h>

static nqm_model *train_small(const nqm_dataset *d, const char *recipe) {
    const nqm_train_options o = small_recipe(recipe, 32, 3);
    return train_model(d, &o, NULL);
}

static nqm_dataset *dataset;
static nqm_model *models[2]; /* with parts, and without */
static nqm_evaluation *evaluation;

static int set_up(void **state) {
    (void)state;
    omp_set_num_threads(1); /* these networks are too small to use more threads */
    toy_options t = toy_options_default();
    t.with_transport = true;
    t.families[1] = "far";
    t.unseen = "gloss";
    dataset = toy_dataset(&t);
    models[0] = train_small(dataset, "nqm");
    models[1] = train_small(dataset, "paper");
    nqm_eval_options o = nqm_eval_options_default();
    o.split = NQM_SPLIT_TEST;
    return nqm_evaluation_create(dataset, 2, (const nqm_model *const *)models, NULL, &o, &evaluation, NULL) != NQM_OK;
}

static int tear_down(void **state) {
    (void)state;
    nqm_evaluation_free(evaluation);
    nqm_model_free(models[0]);
    nqm_model_free(models[1]);
    nqm_dataset_free(dataset);
    return 0;
}

static double part_of(const nqm_label *label, size_t part) {
    double parts[NQM_LABEL_PARTS];
    nqm_label_get_parts(label, parts);
    return part < NQM_LABEL_PARTS ? parts[part] : nqm_label_adapted_jod(label);
}

/* Spearman of a part of the labels (NULL: of scalar feature i times `sign`) with the dataset's, over the pairs of the split. */
static double spearman_of(size_t part, const nqm_label *labels, size_t scalar, double sign) {
    double *x = malloc(2 * dataset->n_pairs * sizeof *x), *y = x + dataset->n_pairs;
    size_t n = 0;
    assert_non_null(x);
    for (size_t i = 0; i < dataset->n_pairs; ++i)
        if (nqm_dataset_pair_split(dataset, i) == NQM_SPLIT_TEST) {
            nqm_label label = {0};
            nqm_label_set_parts(&label, dataset->parts + i * NQM_LABEL_PARTS);
            x[n] = labels ? part_of(&labels[i], part) : sign * evaluation->scalars[i * NQM_SCALAR_COUNT + scalar];
            y[n++] = part_of(&label, part);
        }
    const double rho = nqm_spearman(n, x, y);
    free(x);
    return rho;
}

/* How often the model's part of a label above 3 Delta-E (contrast: 0.1) has the sign of the label. */
static void check_signs(size_t part, const nqm_part_agreement *p) {
    const nqm_label *predicted = nqm_evaluation_labels(evaluation, 0);
    size_t n = 0, n_same = 0;
    for (size_t i = 0; part < NQM_LABEL_PARTS && i < dataset->n_pairs; ++i) {
        const double label = dataset->parts[i * NQM_LABEL_PARTS + part];
        if (nqm_dataset_pair_split(dataset, i) != NQM_SPLIT_TEST || fabs(label) <= (part == 3 ? 0.1 : 3))
            continue;
        ++n;
        n_same += part == 4 ? part_of(&predicted[i], part) >= 1 : label * part_of(&predicted[i], part) > 0;
    }
    assert_int_equal(p->n_plain, n);
    if (n)
        assert_near(p->same_sign, (double)n_same / (double)n, 1e-15);
    else
        assert_true(isnan(p->same_sign));
}

TEST(parts_are_judged) {
    static const char *const names[NQM_EVAL_PARTS] = {"shift_i",  "shift_t",   "shift_p",
                                                      "contrast", "structure", "adapted_jod"};
    const size_t log_diff = NQM_SCALAR_METRICS + NQM_METRIC_LOG_DIFF;
    const size_t scalars[NQM_EVAL_PARTS][2] = {
        {NQM_SCALAR_BIAS, NQM_SCALAR_ENERGY},         {NQM_SCALAR_CHROMA_B, NQM_SCALAR_CHROMA_B},
        {NQM_SCALAR_CHROMA_RG, NQM_SCALAR_CHROMA_RG}, {NQM_SCALAR_PEAK, NQM_SCALAR_WIDTH},
        {NQM_SCALAR_SHAPE, NQM_SCALAR_SHAPE},         {log_diff, log_diff}};
    nqm_part_agreement parts[NQM_EVAL_PARTS];
    nqm_eval_options o = nqm_eval_options_default();
    o.n_bootstrap = 50;
    assert_int_equal(nqm_evaluation_judge_parts(evaluation, &o, 0, parts, NULL), NQM_OK);
    for (size_t i = 0; i < NQM_EVAL_PARTS; ++i) {
        const nqm_part_agreement *p = &parts[i];
        const double sign = i == NQM_LABEL_PARTS ? -1 : 1;
        const double scalar =
            fmax(spearman_of(i, NULL, scalars[i][0], sign), spearman_of(i, NULL, scalars[i][1], sign));
        assert_string_equal(p->part, names[i]);
        assert_true(p->n == 144 && p->n_materials == 6);
        assert_near(p->model.value, spearman_of(i, nqm_evaluation_labels(evaluation, 0), 0, 1), 1e-12);
        assert_true(p->model.ci95[0] <= p->model.value && p->model.value <= p->model.ci95[1]);
        assert_near(p->estimate.value, spearman_of(i, nqm_evaluation_labels(evaluation, 2 + NQM_METRIC_COUNT), 0, 1),
                    1e-12);
        assert_true(p->estimate.value > 0.9);
        assert_near(p->scalar.value, scalar, 1e-12);
        check_signs(i, p);
    }
    assert_string_equal(parts[NQM_LABEL_PARTS].scalar_name, "log_log_diff");
    o.subset = "far";
    assert_int_equal(nqm_evaluation_judge_parts(evaluation, &o, 0, parts, NULL), NQM_OK);
    assert_int_equal(parts[0].n, 72);
    o.subset = "rounding";
    assert_int_equal(nqm_evaluation_judge_parts(evaluation, &o, 0, parts, NULL), NQM_ERR_INCOMPATIBLE);
}

TEST(parts_that_do_not_exist) {
    nqm_part_agreement parts[NQM_EVAL_PARTS];
    const nqm_eval_options all = nqm_eval_options_default();
    assert_int_equal(nqm_evaluation_judge_parts(evaluation, &all, 1, parts, NULL), NQM_ERR_ARG); /* one output */
    assert_int_equal(nqm_evaluation_judge_parts(evaluation, &all, 2, parts, NULL), NQM_ERR_ARG); /* a metric */
    toy_options t = toy_options_default(); /* the same directions and BRDFs, but neither parts nor a matrix */
    nqm_dataset *d = toy_dataset(&t);
    nqm_evaluation *ev;
    nqm_eval_options o = nqm_eval_options_default();
    o.n_bootstrap = 0;
    assert_int_equal(nqm_evaluation_create(d, 1, (const nqm_model *const *)models, NULL, &o, &ev, NULL), NQM_OK);
    assert_int_equal(ev->n_predictors, 1 + NQM_METRIC_COUNT);
    assert_int_equal(nqm_evaluation_judge_parts(ev, &o, 0, parts, NULL), NQM_ERR_INCOMPATIBLE);
    double *known = dataset->parts;
    d->parts = known; /* for parts without a matrix */
    assert_int_equal(nqm_evaluation_judge_parts(ev, &o, 0, parts, NULL), NQM_OK);
    assert_true(isnan(parts[0].estimate.value) && isfinite(parts[0].model.value));
    assert_true(isnan(parts[0].model.ci95[0]));
    nqm_evaluation_free(ev);
    nqm_dataset_free(d);
}

/* The estimate is a predictor: its label is that of the matrix, and its JOD that of the published curve. */
TEST(estimate_is_a_predictor) {
    const size_t estimate = 2 + NQM_METRIC_COUNT, n = 3 * dataset->n_directions;
    const nqm_transport transport = nqm_dataset_transport(dataset);
    assert_int_equal(evaluation->n_predictors, estimate + 1);
    assert_non_null(nqm_evaluation_labels(evaluation, 0));
    assert_null(nqm_evaluation_labels(evaluation, 1));
    assert_null(nqm_evaluation_labels(evaluation, 2));
    for (size_t i = 0; i < dataset->n_pairs; ++i) {
        const bool in_test = nqm_dataset_pair_split(dataset, i) == NQM_SPLIT_TEST;
        const nqm_label *label = &nqm_evaluation_labels(evaluation, estimate)[i];
        const nqm_label expected = transport_estimate(&transport, dataset->ref_rgb + dataset->pair_ref[i] * n,
                                                      dataset->test_rgb + i * n, NULL);
        assert_true(isnan(label->structure) == !in_test);
        assert_true(isnan(nqm_evaluation_labels(evaluation, 0)[i].structure) == !in_test);
        if (in_test) {
            assert_near(label->delta_e, expected.delta_e, 0);
            assert_near(nqm_evaluation_values(evaluation, estimate)[i],
                        nqm_curve_jod(&nqm_curve_published, expected.delta_e), 0);
        }
    }
    nqm_agreement results[3 + NQM_METRIC_COUNT];
    const nqm_eval_options all = nqm_eval_options_default();
    assert_int_equal(nqm_evaluation_judge(evaluation, &all, results, NULL), NQM_OK);
    assert_string_equal(results[estimate].name, "estimate");
    assert_true(results[estimate].spearman.value > 0.5 && isfinite(results[estimate].mae.value));
    assert_true(isnan(results[estimate - 1].mae.value));
}

TEST(subsets) {
    const struct {
        const char *name;
        size_t n;
    } expected[] = {{NULL, 144},    {"near", 72}, {"far", 72},    {"rounding", 0},
                    {"unseen", 72}, {"seen", 72}, {"nonsense", 0}};
    nqm_agreement results[3 + NQM_METRIC_COUNT];
    nqm_eval_options o = nqm_eval_options_default();
    o.n_bootstrap = 0;
    for (size_t i = 0; i < sizeof expected / sizeof *expected; ++i) {
        o.subset = expected[i].name;
        nqm_status status = nqm_evaluation_judge(evaluation, &o, results, NULL);
        assert_int_equal(status, expected[i].n ? NQM_OK : NQM_ERR_INCOMPATIBLE);
        assert_true(status != NQM_OK || results[0].n == expected[i].n);
    }
    o.subset = "unseen";
    o.kind = "gain";
    assert_int_equal(nqm_evaluation_judge(evaluation, &o, results, NULL), NQM_ERR_INCOMPATIBLE);
}

TEST_FILE(set_up, tear_down)
