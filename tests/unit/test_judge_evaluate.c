/* SPDX-License-Identifier: MIT
 *
 * Evaluation: every statistic against SciPy (tests/vectors/train_agreement.py), the bootstrap and its contrasts against
 * one that copies the resampled pairs, and models and metrics on a dataset against single predictions.
 */
#include "io/io.h"
#include "judge/judge.h"
#include "math/math.h"
#include "metric/metric.h"
#include "support/check.h"
#include "support/predict.h"
#include "support/toy_dataset.h"
#include "support/training.h"

#include <omp.h>

/* ---- agreement --------------------------------------------------------------------------------------------------- */

enum { MAX_PAIRS = 200, N_GROUPS = 14, N_PREDICTORS = 2 };

static double label[MAX_PAIRS], prediction[N_PREDICTORS * MAX_PAIRS];
static size_t group_begin[N_GROUPS + 1];
static nqm_judgement judgement;

static double number(const nqm_csv *csv, size_t row, const char *column) {
    double value;
    assert_int_equal(nqm_csv_number(csv, row, nqm_csv_column(csv, column), &value, NULL), NQM_OK);
    return value;
}

static int read_pairs(void **state) {
    (void)state;
    omp_set_num_threads(1); /* these networks are too small to use more threads */
    nqm_csv *csv;
    assert_int_equal(nqm_csv_load(test_vector("train_agreement.csv"), &csv, NULL), NQM_OK);
    size_t n = nqm_csv_rows(csv);
    assert_true(n <= MAX_PAIRS);
    for (size_t i = 0; i < n; ++i) {
        label[i] = number(csv, i, "label");
        prediction[i] = number(csv, i, "first");
        prediction[n + i] = number(csv, i, "second");
        ++group_begin[(size_t)number(csv, i, "group") + 1];
    }
    for (size_t g = 0; g < N_GROUPS; ++g)
        group_begin[g + 1] += group_begin[g];
    size_t n_groups = 0;
    for (size_t g = 0; g < N_GROUPS; ++g) /* without the empty one */
        if (group_begin[g + 1] > group_begin[g])
            group_begin[n_groups++] = group_begin[g];
    group_begin[n_groups] = n;
    judgement = (nqm_judgement){.n = n,
                                .n_groups = n_groups,
                                .n_predictors = N_PREDICTORS,
                                .group_begin = group_begin,
                                .label = label,
                                .prediction = prediction,
                                .order_margin = 0.25};
    nqm_csv_free(csv);
    return 0;
}

TEST(figures_are_scipys) {
    nqm_agreement a[N_PREDICTORS];
    nqm_csv *csv;
    assert_int_equal(nqm_judge(&judgement, 0, 1, a, NULL), NQM_OK);
    assert_int_equal(nqm_csv_load(test_vector("train_agreement_expected.csv"), &csv, NULL), NQM_OK);
    for (size_t p = 0; p < N_PREDICTORS; ++p) {
        assert_int_equal(a[p].n, judgement.n);
        assert_int_equal(a[p].n_materials, 13);
        assert_near(a[p].spearman.value, number(csv, p, "spearman"), 1e-9);
        assert_near(a[p].spearman_mean_by_material.value, number(csv, p, "spearman_mean_by_material"), 1e-9);
        assert_near(a[p].pearson.value, number(csv, p, "pearson"), 1e-9);
        assert_near(a[p].kendall.value, number(csv, p, "kendall"), 1e-9);
        assert_near(a[p].mae.value, number(csv, p, "mae"), 1e-9);
        assert_near(a[p].rmse.value, number(csv, p, "rmse"), 1e-9);
        assert_near(a[p].r2.value, number(csv, p, "r2"), 1e-9);
        assert_int_equal(a[p].n_ordered, number(csv, p, "n_ordered"));
        assert_near(a[p].order.value, number(csv, p, "order"), 1e-9);
        assert_true(isnan(a[p].spearman.ci95[0]) && isnan(a[p].spearman_mean_by_material.ci95[1]));
    }
    nqm_csv_free(csv);
}

