/* SPDX-License-Identifier: MIT
 *
 * Weights from answers of people: those of a made-up study are found, random answers gain nothing, and a file stores them.
 */
#include "base/base.h"
#include "judge/judge.h"
#include "metric/metric.h"
#include "support/check.h"

enum { REFS = 23, TESTS = 12, ROWS = 25 }; /* 22 different ones for each reference: 506 answers */

static nqm_model *model;
static nqm_human *human;
static nqm_prediction predicted[REFS * TESTS];

static double uniform(nqm_rng *rng, double from, double to) {
    return from + (to - from) * nqm_rng_uniform(rng);
}

static void print_spec(FILE *file, nqm_rng *rng) {
    double x[4];
    for (int k = 0; k < 4; ++k)
        x[k] = uniform(rng, 0.02, 0.6);
    fprintf(file, "\"ggx:kd=%.3f,%.3f,%.3f;alpha=%.3f;f0=%.3f\"", x[0], x[1], x[2], x[3], uniform(rng, 0.02, 0.2));
}

static int make_study(void **state) {
    (void)state;
    char path[] = "readout-XXXXXX.csv";
    nqm_rng rng = nqm_rng_make(5, 0);
    FILE *file = fopen(path, "w");
    char *specs[REFS + TESTS];
    for (size_t i = 0; i < REFS + TESTS; ++i) {
        size_t n;
        FILE *text = open_memstream(&specs[i], &n);
        print_spec(text, &rng);
        fclose(text);
    }
    fputs("reference,test_a,test_b,n_a,n_b\n", file);
    for (size_t r = 0; r < REFS; ++r)
        for (size_t i = 0; i < ROWS; ++i) {
            const size_t a = (i + r) % TESTS, b = (a + 1 + (i + i / TESTS) % (TESTS - 1)) % TESTS;
            fprintf(file, "%s,%s,%s,1,1\n", specs[r], specs[REFS + a], specs[REFS + b]);
        }
    fclose(file);
    for (size_t i = 0; i < REFS + TESTS; ++i)
        free(specs[i]);
    assert_int_equal(nqm_model_builtin("transport", &model, NULL), NQM_OK);
    const nqm_human_options o = {.directions = model->directions};
    assert_int_equal(nqm_human_load(path, &o, &human, NULL), NQM_OK);
    remove(path);
    size_t pairs[REFS * TESTS];
    assert_true(human->dataset->n_pairs <= REFS * TESTS);
    for (size_t i = 0; i < human->dataset->n_pairs; ++i)
        pairs[i] = i;
    const nqm_dataset_prediction p = {
        .dataset = human->dataset, .model = model, .n = human->dataset->n_pairs, .pairs = pairs, .to = predicted};
    assert_int_equal(nqm_dataset_predict(&p, NULL), NQM_OK);
    return 0;
}

static int free_study(void **state) {
    (void)state;
    nqm_human_free(human);
    nqm_model_free(model);
    return 0;
}

/* One answer to each triplet, by these weights. */
static void answer(const double *weight, uint64_t seed) {
    nqm_rng rng = nqm_rng_make(seed, 0);
    for (size_t i = 0; i < human->n_triplets; ++i) {
        nqm_triplet *t = &human->triplets[i];
        double z = 0;
        for (size_t k = 0; k < NQM_APART; ++k)
            z += weight[k] * (predicted[t->b].apart[k] - predicted[t->a].apart[k]);
        t->n_a = nqm_rng_uniform(&rng) < 1 / (1 + exp(-z));
        t->n_b = 1 - t->n_a;
    }
}

static nqm_readout fitted(size_t n_bootstrap) {
    nqm_readout readout;
    nqm_eval_options o = nqm_eval_options_default();
    o.n_bootstrap = n_bootstrap;
    assert_int_equal(nqm_human_fit_readout(human, model, &o, &readout, NULL), NQM_OK);
    return readout;
}

TEST(known_weights_are_found) {
    const double weight[NQM_APART] = {[NQM_APART_BRIGHTNESS] = 0.05,
                                      [NQM_APART_COLOUR] = 0.03,
                                      [NQM_APART_CONTRAST] = 0.15,
                                      [NQM_APART_STRUCTURE] = 0.1};
    answer(weight, 2);
    const nqm_readout r = fitted(100);
    for (size_t k = 0; k < NQM_APART; ++k)
        assert_true(r.ci95[k][0] <= weight[k] && weight[k] <= r.ci95[k][1]);
    assert_true(r.gain.ci95[0] > 0 && r.half_width > 0 && r.half_width < 1);
    assert_int_equal(r.n_materials, REFS);
}

TEST(random_answers_gain_nothing) {
    const double weight[NQM_APART] = {0};
    for (uint64_t seed = 1; seed <= 20; ++seed) {
        answer(weight, seed);
        const nqm_readout r = fitted(40);
        assert_true(r.gain.ci95[0] <= 0);
    }
}

TEST(models_store_them) {
    nqm_model *copy, *read;
    assert_int_equal(nqm_model_copy(model, &copy, NULL), NQM_OK);
    const double similarity[NQM_APART + 1] = {1, 0, 0.5, 0, 2, 0, 0.2};
    memcpy(copy->similarity, similarity, sizeof similarity);
    assert_int_equal(nqm_model_save(copy, "readout.safetensors", NULL), NQM_OK);
    assert_int_equal(nqm_model_load("readout.safetensors", &read, NULL), NQM_OK);
    assert_memory_equal(read->similarity, similarity, sizeof similarity);
    nqm_model_free(read);
    copy->similarity[1] = -1;
    assert_int_equal(nqm_model_save(copy, "readout.safetensors", NULL), NQM_OK);
    assert_int_equal(nqm_model_load("readout.safetensors", &read, NULL), NQM_ERR_MODEL);
    remove("readout.safetensors");
    nqm_model_free(copy);
}

TEST_FILE(make_study, free_study)
