/* SPDX-License-Identifier: MIT
 *
 * Derivatives of metrics and scalar features against central differences, in double. The library reads float samples, too
 * coarse for differences, so support/double_features.c has the features once more.
 */
#include "metric/sums.h"
#include "sample/loops.h"
#include "support/check.h"
#include "support/double_features.h"
#include "support/predict.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { N = DOUBLE_N, N_VALUES = DOUBLE_VALUES, N_FEATURES = NQM_SCALAR_ESTIMATE };

/* ---- comparison -------------------------------------------------------------------------------------------------- */

/* (N_FEATURES, N_VALUES) */
typedef double feature_gradients[N_FEATURES][N_VALUES];

/* Central differences of order 4. */
static void differentiate(const gradient_pair *p, feature_gradients gradients) {
    double f[N_VALUES], g[N_VALUES], x[4][N_FEATURES];
    static const double steps[4] = {-2, -1, 1, 2};
    to_double(p->ref, f);
    to_double(p->test, g);
    for (size_t i = 0; i < N_VALUES; ++i) {
        const double at = g[i], h = 1e-4 * (at + NQM_DARK);
        for (size_t k = 0; k < 4; ++k) {
            g[i] = at + steps[k] * h;
            features_of(f, g, p->used, x[k]);
        }
        for (size_t j = 0; j < N_FEATURES; ++j)
            gradients[j][i] = (8 * (x[2][j] - x[1][j]) - (x[3][j] - x[0][j])) / (12 * h);
        g[i] = at;
    }
}

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

/* Within 1e-5 of the largest entry. */
static void assert_gradient(const float *gradient, const double *expected, const char *name) {
    double largest = 0;
    for (size_t i = 0; i < N_VALUES; ++i)
        largest = fmax(largest, fabs(expected[i]));
    for (size_t i = 0; i < N_VALUES; ++i)
        if (!(fabs((double)gradient[i] - expected[i]) <= 1e-5 * largest))
            fail_msg("%s by %zu: %.12g, not %.12g; largest %g", name, i, (double)gradient[i], expected[i], largest);
}

static void check_pair(const gradient_pair *p) {
    static feature_gradients expected;
    double f[N_VALUES], g[N_VALUES], x[N_FEATURES], scalars[NQM_SCALAR_COUNT];
    float gradient[N_VALUES];
    to_double(p->ref, f);
    to_double(p->test, g);
    features_of(f, g, p->used, x);
    compute_scalars(directions, NULL, p->ref, p->test, p->used, scalars);
    for (size_t j = 0; j < N_FEATURES; ++j)
        check_near(scalars[j], x[j], 1e-5 + 3e-6 * exp(-x[j]), nqm_scalar_name(j), __FILE__, __LINE__);
    differentiate(p, expected);
    for (size_t j = 0; j < N_FEATURES; ++j) {
        one_gradient(p, j, gradient);
        assert_gradient(gradient, expected[j], nqm_scalar_name(j));
    }
}

/* ---- tests ------------------------------------------------------------------------------------------------------- */

TEST(ordinary_pairs) {
    static const double strengths[] = {0.02, 0.2, 1};
    for (size_t k = 0; k < 3; ++k) {
        const gradient_pair p = make_pair(k + 1, strengths[k], 40 + 30 * k);
        check_pair(&p);
    }
}

TEST(unused_directions) {
    gradient_pair p = make_pair(4, 0.3, 70);
    for (size_t i = 0; i < N; ++i)
        p.used[i] = i % 3 != 0 && directions->degrees[3 * i] >= 2; /* the first zone is empty */
    check_pair(&p);
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
    static feature_gradients expected;
    gradient_pair p = make_pair(5, 0.4, 20);
    for (size_t i = 0; i < N; i += 4)
        for (size_t k = 0; k < 1 + i % 3; ++k)
            p.test[3 * i + k] = 0;
    differentiate(&p, expected);
    double metrics[NQM_METRIC_COUNT], n = N_VALUES;
    float gradient[N_VALUES];
    for (size_t j = 0; j < N_FEATURES; ++j) {
        if (j == NQM_METRIC_RMS_CRWE || j == NQM_METRIC_MA_CRWE)
            continue;
        one_gradient(&p, j, gradient);
        assert_gradient(gradient, expected[j], nqm_scalar_name(j));
    }
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
    static feature_gradients expected;
    gradient_pair p = make_pair(6, 0.4, 20);
    p.test[60] *= 1.1f;
    memcpy(p.ref, p.test, sizeof p.ref);
    differentiate(&p, expected);
    float gradient[N_VALUES];
    for (size_t j = 0; j < N_FEATURES; ++j) {
        const bool is_signed = j == NQM_SCALAR_BIAS || j == NQM_SCALAR_GRAZING_BIAS || j == NQM_SCALAR_WIDTH ||
                               j == NQM_SCALAR_CHROMA_RG || j == NQM_SCALAR_CHROMA_B || j == NQM_SCALAR_ENERGY ||
                               j == NQM_SCALAR_PEAK || (j >= NQM_SCALAR_ZONE_BIAS && j < NQM_SCALAR_ZONE_RMS);
        one_gradient(&p, j, gradient);
        if (is_signed)
            assert_gradient(gradient, expected[j], nqm_scalar_name(j));
        else
            for (size_t i = 0; i < N_VALUES; ++i)
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
    gradient_pair p = make_pair(7, 0.1, 100);
    assert_only_direction(&p, NQM_SCALAR_MAX, 100);
    assert_only_direction(&p, NQM_SCALAR_PEAK, 100);
    for (size_t k = 0; k < 3; ++k) { /* a second direction attains both, in an earlier stretch */
        p.ref[3 * 10 + k] = p.ref[3 * 100 + k];
        p.test[3 * 10 + k] = p.test[3 * 100 + k];
    }
    assert_only_direction(&p, NQM_SCALAR_MAX, 10);
    assert_only_direction(&p, NQM_SCALAR_PEAK, 10);
    p.used[10] = 0;
    assert_only_direction(&p, NQM_SCALAR_MAX, 100);
    p.used[10] = 1;
    for (size_t k = 0; k < 3; ++k)
        p.test[3 * 10 + k] *= 1.01f;
    check_pair(&p);
    for (size_t k = 0; k < 3; ++k)
        p.test[3 * 10 + k] *= 0.98f; /* the maximum switches */
    assert_only_direction(&p, NQM_SCALAR_MAX, 100);
    check_pair(&p);
    memset(p.test, 0, sizeof p.test);
    assert_only_direction(&p, NQM_SCALAR_PEAK, 0);
}

TEST(extremes) {
    static const float values[] = {0, FLT_TRUE_MIN, 1e-20f, 1e-9f, 1, 1e20f, FLT_MAX};
    gradient_pair p = make_pair(8, 0.1, 100);
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
    gradient_pair p = make_pair(10, 0.2, 0);
    double weights[NQM_SCALAR_COUNT];
    float without[N_VALUES], with[N_VALUES];
    uint64_t seed = 9;
    p.used[50] = 0;
    for (size_t j = 0; j < NQM_SCALAR_COUNT; ++j)
        weights[j] = random_unit(&seed) - 0.5;
    gradient_of(&p, weights, without);
    for (size_t j = NQM_SCALAR_ESTIMATE; j < NQM_SCALAR_COUNT; ++j)
        weights[j] = 1e6;
    gradient_of(&p, weights, with);
    assert_memory_equal(with, without, sizeof with);
}

TEST_FILE(make_double_directions, free_double_directions)