/* The statistics of one resample, in the order of `figures_of`. */
enum { POOLED, BY_GROUP, PEARSON, KENDALL, MAE, RMSE, R2, ORDER, N_FIGURES };

/* Count the pairs of elements in x, y [begin, end) whose labels differ, and those of them in the correct order. */
static void add_orders(const double *x, const double *y, size_t begin, size_t end, double *right, double *n) {
    for (size_t i = begin; i < end; ++i)
        for (size_t k = begin; k < end; ++k)
            if (y[i] - y[k] > judgement.order_margin) {
                *n += 1;
                *right += x[i] > x[k] ? 1 : x[i] == x[k] ? 0.5 : 0;
            }
}

/* One resample with its pairs repeated in memory. A group that is drawn twice counts twice. */
static void repeat_pairs(uint64_t seed, size_t index, size_t predictor, double figures[N_FIGURES]) {
    enum { MAX_REPEATED = 13 * MAX_PAIRS };
    static double x[MAX_REPEATED], y[MAX_REPEATED];
    size_t n = 0, n_rho = 0;
    double sum = 0, right = 0, ordered = 0, absolute = 0, squared = 0, variance = 0;
    nqm_rng rng = nqm_rng_make(seed, index);
    for (size_t k = 0; k < judgement.n_groups; ++k) {
        size_t g = nqm_rng_below(&rng, judgement.n_groups), first = n;
        for (size_t i = group_begin[g]; i < group_begin[g + 1]; ++i) {
            x[n] = prediction[predictor * judgement.n + i];
            y[n++] = label[i];
        }
        add_orders(x, y, first, n, &right, &ordered);
        if (n - first >= 3) {
            sum += nqm_spearman(n - first, x + first, y + first);
            ++n_rho;
        }
    }
    for (size_t i = 0; i < n; ++i) {
        absolute += fabs(x[i] - y[i]) / (double)n;
        squared += (x[i] - y[i]) * (x[i] - y[i]) / (double)n;
        variance += pow(y[i] - nqm_mean(n, y), 2) / (double)n;
    }
    const double found[N_FIGURES] = {[POOLED] = nqm_spearman(n, x, y),
                                     [BY_GROUP] = sum / (double)n_rho,
                                     [PEARSON] = nqm_pearson(n, x, y),
                                     [KENDALL] = nqm_kendall(n, x, y),
                                     [MAE] = absolute,
                                     [RMSE] = sqrt(squared),
                                     [R2] = 1 - squared / variance,
                                     [ORDER] = right / ordered};
    memcpy(figures, found, sizeof found);
}

enum { N_RESAMPLES = 101 };

/* All resamples: figures (N_FIGURES, N_RESAMPLES). */
static void repeat_all(size_t predictor, double figures[N_FIGURES][N_RESAMPLES]) {
    for (size_t i = 0; i < N_RESAMPLES; ++i) {
        double one[N_FIGURES];
        repeat_pairs(5, i, predictor, one);
        for (size_t f = 0; f < N_FIGURES; ++f)
            figures[f][i] = one[f];
    }
}

TEST(bootstrap_repeats_groups) {
    nqm_agreement a[N_PREDICTORS];
    assert_int_equal(nqm_judge(&judgement, N_RESAMPLES, 5, a, NULL), NQM_OK);
    for (size_t p = 0; p < N_PREDICTORS; ++p) {
        double figures[N_FIGURES][N_RESAMPLES];
        repeat_all(p, figures);
        const double *intervals[N_FIGURES] = {
            [POOLED] = a[p].spearman.ci95, [BY_GROUP] = a[p].spearman_mean_by_material.ci95,
            [PEARSON] = a[p].pearson.ci95, [KENDALL] = a[p].kendall.ci95,
            [MAE] = a[p].mae.ci95,         [RMSE] = a[p].rmse.ci95,
            [R2] = a[p].r2.ci95,           [ORDER] = a[p].order.ci95};
        for (size_t f = 0; f < N_FIGURES; ++f) {
            assert_near(intervals[f][0], nqm_quantile(N_RESAMPLES, figures[f], 0.025), 1e-9);
            assert_near(intervals[f][1], nqm_quantile(N_RESAMPLES, figures[f], 0.975), 1e-9);
        }
        assert_true(a[p].spearman.ci95[0] < a[p].spearman.value && a[p].spearman.value < a[p].spearman.ci95[1]);
    }
}

