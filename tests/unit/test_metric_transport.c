/* SPDX-License-Identifier: MIT
 *
 * Estimates by light transport: pictures and labels against NumPy (tests/vectors/transport.py), dropped directions, exact zeros
 * of equal pairs, and the same bits for any cut and order of a batch and any number of threads.
 */
#include "kernel/kernel.h"
#include "metric/sums.h"
#include "support/check.h"
#include "support/predict.h"
#include "support/tiny_model.h"
#include "support/vectors.h"

#include <float.h>
#include <omp.h>

enum { N = 7, BRDFS = 5, POINTS = NQM_PICTURE_BLOCK, PARTS = 1 + NQM_LABEL_PARTS };

static float light[N * 3 * POINTS], rgb[BRDFS][3 * N];
static double points[3 * POINTS], itp[BRDFS][POINTS][3], itp_used[BRDFS][POINTS][3];
static double labels[BRDFS][PARTS], labels_used[BRDFS][PARTS], looks[2][BRDFS];
static uint8_t used[BRDFS][N];
static const nqm_transport transport = {N, light, {POINTS, points}};

static int read_vectors(void **state) {
    (void)state;
    const struct {
        const char *name;
        size_t n_bytes;
        void *to;
    } tensors[] = {{"light", sizeof light, light},    {"points", sizeof points, points},
                   {"rgb", sizeof rgb, rgb},          {"used", sizeof used, used},
                   {"itp", sizeof itp, itp},          {"itp_used", sizeof itp_used, itp_used},
                   {"labels", sizeof labels, labels}, {"labels_used", sizeof labels_used, labels_used},
                   {"looks", sizeof looks, looks}};
    for (size_t i = 0; i < sizeof tensors / sizeof *tensors; ++i)
        get_vector("transport.safetensors", tensors[i].name, tensors[i].n_bytes, tensors[i].to);
    return 0;
}

static nqm_label estimate(const float *ref, const float *test, const uint8_t *mask) {
    return transport_estimate(&transport, ref, test, mask);
}

/* ---- against NumPy ----------------------------------------------------------------------------------------------- */

/* Errors of the table for PQ, 4e-6 and 6e-6 for black, times 720 and the sum of the magnitudes of a row of the matrix. */
static void check_picture(const float *picture, double expected[POINTS][3]) {
    static const double tolerance[3] = {720 * 6e-6, 720 * 4e-6 * 3.4, 720 * 4e-6 * 8.8};
    for (size_t p = 0; p < POINTS; ++p)
        for (size_t k = 0; k < 3; ++k)
            assert_near((double)picture[k * POINTS + p], expected[p][k], tolerance[k]);
}

static void check_label(const nqm_label *label, const double *expected) {
    double parts[NQM_LABEL_PARTS];
    nqm_label_get_parts(label, parts);
    assert_near(label->delta_e, expected[0], 1e-3 + 1e-4 * expected[0]);
    for (size_t k = 0; k < NQM_LABEL_PARTS; ++k)
        assert_near(parts[k], expected[1 + k], k == 3 ? 1e-4 : 1e-3 + 1e-4 * expected[0]);
}

static void compare_with_numpy(void) {
    nqm_transport_picture samples[2 * BRDFS];
    nqm_sample_pair pairs[BRDFS];
    float pictures[2 * BRDFS][3 * POINTS];
    for (size_t i = 0; i < BRDFS; ++i) {
        pairs[i] = (nqm_sample_pair){rgb[i], rgb[i], NULL};
        samples[i] = (nqm_transport_picture){&pairs[i], NQM_TRANSPORT_OF_REF};
    }
    nqm_sample_pair masked[BRDFS];
    for (size_t i = 0; i < BRDFS; ++i) {
        masked[i] = (nqm_sample_pair){rgb[0], rgb[i], used[i]};
        samples[BRDFS + i] = (nqm_transport_picture){&masked[i], NQM_TRANSPORT_OF_TEST};
    }
    nqm_transport_pictures(&transport, 0, POINTS, 2 * BRDFS, samples, pictures[0]);
    for (size_t i = 0; i < BRDFS; ++i) {
        check_picture(pictures[i], itp[i]);
        check_picture(pictures[BRDFS + i], itp_used[i]);
        const nqm_label all = estimate(rgb[0], rgb[i], NULL), kept = estimate(rgb[0], rgb[i], used[i]);
        check_label(&all, labels[i]);
        check_label(&kept, labels_used[i]);
    }
}

