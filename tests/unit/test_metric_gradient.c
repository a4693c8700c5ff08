/* SPDX-License-Identifier: MIT
 *
 * Derivatives of metrics and scalar features against those of PyTorch in double (tests/vectors/metric_torch.py).
 */
#include "metric/sums.h"
#include "sample/loops.h"
#include "support/check.h"
#include "support/predict.h"
#include "support/recorded.h"

#include <float.h>

enum { N = PAIR_N, N_VALUES = PAIR_VALUES, N_FEATURES = NQM_SCALAR_ESTIMATE, RECORDED = 8 };

/* ---- comparison -------------------------------------------------------------------------------------------------- */

/* That of weighted scalar features. */
static void gradient_of(const gradient_pair *p, const double *scalars, float *gradient) {
    static float roots[2][N_VALUES], t[N_VALUES]; /* t is not used */
    const nqm_sample_pair pair = {p->ref, p->test, p->used};
    nqm_pair_sums sums;
    nqm_sum_plan *plan;
    assert_int_equal(nqm_sum_plan_create(directions, &plan, NULL), NQM_OK);
    nqm_sample_logs(N_VALUES, p->ref, roots[0], t);
    nqm_sample_logs(N_VALUES, p->test, roots[1], t);
    nqm_compare_sums(plan, 1, &pair, roots[0], true, &sums);
    memset(gradient, 0, N_VALUES * sizeof *gradient);
    nqm_compare_gradient(&(nqm_compared_pair){plan, pair, roots[0], roots[1], &sums}, scalars, gradient);
    nqm_sum_plan_free(plan);
}

static void one_gradient(const gradient_pair *p, size_t feature, float *gradient) {
    double weights[NQM_SCALAR_COUNT] = {0};
    weights[feature] = 1;
    gradient_of(p, weights, gradient);
}

static void check_gradients(size_t number, const gradient_pair *p, bool with_roots) {
    static double slopes[RECORDED][N_FEATURES][N_WAYS];
    float gradient[N_VALUES];
    get_recorded("features.slopes", sizeof slopes, slopes);
    for (size_t j = 0; j < N_FEATURES; ++j)
        if (with_roots || (j != NQM_METRIC_RMS_CRWE && j != NQM_METRIC_MA_CRWE)) {
            one_gradient(p, j, gradient);
            check_slopes(nqm_scalar_name(j), gradient, slopes[number][j], NULL, 2e-5);
        }
}

static void check_pair(size_t number) {
    double features[RECORDED][N_FEATURES], scalars[NQM_SCALAR_COUNT];
    const gradient_pair p = recorded_pair(number);
    get_recorded("features", sizeof features, features);
    compute_scalars(directions, NULL, p.ref, p.test, p.used, scalars);
    for (size_t j = 0; j < N_FEATURES; ++j)
        check_near(scalars[j], features[number][j], 1e-5 + 3e-6 * exp(-features[number][j]), nqm_scalar_name(j),
                   __FILE__, __LINE__);
    check_gradients(number, &p, true);
}

/* ---- tests ------------------------------------------------------------------------------------------------------- */

TEST(ordinary_pairs) {
    for (size_t k = PAIR_002; k <= PAIR_1; ++k)
        check_pair(k);
}

TEST(unused_directions) {
    gradient_pair p = recorded_pair(PAIR_UNUSED);
    check_pair(PAIR_UNUSED);
    double weights[NQM_SCALAR_COUNT];
    float gradient[N_VALUES], changed[N_VALUES];
    for (size_t j = 0; j < NQM_SCALAR_COUNT; ++j)
        weights[j] = 1;
    gradient_of(&p, weights, gradient);
    for (size_t i = 0; i < N_VALUES; ++i)
        if (!p.used[i / 3]) {
            assert_true(gradient[i] == 0);
            p.test[i] = 1e6f;
        }
    gradient_of(&p, weights, changed);
    assert_memory_equal(gradient, changed, sizeof gradient);
    memset(p.used, 0, sizeof p.used);
    gradient_of(&p, weights, gradient);
    for (size_t i = 0; i < N_VALUES; ++i)
        assert_true(gradient[i] == 0);
}

/* All features but those of cube roots continue smoothly below 0, so that differences around 0 are those from the right. */
TEST(zero_reflectance) {
    const gradient_pair p = recorded_pair(PAIR_ZEROS);
    check_gradients(PAIR_ZEROS, &p, false);
    double metrics[NQM_METRIC_COUNT], n = N_VALUES;
    float gradient[N_VALUES];
    assert_int_equal(nqm_metrics_compute(directions, p.ref, p.test, p.used, metrics, NULL), NQM_OK);
    for (size_t m = NQM_METRIC_RMS_CRWE; m <= NQM_METRIC_MA_CRWE; ++m) {
        double weights[NQM_SCALAR_COUNT] = {0};
        weights[NQM_SCALAR_METRICS + m] = metrics[m] + 0.0001; /* d metric = (metric + 0.0001) d log(metric + 0.0001) */
        gradient_of(&p, weights, gradient);
        for (size_t i = 0; i < N_VALUES; ++i) {
            const double c = directions->cosines[i / 3], slope = c / (3 * 1e-6); /* of the cube root at 1e-9 */
            const double by = m == NQM_METRIC_MA_CRWE ? -1 / n : -cbrt(c * (double)p.ref[i]) / (n * metrics[m]);
            if (p.test[i] <= 0)
                assert_relative((double)gradient[i], by * slope, 2e-6);
        }
    }
}