static void check_difference(const nqm_difference *d, double value, const double *first, const double *second) {
    double difference[N_RESAMPLES];
    size_t n_below = 0;
    for (size_t i = 0; i < N_RESAMPLES; ++i) {
        difference[i] = first[i] - second[i];
        n_below += difference[i] < 0;
    }
    assert_near(d->value, value, 1e-12);
    assert_near(d->share_below_0, (double)n_below / N_RESAMPLES, 1e-12);
    assert_near(d->ci95[0], nqm_quantile(N_RESAMPLES, difference, 0.025), 1e-9);
    assert_near(d->ci95[1], nqm_quantile(N_RESAMPLES, difference, 0.975), 1e-9);
}

/* A contrast is the difference of two predictors on the same resamples; that of a predictor with itself is 0. */
TEST(contrasts_are_paired) {
    nqm_agreement a[N_PREDICTORS];
    nqm_contrast c[3] = {{.first = 0, .second = 1}, {.first = 1, .second = 0}, {.first = 1, .second = 1}};
    assert_int_equal(nqm_judge(&judgement, 0, 5, a, NULL), NQM_OK);
    assert_int_equal(nqm_judge_contrasts(&judgement, N_RESAMPLES, 5, 3, c, NULL), NQM_OK);
    static double figures[2][N_FIGURES][N_RESAMPLES];
    repeat_all(0, figures[0]);
    repeat_all(1, figures[1]);
    for (size_t i = 0; i < 2; ++i) {
        size_t p = c[i].first, q = c[i].second;
        check_difference(&c[i].spearman, a[p].spearman.value - a[q].spearman.value, figures[p][POOLED],
                         figures[q][POOLED]);
        check_difference(&c[i].spearman_mean_by_material,
                         a[p].spearman_mean_by_material.value - a[q].spearman_mean_by_material.value,
                         figures[p][BY_GROUP], figures[q][BY_GROUP]);
        check_difference(&c[i].order, a[p].order.value - a[q].order.value, figures[p][ORDER], figures[q][ORDER]);
    }
    assert_true(c[2].spearman.value == 0 && c[2].spearman.ci95[1] == 0 && c[2].spearman.share_below_0 == 0);
    assert_int_equal(nqm_judge_contrasts(&judgement, 0, 5, 1, c, NULL), NQM_OK);
    assert_true(isnan(c[0].spearman.share_below_0) && isnan(c[0].spearman.ci95[0]));
    assert_near(c[0].spearman.value, a[0].spearman.value - a[1].spearman.value, 1e-12);
}

/* Correlations are undefined without variance, and the order is undefined if no labels differ. */
TEST(figures_that_do_not_exist) {
    const double flat[6] = {0.1, 0.1, 0.1, 0.1, 0.1, 0.1}, rising[6] = {1, 2, 3, 4, 5, 6};
    const size_t begin[3] = {0, 3, 6};
    nqm_judgement j = {
        .n = 6, .n_groups = 2, .n_predictors = 1, .group_begin = begin, .label = flat, .prediction = rising};
    nqm_agreement a;
    assert_int_equal(nqm_judge(&j, 20, 1, &a, NULL), NQM_OK);
    assert_true(isnan(a.spearman.value) && isnan(a.spearman_mean_by_material.value) && isnan(a.pearson.value) &&
                isnan(a.kendall.value));
    assert_true(isnan(a.r2.value) && isnan(a.order.value) && isnan(a.pearson.ci95[0]) && isnan(a.order.ci95[1]));
    assert_int_equal(a.n_ordered, 0);
    assert_near(a.mae.value, 3.4, 1e-12);
    j.label = rising;
    j.prediction = flat;
    assert_int_equal(nqm_judge(&j, 20, 1, &a, NULL), NQM_OK);
    assert_true(isnan(a.pearson.value));
    assert_int_equal(a.n_ordered, 6);
    assert_near(a.order.value, 0.5, 0); /* ties count half */
    j.order_margin = 1;                 /* labels must differ by more than the margin */
    assert_int_equal(nqm_judge(&j, 0, 1, &a, NULL), NQM_OK);
    assert_int_equal(a.n_ordered, 2);
}

