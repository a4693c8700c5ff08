/* SPDX-License-Identifier: MIT
 *
 * Training: the loss on a learnable problem, equal bits in repeated runs, with other threads and after resuming,
 * refusal of checkpoints of other runs, cancellation, and detection of divergence.
 */
#include "support/allocations.h"
#include "support/check.h"
#include "support/predict.h"
#include "support/toy_dataset.h"
#include "support/training.h"

#include <omp.h>

static const char checkpoint[] = "test_train_loop.checkpoint", model_path[] = "test_train_loop.model";

static nqm_dataset *toy;

static int make_toy(void **state) {
    (void)state;
    toy_options o = toy_options_default();
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

/* A network with two hidden layers. */
static nqm_train_options small(const char *recipe) {
    nqm_train_options o = small_recipe(recipe, 48, 4);
    o.network.n_hidden = 2;
    o.network.hidden[1] = 24;
    return o;
}

/* The content of a model's file; free with free(). */
static unsigned char *model_bytes(const nqm_model *model, size_t *n_ret) {
    nqm_map map;
    assert_int_equal(nqm_model_save(model, model_path, NULL), NQM_OK);
    assert_int_equal(nqm_map_open(model_path, &map, NULL), NQM_OK);
    unsigned char *bytes = malloc(map.n_bytes);
    assert_non_null(bytes);
    memcpy(bytes, map.data, map.n_bytes);
    *n_ret = map.n_bytes;
    nqm_map_close(&map);
    return bytes;
}

static void assert_same_model(const nqm_model *a, const nqm_model *b) {
    size_t n_a, n_b;
    unsigned char *bytes_a = model_bytes(a, &n_a), *bytes_b = model_bytes(b, &n_b);
    assert_int_equal(n_a, n_b);
    assert_memory_equal(bytes_a, bytes_b, n_a);
    free(bytes_a);
    free(bytes_b);
}

/* On unseen materials the loss is much smaller than that of predicting the mean, a log-cosh of about 0.37. */
TEST(learns) {
    const char *const recipes[] = {"paper", "notebook", "nqm"};
    for (size_t i = 0; i < 3; ++i) {
        nqm_train_options o = small(recipes[i]);
        o.optimiser.epochs = 40;
        o.network.dropout = 0.05;
        o.split.by_pair = 0;
        nqm_train_report report;
        nqm_model *model = train_model(toy, &o, &report);
        assert_int_equal(report.epochs, 40);
        assert_int_equal(report.n_steps, 40 * ((report.n_train + 31) / 32));
        assert_true(report.validation_loss < (i == 2 ? 0.05 : 0.15));
        assert_true(report.validation_spearman > (i == 2 ? 0.95 : 0.85));
        nqm_model_info info = nqm_model_get_info(model);
        assert_string_equal(info.recipe, recipes[i]);
        assert_int_equal(info.n_layers, 3);
        assert_string_equal(info.manifest_sha256, toy->sha256);
        assert_non_null(strstr(info.card, "## Not good for"));
        nqm_model_free(model);
    }
}

TEST(unknown_precision) {
    nqm_train_options o = small("paper");
    nqm_model *model;
    o.optimiser.precision = NQM_PRECISION_COUNT;
    assert_int_equal(nqm_train(toy, &o, &model, NULL, NULL), NQM_ERR_ARG);
}

/* A saved and loaded model gives the same predictions; with our recipe, equal BRDFs score at the top of the range. */
TEST(saved_and_loaded) {
    nqm_train_options o = small("nqm");
    o.optimiser.epochs = 20;
    o.card = "Made by a test.";
    nqm_model *model = train_model(toy, &o, NULL), *loaded;
    assert_int_equal(nqm_model_save(model, model_path, NULL), NQM_OK);
    assert_int_equal(nqm_model_load(model_path, &loaded, NULL), NQM_OK);
    assert_int_equal(strlen(nqm_model_get_info(loaded).sha256), 64);
    assert_non_null(strstr(nqm_model_get_info(loaded).card, "Made by a test."));
    double a[2], b[2];
    float pairs[2][2][48];
    memcpy(pairs[0][0], toy->ref_rgb, sizeof pairs[0][0]);
    memcpy(pairs[0][1], toy->ref_rgb + 48, sizeof pairs[0][1]);
    memcpy(pairs[1][0], toy->test_rgb, sizeof pairs[1][0]);
    memcpy(pairs[1][1], toy->ref_rgb + 48, sizeof pairs[1][1]);
    predict_jod(model, 2, pairs[0][0], pairs[1][0], a);
    predict_jod(loaded, 2, pairs[0][0], pairs[1][0], b);
    assert_memory_equal(a, b, sizeof a);
    assert_true(a[1] > 9.9);
    nqm_model_free(model);
    nqm_model_free(loaded);
}

TEST(repeats_itself_on_any_threads) {
    const char *const recipes[] = {"notebook", "nqm"};
    for (size_t i = 0; i < 2; ++i) {
        nqm_train_options o = small(recipes[i]);
        o.network.n_hidden = 1;
        o.network.hidden[0] = 512; /* large enough for more than one thread */
        o.optimiser.batch = 256;
        o.optimiser.epochs = 1;
        nqm_model *one = train_model(toy, &o, NULL);
        omp_set_num_threads(2);
        nqm_model *two = train_model(toy, &o, NULL);
        omp_set_num_threads(1);
        assert_same_model(one, two);
        o.optimiser.seed = 2;
        nqm_model *other = train_model(toy, &o, NULL);
        assert_true(memcmp(one->params.block, other->params.block, one->params.n * sizeof(float)) != 0);
        nqm_model_free(one);
        nqm_model_free(two);
        nqm_model_free(other);
    }
}

/* ---- checkpoints ------------------------------------------------------------------------------------------------- */

typedef struct losses {
    size_t n;
    double value[32][3];
} losses;

static void note_losses(void *user, size_t epoch, double train_loss, double validation_loss, double lr_first) {
    losses *l = user;
    assert_int_equal(epoch, l->n + 1);
    const double value[3] = {train_loss, validation_loss, lr_first};
    memcpy(l->value[l->n++], value, sizeof value);
}

/* Stops at the n-th call. */
static int stop_at(void *user, const char *stage, double done, double total) {
    int *calls_left = user;
    assert_string_equal(stage, "train");
    assert_true(done > 0 && done <= total && total <= 60); /* epochs, not steps */
    return --*calls_left <= 0;
}

static void stop_during(nqm_train_options *o) {
    nqm_model *model;
    nqm_error err = {0};
    int calls_left = 2; /* calls are limited in rate: the second is made in the last step at the latest */
    o->run.progress = stop_at;
    o->run.progress_user = &calls_left;
    assert_int_equal(nqm_train(toy, o, &model, NULL, &err), NQM_ERR_CANCELLED);
    assert_null(model);
    o->run.progress = NULL;
}

TEST(resumes_to_the_same_bits) {
    const char *const recipes[] = {"paper", "notebook", "nqm"};
    for (size_t i = 0; i < 3; ++i) {
        nqm_train_options o = small(recipes[i]);
        losses whole = {0}, parts = {0};
        o.optimiser.epochs = 9;
        o.optimiser.schedule = NQM_SCHEDULE_PLATEAU;
        o.optimiser.plateau_patience = 0; /* so that the schedule reduces the rate within a few epochs */
        o.optimiser.lr_deeper = 0.02;
        o.run.epoch_done = note_losses;
        o.run.epoch_user = &whole;
        nqm_train_report a, b;
        nqm_model *uninterrupted = train_model(toy, &o, &a);
        o.run.checkpoint = checkpoint;
        o.run.epoch_done = NULL;
        o.optimiser.epochs = 3;
        nqm_model_free(train_model(toy, &o, NULL));
        o.run.resume = 1;
        o.optimiser.epochs = 5;
        nqm_model_free(train_model(toy, &o, NULL));
        o.optimiser.epochs = 9;
        o.run.epoch_done = note_losses;
        o.run.epoch_user = &parts;
        nqm_model *resumed = train_model(toy, &o, &b);
        assert_same_model(uninterrupted, resumed);
        assert_int_equal(b.epochs_resumed, 5);
        assert_int_equal(a.n_steps, b.n_steps);
        assert_int_equal(parts.n, 9);
        assert_memory_equal(&whole, &parts, sizeof whole);
        assert_true(whole.value[8][2] < whole.value[0][2]);
        nqm_model_free(resumed);
        parts.n = 0;
        resumed = train_model(toy, &o, NULL); /* training is complete: returns the model without an epoch */
        assert_same_model(uninterrupted, resumed);
        nqm_model_free(uninterrupted);
        nqm_model_free(resumed);
    }
}

static void refuse(const nqm_dataset *d, const nqm_train_options *o, nqm_status status, const char *words) {
    nqm_model *model;
    nqm_error err = {0};
    assert_int_equal(nqm_train(d, o, &model, NULL, &err), status);
    assert_null(model);
    if (!strstr(err.message, words))
        fail_msg("'%s' is not in '%s'", words, err.message);
}

/* The rate follows half a cosine; a resumed run continues it and must have the same number of epochs. */
TEST(cosine_schedule) {
    nqm_train_options o = small("nqm");
    losses l = {0};
    o.optimiser.schedule = NQM_SCHEDULE_COSINE;
    o.optimiser.epochs = 6;
    o.run.checkpoint = checkpoint;
    o.run.epoch_done = note_losses;
    o.run.epoch_user = &l;
    unlink(checkpoint);
    nqm_model *model = train_model(toy, &o, NULL);
    const double expected[6] = {1, (2 + sqrt(3)) / 4, 0.75, 0.5, 0.25, (2 - sqrt(3)) / 4};
    assert_int_equal(l.n, 6);
    for (size_t i = 0; i < 6; ++i)
        assert_near(l.value[i][2], o.optimiser.lr_first * expected[i], 1e-15);
    l.n = 0;
    o.run.resume = 1;
    nqm_model *resumed = train_model(toy, &o, NULL);
    assert_same_model(model, resumed);
    o.optimiser.epochs = 9;
    refuse(toy, &o, NQM_ERR_INCOMPATIBLE, "epochs 6, not 9");
    nqm_model_free(model);
    nqm_model_free(resumed);
}

TEST(stopped_and_resumed) {
    nqm_train_options o = small("nqm");
    o.optimiser.epochs = 60; /* about a second: the ticker calls more than once */
    nqm_model *uninterrupted = train_model(toy, &o, NULL);
    unlink(checkpoint);
    o.run.checkpoint = checkpoint;
    stop_during(&o);
    o.run.resume = access(checkpoint, F_OK) == 0;
    nqm_model *resumed = train_model(toy, &o, NULL);
    assert_same_model(uninterrupted, resumed);
    nqm_model_free(uninterrupted);
    nqm_model_free(resumed);
}

/* Write the checkpoint anew as one of another version of nqm. */
static void change_version(void) {
    enum { MAX_TENSORS = 16 };
    nqm_map map;
    nqm_safetensors *st;
    nqm_tensor tensors[MAX_TENSORS];
    assert_int_equal(nqm_map_open(checkpoint, &map, NULL), NQM_OK);
    assert_int_equal(nqm_safetensors_parse(map.data, map.n_bytes, checkpoint, &st, NULL), NQM_OK);
    const size_t n = nqm_safetensors_count(st);
    assert_in_range(n, 1, MAX_TENSORS);
    for (size_t i = 0; i < n; ++i)
        tensors[i] = *nqm_safetensors_at(st, i);
    static const char *const keys[] = {"format", "schema", "options", "dataset_sha256"};
    nqm_meta meta[5] = {[4] = {"version", "0.0.9"}};
    for (size_t i = 0; i < 4; ++i)
        meta[i] = (nqm_meta){keys[i], nqm_safetensors_meta(st, keys[i])};
    assert_int_equal(nqm_safetensors_write(checkpoint, n, tensors, 5, meta, NULL, NULL), NQM_OK);
    nqm_safetensors_free(st);
    nqm_map_close(&map);
}

TEST(checkpoints_of_others) {
    nqm_train_options o = small("nqm");
    o.optimiser.schedule = NQM_SCHEDULE_PLATEAU; /* only this schedule permits another number of epochs */
    o.run.checkpoint = checkpoint;
    nqm_model_free(train_model(toy, &o, NULL));
    o.run.resume = 1;
    nqm_train_options other = o;
    other.optimiser.batch = 64;
    refuse(toy, &other, NQM_ERR_INCOMPATIBLE, "batch 32, not 64");
    other = o;
    other.optimiser.seed = 7;
    refuse(toy, &other, NQM_ERR_INCOMPATIBLE, "seed");
    other = o;
    other.optimiser.epochs = 2;
    refuse(toy, &other, NQM_ERR_INCOMPATIBLE, "4 epochs");
    toy_options t = toy_options_default();
    t.seed = 9;
    nqm_dataset *another = toy_dataset(&t);
    refuse(another, &o, NQM_ERR_INCOMPATIBLE, "another dataset");
    nqm_dataset_free(another);
    other = o;
    other.run.checkpoint = "no such checkpoint";
    refuse(toy, &other, NQM_ERR_IO, "no such checkpoint");
    other.run.checkpoint = test_vector("net.safetensors");
    refuse(toy, &other, NQM_ERR_FORMAT, "no checkpoint");
    change_version();
    refuse(toy, &o, NQM_ERR_INCOMPATIBLE, "made by nqm 0.0.9");
    FILE *f = fopen(checkpoint, "r+b");
    assert_non_null(f);
    assert_int_equal(fseek(f, -100, SEEK_END), 0);
    fputc(0x55, f);
    fclose(f);
    refuse(toy, &o, NQM_ERR_FORMAT, "SHA-256");
}

/* ---- errors ------------------------------------------------------------------------------------------------------ */

TEST(divergence_is_noticed) {
    nqm_dataset broken = *toy; /* loaders would refuse it */
    double *jod = malloc(toy->n_pairs * sizeof *jod);
    assert_non_null(jod);
    float *rgb = malloc(toy->n_pairs * 48 * sizeof *rgb);
    assert_non_null(rgb);
    memcpy(rgb, toy->test_rgb, toy->n_pairs * 48 * sizeof *rgb);
    rgb[5] = NAN; /* pair 0 is a training pair */
    broken.test_rgb = rgb;
    nqm_train_options o = small("nqm");
    o.augmentation.swap = 0; /* the test would become a reference, whose moments are checked earlier */
    refuse(&broken, &o, NQM_ERR_NUMERIC, "epoch 1");
    for (size_t i = 0; i < toy->n_pairs; ++i)
        jod[i] = 5;
    broken = *toy;
    broken.jod = jod;
    o.labels.target = NQM_TARGET_JOD;
    o.input.transport = 0;
    refuse(&broken, &o, NQM_ERR_INCOMPATIBLE, "labels do not differ");
    free(jod);
    free(rgb);
}

TEST(memory_runs_out) {
    nqm_train_options o = small("nqm");
    o.optimiser.epochs = 1;
    o.optimiser.batch = 512;
    nqm_status status = NQM_OK;
    long n = -1;
    EVERY_ALLOCATION(n, status, 0) {
        nqm_model *model;
        status = nqm_train(toy, &o, &model, NULL, NULL);
        assert_true((status == NQM_OK) == (model != NULL));
        nqm_model_free(model);
    }
    assert_true(n > 20);
}

TEST_FILE(make_toy, drop_toy)
