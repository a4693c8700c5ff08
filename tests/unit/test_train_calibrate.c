/* SPDX-License-Identifier: MIT
 *
 * Models with intervals: the model file, scores, calibration by training and after training, and the number of labels
 * inside.
 */
#include "io/io.h"
#include "judge/judge.h"
#include "metric/metric.h"
#include "support/check.h"
#include "support/scratch.h"
#include "support/tiny_model.h"
#include "support/toy_dataset.h"
#include "support/training.h"
#include "train/train.h"

static const double small_table[9] = {0, 0, 3, 8, 6, 9, 10, 9.5, 10};

static nqm_model *calibrated_model(void) {
    nqm_model *model;
    assert_int_equal(make_tiny_model(20, &model, NULL), NQM_OK);
    model->interval = nqm_alloc(9, sizeof(double));
    memcpy(model->interval, small_table, sizeof small_table);
    model->n_interval = 3;
    model->calibration = nqm_strdup("{\"materials\":12}");
    return model;
}

static void assert_interval(const nqm_model *model, double jod, double low, double high) {
    double l, h;
    nqm_model_interval(model, jod, NAN, 0, &l, &h);
    assert_near(l, low, 1e-12);
    assert_near(h, high, 1e-12);
}

/* ---- the file ---------------------------------------------------------------------------------------------------- */

TEST(tables_are_interpolated_and_stored) {
    nqm_model *model = calibrated_model(), *read;
    assert_int_equal(nqm_model_save(model, scratch_path("model"), NULL), NQM_OK);
    assert_int_equal(nqm_model_load(scratch_path("model"), &read, NULL), NQM_OK);
    for (int i = 0; i < 2; ++i) {
        const nqm_model *m = i ? read : model;
        assert_interval(m, 8, 6, 9);
        assert_interval(m, 4, 3, 6);
        assert_interval(m, 9, 7.75, 9.5);
        assert_interval(m, 10.5, 9.5, 10.5); /* the interval contains predictions beyond the table */
        assert_interval(m, -1, -1, 3);
        assert_string_equal(nqm_model_get_info(m).calibration, "{\"materials\":12}");
    }
    double low, high;
    nqm_model_interval(model, NAN, 0, 0, &low, &high);
    assert_true(isnan(low) && isnan(high));
    nqm_model_free(read);
    nqm_model_free(model);
}

TEST(models_without_have_none) {
    nqm_model *model, *read;
    assert_int_equal(make_tiny_model(20, &model, NULL), NQM_OK);
    assert_int_equal(nqm_model_save(model, scratch_path("model"), NULL), NQM_OK);
    assert_int_equal(nqm_model_load(scratch_path("model"), &read, NULL), NQM_OK);
    double low, high;
    nqm_model_interval(read, 8, 0, 0, &low, &high);
    assert_true(isnan(low) && isnan(high));
    assert_string_equal(nqm_model_get_info(read).calibration, "");
    nqm_model_free(read);
    nqm_model_free(model);
}

TEST(broken_tables_are_refused) {
    const double breaks[][2] = {
        {3, 0},  /* a duplicate prediction */
        {4, 9},  /* a lower bound above its prediction */
        {5, 2},  /* an upper bound below its prediction */
        {7, 5},  /* lower bounds decrease */
        {4, -1}, /* likewise */
    };
    for (size_t i = 0; i < sizeof breaks / sizeof *breaks; ++i) {
        nqm_model *model = calibrated_model(), *read = NULL;
        nqm_error err = {0};
        model->interval[(size_t)breaks[i][0]] = breaks[i][1];
        assert_int_equal(nqm_model_save(model, scratch_path("model"), NULL), NQM_OK);
        assert_int_equal(nqm_model_load(scratch_path("model"), &read, &err), NQM_ERR_MODEL);
        assert_non_null(strstr(err.message, "interval"));
        model->interval[(size_t)breaks[i][0]] = NAN;
        assert_int_equal(nqm_model_save(model, scratch_path("model"), NULL), NQM_OK);
        assert_int_equal(nqm_model_load(scratch_path("model"), &read, &err), NQM_ERR_MODEL);
        nqm_model_free(model);
    }
    assert_non_null(nqm_interval_table_fault(1, small_table));
    assert_null(nqm_interval_table_fault(3, small_table));
}

