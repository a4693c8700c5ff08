/* SPDX-License-Identifier: MIT
 *
 * The novelty of a pair with respect to a model: the stored training points, the measure, its file, and its effect on
 * scores and intervals.
 */
#include "io/io.h"
#include "judge/judge.h"
#include "metric/metric.h"
#include "support/check.h"
#include "support/predict.h"
#include "support/scratch.h"
#include "support/toy_dataset.h"
#include "support/training.h"
#include "train/train.h"

static nqm_dataset *dataset; /* 24 training materials, 12 validation materials */
static nqm_model *trained;

static nqm_train_options quick(const char *recipe) {
    nqm_train_options o;
    assert_int_equal(nqm_train_options_recipe(recipe, &o, NULL), NQM_OK);
    o.network.n_hidden = 1;
    o.network.hidden[0] = 16;
    o.optimiser.batch = 64;
    o.optimiser.epochs = 2;
    return o;
}

static nqm_dataset *some_pairs(size_t pairs_per_ref) {
    toy_options toy = toy_options_default();
    toy.n_groups = 48;
    toy.pairs_per_ref = pairs_per_ref;
    return toy_dataset(&toy);
}

static int begin(void **state) {
    (void)state;
    dataset = some_pairs(12);
    nqm_train_options o = quick("nqm");
    /* saving predicts, so copies share the data that the first prediction creates */
    return nqm_train(dataset, &o, &trained, NULL, NULL) != NQM_OK ||
           nqm_model_save(trained, scratch_path("model"), NULL) != NQM_OK;
}

static int end(void **state) {
    (void)state;
    nqm_model_free(trained);
    nqm_dataset_free(dataset);
    return 0;
}

static void scalars_of(size_t pair, double *scalars) {
    uint8_t *scratch = malloc(dataset->n_directions);
    const nqm_sample_pair samples = nqm_dataset_samples(dataset, pair, scratch);
    compute_scalars(dataset->directions, NULL, samples.ref, samples.test, samples.used, scalars);
    free(scratch);
}

static double novelty_of(const nqm_model *model, size_t pair) {
    double scalars[NQM_SCALAR_COUNT];
    scalars_of(pair, scalars);
    return nqm_model_novelty(model, scalars);
}

/* Whitened and mapped features of a pair, in double. */
static void features(const nqm_model *m, size_t pair, double *y) {
    double x[NQM_SCALAR_COUNT];
    scalars_of(pair, x);
    for (size_t i = 0; i < NQM_SCALAR_COUNT; ++i)
        y[i] = 0;
    for (size_t k = 0; k < NQM_SCALAR_COUNT; ++k) {
        double z = fmin(5, fmax(-5, (x[k] - (double)m->scalars.mean[k]) / (double)m->scalars.std[k]));
        for (size_t i = 0; i < NQM_SCALAR_COUNT; ++i)
            y[i] += z * (double)m->novelty_map[k * NQM_SCALAR_COUNT + i];
    }
}

static double point(const nqm_model *m, size_t p, size_t k) {
    return (double)
        m->novelty_points[(p / NQM_NOVELTY_BLOCK * NQM_SCALAR_COUNT + k) * NQM_NOVELTY_BLOCK + p % NQM_NOVELTY_BLOCK];
}

static double distance(const nqm_model *m, size_t p, const double *x) {
    double sum = 0;
    for (size_t k = 0; k < NQM_SCALAR_COUNT; ++k)
        sum += pow(point(m, p, k) - x[k], 2);
    return sqrt(sum);
}

/* ---- points and measure ------------------------------------------------------------------------------------------ */

