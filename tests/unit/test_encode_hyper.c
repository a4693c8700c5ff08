/* SPDX-License-Identifier: MIT
 *
 * The encodings hyper-*: more samples and a finer latent vector give a better network, and the number of threads does
 * not change the bits. Their learning reduces the loss, is determined by its seed, can be stopped, and fails for a BRDF
 * without values.
 */
#include "brdf/brdf.h"
#include "encode/hyper.h"
#include "encode/nbrdf_net.h"
#include "support/check.h"
#include "support/temp_file.h"

#include <math.h>
#include <nqm/fit.h>
#include <omp.h>
#include <string.h>

/* ---- encoding ---------------------------------------------------------------------------------------------------- */

static double loss_of(const nqm_brdf *ref, const char *model) {
    nqm_fit_report report;
    nqm_error err = {0};
    if (nqm_fit(ref, model, NULL, &report, NULL, &err) != NQM_OK)
        fail_msg("%s: %s", model, err.message);
    assert_string_equal(report.spec, "");
    assert_int_equal(report.n_numbers, NQM_NBRDF_WEIGHTS);
    return report.loss;
}

/* The losses are compared by their geometric means, so that the brightest material does not dominate. */
static void losses_of(const char *const models[3], double log_loss[3]) {
    static const char *const materials[] = {"sgd:pink-fabric",
                                            "sgd:maroon-plastic",
                                            "sgd:yellow-paint",
                                            "sgd:teflon",
                                            "ggx:kd=0.3,0.1,0.05;alpha=0.25",
                                            "ward:kd=0.1,0.2,0.3;ks=0.1;alpha=0.15"};
    enum { N_MATERIALS = sizeof materials / sizeof *materials };
    for (size_t m = 0; m < 3; ++m)
        log_loss[m] = 0;
    for (size_t i = 0; i < N_MATERIALS; ++i) {
        nqm_brdf *ref = must_open(materials[i]);
        for (size_t m = 0; m < 3; ++m)
            log_loss[m] += log(loss_of(ref, models[m])) / N_MATERIALS;
        nqm_brdf_free(ref);
    }
}

TEST(more_samples_are_better) {
    double loss[3];
    losses_of((const char *const[]){"hyper-low", "hyper-mid", "hyper-high"}, loss);
    if (!(loss[0] > loss[1] + 0.1 && loss[1] > loss[2] + 0.02 && loss[2] < log(0.015)))
        fail_msg("mean losses %g, %g, %g", exp(loss[0]), exp(loss[1]), exp(loss[2]));
}

TEST(level_0_is_the_finest) {
    double loss[3];
    losses_of((const char *const[]){"hyper-0", "hyper-1", "hyper-2"}, loss);
    if (!(loss[0] < loss[1] - 0.01 && loss[1] < loss[2] - 0.1))
        fail_msg("mean losses %g, %g, %g", exp(loss[0]), exp(loss[1]), exp(loss[2]));
}

static void values_of(const char *model, size_t n, double *rgb) {
    static const double hd[3 * 2] = {0.01, 0.3, 0.5, 0.6, 0.4, 1.5};
    nqm_fit_report report;
    nqm_brdf *ref = must_open("sgd:red-plastic"), *brdf;
    assert_int_equal(nqm_fit(ref, model, NULL, &report, &brdf, NULL), NQM_OK);
    assert_string_equal(nqm_brdf_get_info(brdf).format, "nbrdf");
    nqm_brdf_eval_half_diff(brdf, n, hd, rgb, NULL);
    nqm_brdf_free(brdf);
    nqm_brdf_free(ref);
}

TEST(encoding_does_not_depend_on_threads) {
    double one[6], two[6];
    int n_threads = omp_get_max_threads();
    omp_set_num_threads(1);
    values_of("hyper-high", 2, one);
    omp_set_num_threads(2);
    values_of("hyper-high", 2, two);
    omp_set_num_threads(n_threads);
    assert_memory_equal(one, two, sizeof one);
    assert_true(one[0] > one[1]); /* red */
}

static void empty_eval(const void *self, size_t n, const double *hd, double *rgb) {
    (void)self, (void)hd;
    for (size_t i = 0; i < 3 * n; ++i)
        rgb[i] = (double)NAN;
}

static const nqm_brdf_class empty_class = {.format = "empty", .eval_half_diff = empty_eval, .free = free_nothing};