TEST(best_variants) {
    const double spearman[NQM_METRIC_COUNT] = {0.3, 0.5, 0.8, 0.8, NAN, 0.2, NAN, NAN, 0.9};
    const int of_family[NQM_METRIC_COUNT] = {0, 1, 1, 0, 0, 1, 0, 0, 0};
    nqm_agreement metrics[NQM_METRIC_COUNT] = {0};
    for (size_t m = 0; m < NQM_METRIC_COUNT; ++m)
        metrics[m].spearman.value = spearman[m];
    nqm_mark_best(metrics);
    for (size_t m = 0; m < NQM_METRIC_COUNT; ++m) {
        assert_int_equal(metrics[m].best_of_family, of_family[m]);
        assert_int_equal(metrics[m].best_baseline, m == NQM_METRIC_RMS_CRWE); /* log_diff is not a baseline */
    }
}

/* ---- evaluation -------------------------------------------------------------------------------------------------- */

static nqm_model *train_small(const nqm_dataset *d, const char *recipe) {
    const nqm_train_options o = small_recipe(recipe, 32, 5);
    return train_model(d, &o, NULL);
}

/* Predict and judge one model. */
static nqm_status evaluate(const nqm_model *model, const nqm_dataset *d, const nqm_eval_options *o,
                           nqm_agreement *results, nqm_error *err) {
    nqm_evaluation *ev;
    nqm_status status = nqm_evaluation_create(d, 1, &model, NULL, o, &ev, err);
    if (status == NQM_OK)
        status = nqm_evaluation_judge(ev, o, results, err);
    nqm_evaluation_free(ev);
    return status;
}

TEST(predictions_are_those_of_single_pairs) {
    toy_options t = toy_options_default();
    nqm_dataset *d = toy_dataset(&t);
    nqm_model *models[2] = {train_small(d, "paper"), train_small(d, "nqm")};
    nqm_eval_options o = nqm_eval_options_default();
    o.split = NQM_SPLIT_TEST;
    nqm_evaluation *ev;
    assert_int_equal(nqm_evaluation_create(d, 2, (const nqm_model *const *)models, NULL, &o, &ev, NULL), NQM_OK);
    assert_string_equal(ev->names[1], "nqm");
    assert_string_equal(ev->names[2], "rmse");
    size_t n = 3 * d->n_directions;
    for (size_t pair = 0; pair < d->n_pairs; ++pair) {
        const float *ref = d->ref_rgb + d->pair_ref[pair] * n, *test = d->test_rgb + pair * n;
        double metrics[NQM_METRIC_COUNT], jod;
        assert_int_equal(nqm_metrics_compute(d->directions, ref, test, NULL, metrics, NULL), NQM_OK);
        double scalars[NQM_SCALAR_COUNT];
        compute_scalars(d->directions, NULL, ref, test, NULL, scalars);
        bool in_test = nqm_dataset_get_pair(d, pair).split == NQM_SPLIT_TEST;
        for (size_t i = 0; i < 2 + NQM_METRIC_COUNT; ++i) {
            double value = nqm_evaluation_values(ev, i)[pair];
            assert_true(isnan(value) == !in_test);
            if (i < 2)
                predict_jod(models[i], 1, ref, test, &jod);
            if (in_test)
                assert_near(value, i < 2 ? jod : metrics[i - 2], 1e-5);
        }
        for (size_t i = 0; i < NQM_SCALAR_COUNT; ++i) {
            double value = ev->scalars[pair * NQM_SCALAR_COUNT + i];
            assert_true(in_test ? value == scalars[i] : isnan(value));
        }
    }
    nqm_evaluation_free(ev);
    nqm_model_free(models[0]);
    nqm_model_free(models[1]);
    nqm_dataset_free(d);
}