/* ---- similarity -------------------------------------------------------------------------------------------------- */

static double looks_of(const float *ref, const float *test, const uint8_t *mask) {
    nqm_label label;
    double distance;
    nqm_transport_estimates(&transport, 1, &(nqm_sample_pair){ref, test, mask}, &label, &distance);
    return distance;
}

TEST(looks_agree_with_numpy) {
    for (size_t i = 0; i < BRDFS; ++i) {
        assert_near(looks_of(rgb[0], rgb[i], NULL), looks[0][i], 2e-3 + 1e-4 * looks[0][i]);
        assert_near(looks_of(rgb[0], rgb[i], used[i]), looks[1][i], 2e-3 + 1e-4 * looks[1][i]);
        assert_near(looks_of(rgb[i], rgb[0], NULL), looks_of(rgb[0], rgb[i], NULL), 0);
        assert_near(looks_of(rgb[i], rgb[i], NULL), 0, 0);
        for (size_t k = 0; k < BRDFS; ++k) /* a distance: no way round is shorter */
            assert_true(looks_of(rgb[0], rgb[i], NULL) <=
                        looks_of(rgb[0], rgb[k], NULL) + looks_of(rgb[k], rgb[i], NULL) + 1e-9);
    }
}

static double similarity_of(const nqm_model *model, double pictures, double log_rms, double ends[3]) {
    double apart[NQM_APART];
    const nqm_label label = {.delta_e = 9, .shift = {-3, 3, 4}, .contrast = -0.1, .structure = 2};
    nqm_metric_sums sums = {.n = 300};
    sums.squares[NQM_SCALE_LOG1P_F] = 300 * log_rms * log_rms;
    nqm_apart_distances(&label, pictures, &sums, apart);
    nqm_similarity(model, apart, ends);
    return ends[0];
}

TEST(similarity_falls_with_distance) {
    nqm_model model = {0};
    double before[3] = {10, 10, 10}, now[3];
    similarity_of(&model, 0, 0, now);
    assert_memory_equal(now, before, sizeof now);
    for (int i = 0; i < 40; ++i) {
        similarity_of(&model, exp(i / 8.), 0.1 * (i / 2), now);
        for (int k = 0; k < 3; ++k)
            assert_true(now[k] < before[k]);
        assert_true(now[1] < now[0] && now[0] < now[2]);
        memcpy(before, now, sizeof now);
    }
    const nqm_curve curve = nqm_curve_published; /* doc/people.md has the constants */
    assert_near(similarity_of(&model, 7, 0.5, now), nqm_curve_jod(&curve, 7 + 4.572 * 0.5), 1e-12);
    assert_near(now[1], nqm_curve_jod(&curve, (7 + 4.572 * 0.5) * exp(0.123)), 1e-12);
    memcpy(model.similarity, (double[NQM_APART + 1]){1, 2, 3, 4, 5, 6, 0.5},
           sizeof model.similarity); /* of a calibration */
    assert_near(similarity_of(&model, 7, 0, now), nqm_curve_jod(&curve, 9 + 2 * 3 + 3 * 5 + 4 * 3 + 5 * 2 + 6 * 7),
                1e-12);
    assert_near(now[2], nqm_curve_jod(&curve, 94 * exp(-0.5)), 1e-12);
}

/* ---- exact properties -------------------------------------------------------------------------------------------- */

TEST(equal_pairs_give_zero) {
    const nqm_label zero = {.delta_e = 0};
    for (size_t i = 0; i < BRDFS; ++i) {
        float copy[3 * N];
        memcpy(copy, rgb[i], sizeof copy);
        nqm_label label = estimate(rgb[i], copy, NULL);
        assert_memory_equal(&label, &zero, sizeof zero);
        for (size_t k = 0; k < N; ++k) /* differs only where directions are dropped */
            if (!used[i][k])
                copy[3 * k + 1] += 1;
        label = estimate(rgb[i], copy, used[i]);
        assert_memory_equal(&label, &zero, sizeof zero);
    }
}

TEST(extremes_are_finite) {
    const float black[3 * N] = {0};
    float bright[3 * N];
    for (size_t i = 0; i < 3 * N; ++i)
        bright[i] = FLT_MAX;
    const nqm_label a = estimate(black, bright, NULL), b = estimate(bright, black, NULL);
    assert_true(isfinite(a.delta_e) && a.delta_e > 100 && isfinite(a.structure) && isfinite(a.contrast));
    assert_near(a.delta_e, b.delta_e, 0);
    assert_near(a.shift[0], -b.shift[0], 0);
}