/* Over the training pairs the features are uncorrelated and have variance 1, unless their variance is negligible. */
TEST(features_are_uncorrelated) {
    enum { N = NQM_SCALAR_COUNT };
    double mean[N] = {0}, product[N * N] = {0}, n = 24 * 2 * 12;
    for (int pass = 0; pass < 2; ++pass)
        for (size_t pair = 0; pair < dataset->n_pairs; ++pair) {
            if (nqm_dataset_pair_split(dataset, pair) != NQM_SPLIT_TRAIN)
                continue;
            double y[N];
            features(trained, pair, y);
            for (size_t k = 0; k < N; ++k) {
                if (pass == 0)
                    mean[k] += y[k] / n;
                for (size_t l = 0; pass == 1 && l < N; ++l)
                    product[k * N + l] += (y[k] - mean[k]) * (y[l] - mean[l]) / n;
            }
        }
    for (size_t k = 0; k < N; ++k)
        for (size_t l = 0; l < N; ++l)
            if (k != l)
                assert_near(product[k * N + l], 0, 1e-3);
    /* The map divides by sqrt(variance + least), so that 1 / its square length - variance of the feature / it is the least. */
    for (size_t k = 0; k < N; ++k) {
        double square = 0;
        for (size_t i = 0; i < N; ++i)
            square += pow((double)trained->novelty_map[i * N + k], 2);
        assert_near((1 - product[k * N + k]) / square, 0.01, 1e-4);
    }
    assert_true(product[0] > 0.99 && product[0] < 1);                    /* the strongest feature */
    assert_true(product[N * N - 1] < 0.5 && product[(N + 1) * 3] > 0.9); /* the weakest, and the fourth */
}

/* Farthest-point order: no training pair is farther from the first n points than point n + 1 is. */
TEST(points_are_far_apart) {
    size_t n_points = trained->n_novelty * NQM_NOVELTY_BLOCK, n_train = 0;
    assert_int_equal(n_points, 24 * 2 * 12 / NQM_NOVELTY_BLOCK * NQM_NOVELTY_BLOCK);
    const size_t upto[] = {1, 10, 100};
    for (size_t i = 0; i < sizeof upto / sizeof *upto; ++i) {
        double next[NQM_SCALAR_COUNT], next_distance = INFINITY;
        for (size_t k = 0; k < NQM_SCALAR_COUNT; ++k)
            next[k] = point(trained, upto[i], k);
        for (size_t p = 0; p < upto[i]; ++p)
            next_distance = fmin(next_distance, distance(trained, p, next));
        for (size_t pair = 0; pair < dataset->n_pairs; ++pair) {
            if (nqm_dataset_pair_split(dataset, pair) != NQM_SPLIT_TRAIN)
                continue;
            double x[NQM_SCALAR_COUNT], nearest = INFINITY;
            features(trained, pair, x);
            for (size_t p = 0; p < upto[i]; ++p)
                nearest = fmin(nearest, distance(trained, p, x));
            assert_true(nearest <= next_distance + 1e-4);
            n_train += i == 0;
        }
    }
    assert_int_equal(n_train, 24 * 2 * 12);
}

TEST(training_pairs_are_not_novel) {
    size_t n = 0, n_beyond = 0;
    for (size_t pair = 0; pair < dataset->n_pairs; ++pair) {
        double novelty = novelty_of(trained, pair), x[NQM_SCALAR_COUNT], nearest = INFINITY;
        features(trained, pair, x);
        for (size_t p = 0; p < trained->n_novelty * NQM_NOVELTY_BLOCK; ++p)
            nearest = fmin(nearest, distance(trained, p, x));
        assert_near(novelty, nearest / trained->novelty_unit, 1e-4);
        if (nqm_dataset_pair_split(dataset, pair) == NQM_SPLIT_TRAIN) /* there are at most as many as points */
            assert_near(novelty, 0, 1e-4);
        if (nqm_dataset_pair_split(dataset, pair) != NQM_SPLIT_VALIDATION)
            continue;
        ++n;
        n_beyond += novelty > 1;
    }
    assert_near((double)n_beyond / (double)n, 0.05, 0.01);
}

TEST(models_of_samples_have_none) {
    nqm_train_options o = quick("paper");
    nqm_model *model;
    nqm_train_report r;
    o.split.by_pair = 0;
    o.optimiser.epochs = 1;
    assert_int_equal(nqm_train(dataset, &o, &model, &r, NULL), NQM_OK);
    assert_int_equal(model->n_novelty, 0);
    assert_true(model->interval != NULL && r.calibration.novelty_growth == 0);
    assert_true(isnan(novelty_of(model, 0)));
    double low, high, low_far, high_far;
    nqm_model_interval(model, 8, 0, 0, &low, &high);
    nqm_model_interval(model, 8, 100, 0, &low_far, &high_far);
    assert_true(low == low_far && high == high_far);
    nqm_model_free(model);
}