/* Signed features have derivatives at equal pairs; those of sizes are 0. */
TEST(equal_pair) {
    const gradient_pair p = recorded_pair(PAIR_EQUAL);
    check_gradients(PAIR_EQUAL, &p, true);
    float gradient[N_VALUES];
    for (size_t j = 0; j < N_FEATURES; ++j) {
        const bool is_signed = j == NQM_SCALAR_BIAS || j == NQM_SCALAR_GRAZING_BIAS || j == NQM_SCALAR_WIDTH ||
                               j == NQM_SCALAR_CHROMA_RG || j == NQM_SCALAR_CHROMA_B || j == NQM_SCALAR_ENERGY ||
                               j == NQM_SCALAR_PEAK || (j >= NQM_SCALAR_ZONE_BIAS && j < NQM_SCALAR_ZONE_RMS);
        one_gradient(&p, j, gradient);
        for (size_t i = 0; !is_signed && i < N_VALUES; ++i)
            assert_true(gradient[i] == 0);
    }
}

/* Which directions have derivatives of a maximum. */
static void assert_only_direction(const gradient_pair *p, size_t feature, size_t direction) {
    float gradient[N_VALUES];
    one_gradient(p, feature, gradient);
    for (size_t i = 0; i < N_VALUES; ++i)
        assert_true((gradient[i] != 0) == (i / 3 == direction));
}

TEST(maxima) {
    gradient_pair p = recorded_pair(PAIR_MAXIMA);
    check_pair(PAIR_MAXIMA);
    check_pair(PAIR_OTHER_MAXIMA);
    assert_only_direction(&p, NQM_SCALAR_MAX, 10);
    for (size_t k = 0; k < 3; ++k) /* both directions attain both maxima */
        p.test[3 * 10 + k] = p.test[3 * 100 + k];
    assert_only_direction(&p, NQM_SCALAR_MAX, 10);
    assert_only_direction(&p, NQM_SCALAR_PEAK, 10);
    p.used[10] = 0;
    assert_only_direction(&p, NQM_SCALAR_MAX, 100);
    assert_only_direction(&p, NQM_SCALAR_PEAK, 100);
    p = recorded_pair(PAIR_OTHER_MAXIMA);
    assert_only_direction(&p, NQM_SCALAR_MAX, 100);
    memset(p.test, 0, sizeof p.test);
    assert_only_direction(&p, NQM_SCALAR_PEAK, 0);
}

TEST(extremes) {
    static const float values[] = {0, FLT_TRUE_MIN, 1e-20f, 1e-9f, 1, 1e20f, FLT_MAX};
    gradient_pair p = recorded_pair(PAIR_02);
    double weights[NQM_SCALAR_COUNT];
    float gradient[N_VALUES];
    for (size_t j = 0; j < NQM_SCALAR_COUNT; ++j)
        weights[j] = 1;
    for (size_t k = 0; k < 49; ++k) {
        for (size_t i = 0; i < N_VALUES; ++i) {
            p.ref[i] = values[k / 7];
            p.test[i] = i % 2 ? values[k % 7] : values[k / 7];
        }
        gradient_of(&p, weights, gradient);
        for (size_t i = 0; i < N_VALUES; ++i)
            if (!isfinite(gradient[i]))
                fail_msg("%g at %g: %g", (double)p.test[i], (double)p.ref[i], (double)gradient[i]);
    }
}

/* Features of the caller do not matter, and a gradient is added to what is there. */
TEST(caller_features) {
    gradient_pair p = recorded_pair(PAIR_02);
    double weights[NQM_SCALAR_COUNT];
    float without[N_VALUES], with[N_VALUES];
    nqm_rng rng = nqm_rng_make(9, 0);
    p.used[50] = 0;
    for (size_t j = 0; j < NQM_SCALAR_COUNT; ++j)
        weights[j] = nqm_rng_normal(&rng);
    gradient_of(&p, weights, without);
    for (size_t j = NQM_SCALAR_ESTIMATE; j < NQM_SCALAR_COUNT; ++j)
        weights[j] = 1e6;
    gradient_of(&p, weights, with);
    assert_memory_equal(with, without, sizeof with);
}

TEST_FILE(make_recorded_directions, free_recorded_directions)