/* Pairs in one call have the bits of single pairs, in any order and whether or not neighbours share a reference. */
static void cut_batches(void) {
    nqm_sample_pair pairs[NQM_COMPARE_MAX];
    nqm_label batch[NQM_COMPARE_MAX];
    for (size_t turn = 0; turn < 5; ++turn)
        for (size_t n = 1; n <= NQM_COMPARE_MAX; ++n) {
            for (size_t i = 0; i < n; ++i)
                pairs[i] = (nqm_sample_pair){rgb[(turn + i / (1 + turn)) % BRDFS], rgb[(7 * i + turn) % BRDFS],
                                             used[(i + turn) % BRDFS]};
            nqm_transport_estimates(&transport, n, pairs, batch, NULL);
            for (size_t i = 0; i < n; ++i) {
                const nqm_label single = estimate(pairs[i].ref, pairs[i].test, pairs[i].used);
                assert_memory_equal(&batch[i], &single, sizeof single);
            }
        }
}

static void on_every_table(void (*test)(void)) {
    for (size_t t = 0; nqm_kernels_at(t); ++t) {
        nqm_kernels_use(nqm_kernels_at(t));
        test();
    }
    use_chosen_kernels();
}

TEST(against_numpy) {
    on_every_table(compare_with_numpy);
}

TEST(batches_give_the_same_bits) {
    on_every_table(cut_batches);
}

/* The same for the JOD of a model that corrects estimates, and for metrics: two threads share a single pair. */
TEST(predictions_give_the_same_bits) {
    enum { N_PAIRS = 75, N_DIRECTIONS = 130 };
    nqm_model *model;
    nqm_predictor *predictor;
    nqm_rng rng = nqm_rng_make(5, 0);
    static float samples[2 * N_PAIRS * 3 * N_DIRECTIONS];
    nqm_sample_pair pairs[N_PAIRS];
    nqm_prediction expected[N_PAIRS], got[N_PAIRS];
    static double expected_metrics[N_PAIRS * NQM_METRIC_COUNT], metrics[N_PAIRS * NQM_METRIC_COUNT];
    assert_int_equal(make_tiny_model(N_DIRECTIONS, &model, NULL), NQM_OK);
    static float random[N_DIRECTIONS * 3 * POINTS];
    for (size_t i = 0; i < N_DIRECTIONS * 3 * POINTS; ++i)
        random[i] = (float)nqm_rng_uniform(&rng);
    const nqm_transport matrix = {N_DIRECTIONS, random, {POINTS, points}};
    assert_int_equal(nqm_model_set_transport(model, &matrix, NULL), NQM_OK);
    for (size_t i = 0; i < 2 * N_PAIRS * 3 * N_DIRECTIONS; ++i)
        samples[i] = (float)nqm_rng_uniform(&rng);
    for (size_t i = 0; i < N_PAIRS; ++i)
        pairs[i] =
            (nqm_sample_pair){samples + i / 4 * 3 * N_DIRECTIONS, samples + (N_PAIRS + i) * 3 * N_DIRECTIONS, NULL};
    assert_int_equal(nqm_predictor_create(model, N_PAIRS, &predictor, NULL), NQM_OK);
    for (size_t i = 0; i < N_PAIRS; ++i)
        nqm_predictor_run(predictor, 1, pairs + i, expected + i, expected_metrics + i * NQM_METRIC_COUNT);
    for (int n_threads = 1; n_threads <= 2; ++n_threads) {
        omp_set_num_threads(n_threads);
        for (size_t cut = 1; cut <= N_PAIRS; cut = 2 * cut + 1) {
            for (size_t first = 0; first < N_PAIRS; first += cut)
                nqm_predictor_run(predictor, nqm_smaller(cut, N_PAIRS - first), pairs + first, got + first,
                                  metrics + first * NQM_METRIC_COUNT);
            assert_memory_equal(got, expected, sizeof got);
            assert_memory_equal(metrics, expected_metrics, sizeof metrics);
        }
    }
    nqm_predictor_free(predictor);
    nqm_model_free(model);
}

TEST_FILE(read_vectors, NULL)