/* Change the one occurrence of a name in the header to another of the same length. */
static void rename_in_header(nqm_map *map, unsigned char *copy, const char *from, const char *to) {
    memcpy(copy, map->data, map->n_bytes);
    char *at = strstr((char *)copy + sizeof(uint64_t), from); /* after the header length */
    assert_non_null(at);
    memcpy(at, to, strlen(to));
}

TEST(table_and_text_go_together) {
    nqm_model *model = calibrated_model(), *read;
    nqm_map map;
    assert_int_equal(nqm_model_save(model, scratch_path("model"), NULL), NQM_OK);
    assert_int_equal(nqm_map_open(scratch_path("model"), &map, NULL), NQM_OK);
    unsigned char *copy = malloc(map.n_bytes);
    rename_in_header(&map, copy, "\"calibration\"", "\"calibratiox\"");
    assert_int_equal(nqm_model_parse(copy, map.n_bytes, "m", false, &read, NULL), NQM_ERR_MODEL);
    rename_in_header(&map, copy, "\"interval\"", "\"intervax\"");
    assert_int_equal(nqm_model_parse(copy, map.n_bytes, "m", false, &read, NULL), NQM_ERR_MODEL);
    free(copy);
    nqm_map_close(&map);
    nqm_model_free(model);
}

/* ---- scores ------------------------------------------------------------------------------------------------------ */

TEST(scores_have_intervals) {
    nqm_brdf *ref = must_open("sgd:nickel"), *test = must_open("ward:nickel");
    const nqm_brdf *tests[] = {ref, test};
    nqm_model *model = calibrated_model();
    nqm_score_result r[2];
    assert_int_equal(nqm_score(model, ref, 2, tests, NULL, r, NULL), NQM_OK);
    assert_true(r[0].identical && r[0].jod_low == 10 && r[0].jod_high == 10);
    assert_interval(model, r[1].jod, r[1].jod_low, r[1].jod_high);
    assert_true(r[1].jod_low < r[1].jod && r[1].jod < r[1].jod_high);
    nqm_free(model->interval);
    model->interval = NULL;
    assert_int_equal(nqm_score(model, ref, 2, tests, NULL, r, NULL), NQM_OK);
    for (size_t i = 0; i < 2; ++i)
        assert_true(isfinite(r[i].jod) && isnan(r[i].jod_low) && isnan(r[i].jod_high));
    nqm_model_free(model);
    nqm_brdf_free(ref);
    nqm_brdf_free(test);
}

/* ---- calibration by training and later --------------------------------------------------------------------------- */

static nqm_dataset *dataset; /* 12 validation materials */
static nqm_model *trained;
static nqm_train_report report;

static nqm_train_options quick(const char *recipe) {
    nqm_train_options o;
    assert_int_equal(nqm_train_options_recipe(recipe, &o, NULL), NQM_OK);
    o.network.n_hidden = 2;
    o.network.hidden[0] = 32, o.network.hidden[1] = 16;
    o.optimiser.batch = 64;
    o.optimiser.epochs = 3;
    o.optimiser.lr_first = 1e-3;
    return o;
}

static int train_once(void **state) {
    (void)state;
    toy_options toy = toy_options_default();
    toy.n_groups = 48;
    dataset = toy_dataset(&toy);
    nqm_train_options o = quick("nqm");
    return nqm_train(dataset, &o, &trained, &report, NULL) != NQM_OK;
}

static int forget(void **state) {
    (void)state;
    nqm_model_free(trained);
    nqm_dataset_free(dataset);
    return 0;
}

static size_t count_in(const char *text, const char *word) {
    size_t n = 0;
    for (const char *at = strstr(text, word); at; at = strstr(at + 1, word))
        ++n;
    return n;
}