TEST(brdfs_without_values_are_refused) {
    nqm_brdf *empty;
    nqm_fit_report report;
    nqm_error err = {0};
    static int self;
    assert_int_equal(nqm_brdf_wrap(&empty_class, &self, &(nqm_brdf_info){.name = "nothing"}, &empty, NULL), NQM_OK);
    assert_int_equal(nqm_fit(empty, "hyper-low", NULL, &report, NULL, &err), NQM_ERR_INCOMPATIBLE);
    assert_non_null(strstr(err.message, "nothing"));
    const nqm_brdf *refs[] = {empty};
    const char *const names[] = {"nothing"};
    assert_int_equal(nqm_learn(NQM_ENCODER_HYPER, 1, refs, names, NULL, "-", &err), NQM_ERR_INCOMPATIBLE);
    nqm_brdf_free(empty);
}

/* ---- learning ---------------------------------------------------------------------------------------------------- */

enum { N_REFS = 3, N_SAMPLES = 200 };
static const char *const names[N_REFS] = {"lambert:kd=0.5", "ggx:kd=0.3,0.1,0.05;alpha=0.3",
                                          "ward:kd=0.1,0.2,0.3;ks=0.1;alpha=0.2"};
static nqm_brdf *refs[N_REFS];

static nqm_status learn(size_t n_steps, nqm_progress_fn progress, nqm_error *err) {
    nqm_learn_options options = nqm_learn_options_default();
    options.n_steps = n_steps;
    options.progress = progress;
    return nqm_learn(NQM_ENCODER_HYPER, N_REFS, (const nqm_brdf *const *)refs, names, &options, temp_file, err);
}

/* Mean loss of the networks that the hypernetwork in the temporary file predicts for the references. */
static double loss_of_file(void) {
    nqm_map map;
    nqm_hyper hyper;
    double hd[3 * N_SAMPLES], rgb[3 * N_SAMPLES], loss = 0;
    float input[6 * N_SAMPLES], weight[N_SAMPLES], goal[3 * N_SAMPLES], weights[NQM_NBRDF_WEIGHTS];
    assert_int_equal(nqm_map_open(temp_file, &map, NULL), NQM_OK);
    assert_int_equal(nqm_hyper_read(map.data, map.n_bytes, temp_file, &hyper, NULL), NQM_OK);
    for (size_t r = 0; r < N_REFS; ++r) {
        nqm_rng rng = nqm_rng_make(1, r);
        assert_int_equal(nqm_hyper_sample(refs[r], N_SAMPLES, &rng, hd, rgb, NULL), NQM_OK);
        assert_int_equal(nqm_hyper_encode(&hyper, N_SAMPLES, hd, rgb, weights, NULL), NQM_OK);
        nqm_nbrdf_inputs(N_SAMPLES, hd, input, weight);
        for (size_t i = 0; i < N_SAMPLES; ++i)
            for (size_t c = 0; c < 3; ++c)
                goal[c * N_SAMPLES + i] = (float)log1p((double)weight[i] * rgb[3 * i + c]);
        nqm_nbrdf_batch batch = {.n = N_SAMPLES, .input = input, .weight = weight, .goal = goal};
        loss += nqm_nbrdf_loss(weights, &batch, NULL) / N_REFS;
    }
    nqm_free(hyper.block);
    nqm_map_close(&map);
    return loss;
}

TEST(learning_lowers_the_loss) {
    assert_int_equal(learn(1, NULL, NULL), NQM_OK);
    double before = loss_of_file();
    assert_int_equal(learn(20, NULL, NULL), NQM_OK);
    double after = loss_of_file();
    if (!(after < 0.7 * before))
        fail_msg("loss %g, after learning %g", before, after);
}

TEST(learning_does_not_depend_on_threads) {
    int n_threads = omp_get_max_threads();
    nqm_map map[2];
    for (int i = 0; i < 2; ++i) {
        omp_set_num_threads(i + 1);
        assert_int_equal(learn(2, NULL, NULL), NQM_OK);
        assert_int_equal(nqm_map_open(temp_file, &map[i], NULL), NQM_OK);
    }
    omp_set_num_threads(n_threads);
    assert_int_equal(map[0].n_bytes, map[1].n_bytes);
    assert_memory_equal(map[0].data, map[1].data, map[0].n_bytes);
    nqm_map_close(&map[0]);
    nqm_map_close(&map[1]);
}

static int stop(void *user, const char *stage, double done, double total) {
    (void)user, (void)done, (void)total;
    return strcmp(stage, "learn") == 0;
}

TEST(learning_can_be_stopped) {
    nqm_error err = {0};
    assert_int_equal(learn(100000, stop, &err), NQM_ERR_CANCELLED);
}

static int open_all(void **state) {
    (void)state;
    for (size_t i = 0; i < N_REFS; ++i)
        refs[i] = must_open(names[i]);
    return make_temp_file(state);
}

static int close_all(void **state) {
    (void)state;
    for (size_t i = 0; i < N_REFS; ++i)
        nqm_brdf_free(refs[i]);
    return remove_temp_file(state);
}

TEST_FILE(open_all, close_all)