/* A reference at the mirror direction, twice far from it, and at a grazing angle. */
static const char *class_of(double near, double far, const float colour[3]) {
    double degrees[4][3] = {{1, 10, 0}, {30, 20, 0}, {40, 20, 0}, {1, 70, 0}};
    float rgb[12];
    for (size_t k = 0; k < 3; ++k) {
        rgb[k] = (float)near;
        rgb[3 + k] = rgb[6 + k] = (float)far * colour[k];
        rgb[9 + k] = 1e4f; /* grazing angles are ignored */
    }
    nqm_dataset d = {.n_directions = 4, .n_refs = 1, .directions_deg = degrees[0], .ref_rgb = rgb};
    return nqm_material_class_name(nqm_dataset_ref_class(&d, 0));
}

TEST(classes_of_materials) {
    float grey[3] = {1, 1, 1};
    const float warm[3] = {1.2f, 1, 0.9f}, red[3] = {2, 0.5f, 0.5f};
    assert_string_equal(class_of(0.2, 0.1, grey), "matte grey");
    assert_string_equal(class_of(0.2, 0.1, red), "matte coloured");
    assert_string_equal(class_of(1, 0.1, warm), "satin grey");
    assert_string_equal(class_of(5, 0.1, red), "glossy coloured");
    assert_string_equal(class_of(50, 0.1, grey), "mirror-like grey");
    assert_string_equal(class_of(1, 0, grey), "mirror-like grey"); /* black has no hue */
    assert_string_equal(class_of(0.003, 0.0015, red),
                        "matte grey"); /* the mean is near the constant of the logarithm */
    double degrees[3] = {1, 10, 0};
    nqm_dataset no_body = {.n_directions = 1, .n_refs = 1, .directions_deg = degrees, .ref_rgb = grey};
    assert_string_equal(nqm_material_class_name(nqm_dataset_ref_class(&no_body, 0)), "unclassified");
    assert_null(nqm_material_class_name(NQM_MATERIAL_CLASS_COUNT));
}

/* The contrasts of an evaluation are consistent with its results. */
static void check_contrasts(const nqm_model *model, const nqm_dataset *d, const nqm_eval_options *o,
                            const nqm_agreement *a) {
    nqm_evaluation *ev;
    nqm_contrast c[2] = {{.first = 0, .second = 1 + NQM_METRIC_LOG_DIFF}, {.first = 0, .second = 1}};
    assert_int_equal(nqm_evaluation_create(d, 1, &model, NULL, o, &ev, NULL), NQM_OK);
    assert_int_equal(nqm_evaluation_contrast(ev, o, 2, c, NULL), NQM_OK);
    for (size_t i = 0; i < 2; ++i) {
        assert_near(c[i].spearman.value, a[0].spearman.value - a[c[i].second].spearman.value, 1e-12);
        assert_near(c[i].order.value, a[0].order.value - a[c[i].second].order.value, 1e-12);
        assert_true(c[i].spearman.ci95[0] <= c[i].spearman.ci95[1]);
    }
    c[0].second = 1 + NQM_METRIC_COUNT;
    assert_int_equal(nqm_evaluation_contrast(ev, o, 2, c, NULL), NQM_ERR_ARG);
    nqm_eval_options bad = *o;
    bad.order_margin = -1;
    assert_int_equal(nqm_evaluation_contrast(ev, &bad, 1, &c[1], NULL), NQM_ERR_ARG);
    nqm_evaluation_free(ev);
}