TEST(training_calibrates) {
    assert_int_equal(report.calibration.n_materials, 12);
    assert_int_equal(report.calibration.n_pairs, report.n_validation);
    assert_true(report.calibration.coverage > 0.8 && report.calibration.coverage <= 1);
    assert_true(report.calibration.mean_width > 0);
    nqm_model_info info = nqm_model_get_info(trained);
    assert_non_null(strstr(info.calibration, "\"materials\":12"));
    assert_non_null(strstr(info.calibration, dataset->sha256));
    assert_int_equal(count_in(info.card, "## Interval"), 1);
}

TEST(materials_on_both_sides_do_not) {
    nqm_train_options o = quick("paper");
    nqm_model *model;
    nqm_train_report r;
    nqm_error err = {0};
    nqm_calibration c;
    o.optimiser.epochs = 1;
    assert_int_equal(nqm_train(dataset, &o, &model, &r, NULL), NQM_OK);
    assert_int_equal(r.calibration.n_materials, 0);
    assert_string_equal(nqm_model_get_info(model).calibration, "");
    assert_int_equal(save_calibrated(model, dataset, 0, &c, &err), NQM_ERR_INCOMPATIBLE);
    assert_non_null(strstr(err.message, "drawn over all pairs"));
    nqm_model_free(model);
}

TEST(existing_models_are_calibrated) {
    nqm_model *read;
    nqm_calibration c;
    assert_int_equal(save_calibrated(trained, dataset, 0, &c, NULL), NQM_OK);
    assert_int_equal(nqm_model_load(scratch_path("model"), &read, NULL), NQM_OK);
    assert_int_equal(read->n_interval, trained->n_interval);
    for (size_t i = 0; i < 3 * read->n_interval; ++i) /* another batch size changes the rounding of predictions */
        assert_near(read->interval[i], trained->interval[i], 1e-3);
    assert_near(c.coverage, report.calibration.coverage, 0.02);
    assert_int_equal(count_in(nqm_model_get_info(read).card, "## Interval"), 1);
    nqm_model_free(read);
}

TEST(other_datasets_are_refused) {
    toy_options toy = toy_options_default();
    toy.n_groups = 48;
    toy.pairs_per_ref = 11;
    nqm_dataset *other = toy_dataset(&toy), *small;
    nqm_calibration c;
    nqm_error err = {0};
    assert_int_equal(save_calibrated(trained, other, 0, &c, &err), NQM_ERR_INCOMPATIBLE);
    assert_non_null(strstr(err.message, "not trained on this dataset"));
    assert_int_equal(save_calibrated(trained, other, 1, &c, NULL), NQM_OK);
    assert_int_equal(c.n_pairs, 12 * 2 * 11);
    toy.n_groups = 24; /* 6 validation materials */
    small = toy_dataset(&toy);
    assert_int_equal(save_calibrated(trained, small, 1, &c, &err), NQM_ERR_INCOMPATIBLE);
    assert_non_null(strstr(err.message, "too few"));
    nqm_dataset_free(small);
    nqm_dataset_free(other);
}

TEST(cards_hold_one_section) {
    const nqm_calibration c = {100, 10, 0.951, 0.94, 0.8, 1.25, 0, 0, 0};
    char *first = nqm_card_with_interval("# Card\n", &c, "abc");
    assert_non_null(strstr(first, "95.1 %"));
    assert_non_null(strstr(first, "1.25 JOD"));
    char longer[2000];
    snprintf(longer, sizeof longer, "%s\n## Judged on\n\nnothing\n", first);
    char *second = nqm_card_with_interval(longer, &(nqm_calibration){200, 20, 0.96, 0.95, 0.9, 1, 0.5, 0, 0}, "def");
    assert_int_equal(count_in(second, "## Interval"), 1);
    assert_null(strstr(first, "novelty"));
    assert_non_null(strstr(second, "novelty"));
    assert_null(strstr(second, "95.1 %"));
    assert_non_null(strstr(second, "96 %"));
    assert_non_null(strstr(second, "\n## Judged on\n\nnothing\n"));
    assert_memory_equal(second, "# Card\n\n## Interval\n", 20);
    nqm_free(first);
    nqm_free(second);
}