/* ---- the file ---------------------------------------------------------------------------------------------------- */

TEST(files_hold_the_measure) {
    nqm_model *read;
    assert_int_equal(nqm_model_save(trained, scratch_path("model"), NULL), NQM_OK);
    assert_int_equal(nqm_model_load(scratch_path("model"), &read, NULL), NQM_OK);
    assert_true(read->novelty_unit == trained->novelty_unit && read->novelty_growth == trained->novelty_growth);
    for (size_t pair = 0; pair < dataset->n_pairs; pair += 7)
        assert_true(novelty_of(read, pair) == novelty_of(trained, pair));
    nqm_model_free(read);
}

TEST(older_files_have_none) {
    nqm_model *read;
    struct nqm_model older = *trained;
    older.n_novelty = 0;
    assert_int_equal(nqm_model_save(&older, scratch_path("model"), NULL), NQM_OK);
    assert_int_equal(nqm_model_load(scratch_path("model"), &read, NULL), NQM_OK);
    assert_true(isnan(novelty_of(read, 0)));
    double low, high, low_at, high_at;
    nqm_model_interval(read, 8, 3, 0, &low, &high);
    nqm_interval_at(read->n_interval, read->interval, 8, &low_at, &high_at);
    assert_true(low == low_at && high == high_at);
    nqm_model_free(read);
}

TEST(broken_measures_are_refused) {
    const double scales[][2] = {{0, 1}, {-1, 1}, {NAN, 1}, {1, -0.1}, {1, NQM_NOVELTY_MAX_GROWTH + 1.0}, {1, NAN}};
    for (size_t i = 0; i < sizeof scales / sizeof *scales + 2; ++i) {
        nqm_model *read = NULL;
        nqm_error err = {0};
        struct nqm_model broken = *trained;
        float *points = NULL;
        if (i < sizeof scales / sizeof *scales) {
            broken.novelty_unit = scales[i][0], broken.novelty_growth = scales[i][1];
        } else if (i == sizeof scales / sizeof *scales) {
            broken.interval = NULL; /* novelty without an interval */
        } else {
            points = calloc(trained->n_novelty, NQM_SCALAR_COUNT * NQM_NOVELTY_BLOCK * sizeof *points);
            points[5] = INFINITY;
            broken.novelty_points = points;
        }
        assert_int_equal(nqm_model_save(&broken, scratch_path("model"), NULL), NQM_OK);
        assert_int_equal(nqm_model_load(scratch_path("model"), &read, &err), NQM_ERR_MODEL);
        assert_non_null(strstr(err.message, "novelty."));
        free(points);
    }
}

/* Growths and least widths are kept by files, and are not negative. */
TEST(features_of_errors_in_files) {
    struct nqm_model changed = *trained;
    nqm_model *read;
    changed.spread_growth[NQM_SPREAD_PEAK] = 0.5;
    changed.interval_floor[3] = 0.25;
    assert_int_equal(nqm_model_save(&changed, scratch_path("model"), NULL), NQM_OK);
    assert_int_equal(nqm_model_load(scratch_path("model"), &read, NULL), NQM_OK);
    assert_memory_equal(read->spread_growth, changed.spread_growth, sizeof changed.spread_growth);
    assert_memory_equal(read->interval_floor, changed.interval_floor, sizeof changed.interval_floor);
    nqm_model_free(read);
    memset(changed.spread_growth, 0, sizeof changed.spread_growth);
    memset(changed.interval_floor, 0, sizeof changed.interval_floor); /* a file of an earlier version */
    assert_int_equal(nqm_model_save(&changed, scratch_path("model"), NULL), NQM_OK);
    assert_int_equal(nqm_model_load(scratch_path("model"), &read, NULL), NQM_OK);
    assert_false(nqm_model_has_spread(read));
    nqm_model_free(read);
    for (int which = 0; which < 3; ++which) {
        nqm_error err = {0};
        changed = *trained;
        changed.interval_floor[0] = which == 0 ? -0.1 : 0.1;
        changed.spread_growth[0] = which == 1 ? NQM_NOVELTY_MAX_GROWTH + 1 : 1;
        if (which == 2)
            changed.spread_growth[1] = NAN;
        assert_int_equal(nqm_model_save(&changed, scratch_path("model"), NULL), NQM_OK);
        assert_int_equal(nqm_model_load(scratch_path("model"), &read, &err), NQM_ERR_MODEL);
        assert_non_null(strstr(err.message, which ? "interval.spread" : "interval.floor"));
    }
}