TEST(selections) {
    toy_options t = toy_options_default();
    t.with_masks = true;
    nqm_dataset *d = toy_dataset(&t);
    nqm_model *model = train_small(d, "nqm");
    nqm_agreement a[1 + NQM_METRIC_COUNT];
    nqm_eval_options o = nqm_eval_options_default();
    o.n_bootstrap = 50;
    assert_int_equal(evaluate(model, d, &o, a, NULL), NQM_OK);
    assert_int_equal(a[0].n, 576);
    assert_int_equal(a[0].n_materials, 24);
    for (size_t i = 0; i < 1 + NQM_METRIC_COUNT; ++i) {
        assert_true(a[i].spearman.value > 0.3 && a[i].spearman.value <= 1); /* distances are negated */
        assert_true(a[i].spearman.ci95[0] <= a[i].spearman.ci95[1]);
        assert_true(isnan(a[i].mae.value) == (i > 0));
    }
    check_contrasts(model, d, &o, a);
    assert_true(a[1 + NQM_METRIC_LOG_DIFF].spearman.value >
                0.97); /* the toy's label is that metric except for the masks */
    o.split = NQM_SPLIT_TEST;
    o.kind = "gloss";
    assert_int_equal(evaluate(model, d, &o, a, NULL), NQM_OK);
    assert_int_equal(a[0].n, 576 / 4 / 2);
    assert_int_equal(a[0].n_materials, 6);
    o.kind = NULL;
    o.family = "perturbation"; /* the family of the kind "gain" */
    assert_int_equal(evaluate(model, d, &o, a, NULL), NQM_OK);
    assert_int_equal(a[0].n, 576 / 4 / 2);
    o.kind = "gloss";
    assert_int_equal(evaluate(model, d, &o, a, NULL), NQM_ERR_INCOMPATIBLE);
    size_t n_high = 0, n_low = 0;
    for (size_t i = 0; i < d->n_pairs; ++i)
        n_high += d->jod[i] >= 9.5;
    o = nqm_eval_options_default();
    o.n_bootstrap = 0;
    o.jod_from = 9.5;
    assert_int_equal(evaluate(model, d, &o, a, NULL), NQM_OK);
    assert_int_equal(a[0].n, n_high);
    n_low = d->n_pairs - n_high;
    o.jod_from = 0;
    o.jod_to = 9.5;
    assert_int_equal(evaluate(model, d, &o, a, NULL), NQM_OK);
    assert_int_equal(a[0].n, n_low);
    o = nqm_eval_options_default();
    o.n_bootstrap = 0;
    size_t n_classified = 0;
    for (size_t i = 0; i < NQM_MATERIAL_CLASS_COUNT; ++i) {
        size_t n_class = 0;
        o.material_class = nqm_material_class_name(i);
        for (size_t pair = 0; pair < d->n_pairs; ++pair)
            n_class += strcmp(nqm_dataset_get_pair(d, pair).material_class, o.material_class) == 0;
        nqm_status status = evaluate(model, d, &o, a, NULL);
        assert_int_equal(status, n_class ? NQM_OK : NQM_ERR_INCOMPATIBLE);
        assert_true(n_class == 0 || a[0].n == n_class);
        n_classified += n_class;
    }
    assert_int_equal(n_classified, d->n_pairs);
    o.material_class = NULL;
    o.kind = "rust";
    nqm_error err = {0};
    assert_int_equal(evaluate(model, d, &o, a, &err), NQM_ERR_INCOMPATIBLE);
    t.seed = 2;
    o.kind = NULL;
    nqm_dataset *elsewhere = toy_dataset(&t);
    assert_int_equal(evaluate(model, elsewhere, &o, a, &err), NQM_ERR_INCOMPATIBLE);
    assert_non_null(strstr(err.message, "directions"));
    nqm_dataset_free(elsewhere);
    nqm_model_free(model);
    nqm_dataset_free(d);
}

TEST_FILE(read_pairs, NULL)