/* ---- the count --------------------------------------------------------------------------------------------------- */

TEST(labels_inside_are_counted) {
    const nqm_model *model = trained;
    nqm_eval_options o = nqm_eval_options_default();
    nqm_evaluation *ev;
    nqm_coverage c, again;
    o.split = NQM_SPLIT_TEST;
    o.n_bootstrap = 100;
    assert_int_equal(nqm_evaluation_create(dataset, 1, &model, NULL, &o, &ev, NULL), NQM_OK);
    assert_int_equal(nqm_evaluation_coverage(ev, &o, 0, &c, NULL), NQM_OK);
    const double *jod = nqm_evaluation_values(ev, 0);
    size_t n = 0, n_inside = 0, n_high = 0, n_ranges = 0;
    double width = 0;
    nqm_prediction *predicted = nqm_alloc(dataset->n_pairs, sizeof *predicted);
    size_t *every_pair = nqm_alloc(dataset->n_pairs, sizeof *every_pair);
    assert_true(predicted && every_pair);
    for (size_t i = 0; i < dataset->n_pairs; ++i)
        every_pair[i] = i;
    const nqm_dataset_prediction prediction = {
        .model = model, .dataset = dataset, .n = dataset->n_pairs, .pairs = every_pair, .to = predicted};
    assert_int_equal(nqm_dataset_predict(&prediction, NULL), NQM_OK);
    for (size_t i = 0; i < dataset->n_pairs; ++i) {
        if (nqm_dataset_pair_split(dataset, i) != NQM_SPLIT_TEST)
            continue;
        double low, high;
        const double novelty = predicted[i].novelty;
        assert_near(novelty, nqm_model_novelty(model, ev->scalars + i * NQM_SCALAR_COUNT), 1e-3 * (1 + novelty));
        nqm_bounded_interval(model, &predicted[i], &low, &high);
        n_inside += dataset->jod[i] >= low && dataset->jod[i] <= high;
        n_high += jod[i] >= 9.9;
        width += high - low;
        ++n;
    }
    for (size_t i = 0; i < NQM_COVERAGE_RANGES; ++i)
        n_ranges += c.ranges[i].n;
    assert_int_equal(c.n, n);
    assert_int_equal(n_ranges, n);
    assert_int_equal(c.ranges[NQM_COVERAGE_RANGES - 1].n, n_high);
    assert_int_equal(c.n_materials, 12);
    assert_near(c.inside.value, (double)n_inside / (double)n, 1e-12);
    assert_near(c.by_material.value, c.inside.value, 1e-12); /* every material has the same number of pairs */
    assert_near(c.inside.value + c.below + c.above, 1, 1e-12);
    assert_near(c.mean_width, width / (double)n, 1e-12);
    nqm_free(predicted);
    nqm_free(every_pair);
    assert_true(c.inside.value > 0.7 && c.lowest <= c.inside.value && c.lowest_material != NULL);
    assert_true(c.inside.ci95[0] <= c.inside.value && c.inside.value <= c.inside.ci95[1]);
    assert_true(c.ranges[4].from == 9.9);
    o.jod_from = 9;
    o.n_bootstrap = 0;
    assert_int_equal(nqm_evaluation_coverage(ev, &o, 0, &again, NULL), NQM_OK);
    assert_true(again.n < n && isnan(again.inside.ci95[0]));
    assert_int_equal(nqm_evaluation_coverage(ev, &o, 1, &again, NULL), NQM_ERR_ARG); /* a metric */
    o.jod_from = 0;
    o.subset = "near";
    assert_int_equal(nqm_evaluation_coverage(ev, &o, 0, &again, NULL), NQM_OK);
    assert_true(again.n == c.n && again.inside.value == c.inside.value);
    o.subset = "far";
    assert_int_equal(nqm_evaluation_coverage(ev, &o, 0, &again, NULL), NQM_ERR_INCOMPATIBLE);
    nqm_evaluation_free(ev);
}

TEST_FILE(train_once, forget)