/* ---- scores and calibration -------------------------------------------------------------------------------------- */

TEST(scores_tell_and_widen) {
    nqm_brdf *ref = must_open("sgd:nickel"), *test = must_open("ward:nickel"),
             *odd = must_open("lambert:kd=0.9,0.1,0.9");
    const nqm_brdf *tests[] = {ref, test, odd};
    struct nqm_model model = *trained;
    nqm_score_result r[3], alone;
    model.novelty_growth = 1;
    memset(model.spread_growth, 0, sizeof model.spread_growth);
    memset(model.interval_floor, 0, sizeof model.interval_floor);
    assert_int_equal(nqm_score(&model, ref, 3, tests, NULL, r, NULL), NQM_OK);
    assert_int_equal(nqm_score(&model, ref, 1, tests + 2, NULL, &alone, NULL), NQM_OK);
    assert_true(alone.novelty == r[2].novelty && r[2].novelty > 0);
    assert_true(r[0].jod_low == 10 && r[0].jod_high == 10);
    double low, high, low_near, high_near;
    for (size_t i = 1; i < 3; ++i) {
        nqm_model_interval(&model, r[i].jod, r[i].novelty, 0, &low, &high);
        nqm_model_interval(&model, r[i].jod, 0, 0, &low_near, &high_near);
        assert_true(r[i].jod_low == low && r[i].jod_high == high);
        assert_true(low < low_near && high > high_near);
        /* The ends are exp(novelty) times as far away on the logit scale (growth is 1). */
        double times = exp(r[i].novelty), y = nqm_interval_y(r[i].jod);
        assert_near(low, nqm_interval_jod(y + times * (nqm_interval_y(low_near) - y)), 1e-9);
        assert_near(high, nqm_interval_jod(y + times * (nqm_interval_y(high_near) - y)), 1e-9);
    }
    nqm_brdf_free(ref);
    nqm_brdf_free(test);
    nqm_brdf_free(odd);
}

TEST(calibrating_again_keeps_the_points) {
    nqm_model *again, *elsewhere;
    nqm_calibration c;
    nqm_dataset *other = some_pairs(11);
    const size_t n_bytes = trained->n_novelty * NQM_SCALAR_COUNT * NQM_NOVELTY_BLOCK * sizeof(float);
    assert_int_equal(save_calibrated(trained, dataset, 0, &c, NULL), NQM_OK);
    assert_int_equal(nqm_model_load(scratch_path("model"), &again, NULL), NQM_OK);
    assert_int_equal(save_calibrated(trained, other, 1, &c, NULL), NQM_OK); /* not trained on it */
    assert_int_equal(nqm_model_load(scratch_path("model"), &elsewhere, NULL), NQM_OK);
    assert_int_equal(again->n_novelty, trained->n_novelty);
    assert_int_equal(elsewhere->n_novelty, trained->n_novelty);
    assert_memory_equal(again->novelty_points, trained->novelty_points, n_bytes);
    assert_memory_equal(elsewhere->novelty_points, trained->novelty_points, n_bytes);
    assert_true(again->novelty_unit == trained->novelty_unit);
    assert_true(elsewhere->novelty_unit != trained->novelty_unit);
    nqm_model_free(again);
    nqm_model_free(elsewhere);
    nqm_dataset_free(other);
}

TEST_FILE(begin, end)
