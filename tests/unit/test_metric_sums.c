/* SPDX-License-Identifier: MIT
 *
 * Metrics and features from the float sums (metric/sums.c) against PyTorch in double (vectors/metric_torch.py): pairs of all kinds, dropped directions,
 * directions in any order, values beyond the range of float; and the same bits however pairs are grouped.
 */
#include "kernel/kernel.h"
#include "metric/sums.h"
#include "sample/loops.h"
#include "sample/sample.h"
#include "support/check.h"
#include "support/vectors.h"

#include <float.h>

enum { N = 301, TESTS = NQM_COMPARE_MAX }; /* three stretches, the last of which is short */

static nqm_directions *directions;
static nqm_sum_plan *plan;
static float ref[3 * N], test[TESTS][3 * N], roots[1 + TESTS][3 * N];
static float transformed[3 * N]; /* not used */
static uint8_t used[TESTS][N];

static void get(const char *name, size_t n_bytes, void *to) {
    get_vector("metric_torch.safetensors", name, n_bytes, to);
}

static int make_directions(void **state) {
    (void)state;
    double degrees[3 * N];
    get("sums.degrees", sizeof degrees, degrees);
    if (nqm_directions_from_degrees(N, degrees, &directions, NULL) != NQM_OK)
        return -1;
    return nqm_sum_plan_create(directions, &plan, NULL) == NQM_OK ? 0 : -1;
}

static int free_directions(void **state) {
    (void)state;
    nqm_sum_plan_free(plan);
    nqm_directions_free(directions);
    return 0;
}

/* Read the recorded pairs, which tests change. */
static void make_pairs(void) {
    get("sums.ref", sizeof ref, ref);
    get("sums.test", sizeof test, test);
    get("sums.used", sizeof used, used);
    nqm_sample_logs(3 * N, ref, roots[0], transformed);
    for (size_t k = 0; k < TESTS; ++k)
        nqm_sample_logs(3 * N, test[k], roots[1 + k], transformed);
}

/* Metrics and scalar features of all tests. */
typedef struct features {
    double metrics[TESTS][NQM_METRIC_COUNT], scalars[TESTS][NQM_SCALAR_COUNT];
} features;

/* Compute those of tests [first, first + n), from given roots or not. */
static void compute(const nqm_sample_pair *pairs, size_t first, size_t n, bool with_roots, features *to) {
    nqm_pair_sums sums[TESTS];
    static float own[1 + TESTS][3 * N];
    memcpy(own[0], roots[0], sizeof own[0]);
    memcpy(own[1], roots[1 + first], n * sizeof own[1]);
    nqm_compare_sums(plan, n, pairs + first, with_roots ? own[0] : NULL, true, sums);
    for (size_t k = 0; k < n; ++k)
        nqm_compare_finish(&sums[k], NULL, to->metrics[first + k], to->scalars[first + k]);
}

/* The same in double. */
static void get_recorded_features(bool with_used, features *to) {
    double scalars[TESTS][NQM_SCALAR_ESTIMATE];
    get(with_used ? "sums.some" : "sums.all", sizeof scalars, scalars);
    for (size_t k = 0; k < TESTS; ++k) {
        memcpy(to->scalars[k], scalars[k], sizeof scalars[k]);
        for (size_t m = 0; m < NQM_METRIC_COUNT; ++m)
            to->metrics[k][m] = exp(scalars[k][m]) - 1e-4;
    }
}

static void set_pairs(bool with_used, nqm_sample_pair *pairs) {
    for (size_t k = 0; k < TESTS; ++k)
        pairs[k] = (nqm_sample_pair){ref, test[k], with_used ? used[k] : NULL};
}

/* Metrics within 4e-7 relative, however close the members are; scalar features within 1e-5, and the logarithm of a size x within
 * 3e-6 / x: differences of luminances are rounded like these. */
static void check_features(const features *fast, const features *exact) {
    const double rounding = 3e-6;
    for (size_t k = 0; k < TESTS; ++k) {
        for (size_t m = 0; m < NQM_METRIC_COUNT; ++m) {
            const double expected = exact->metrics[k][m];
            check_near(fast->metrics[k][m], expected, 4e-7 * expected, nqm_metric_get_info((nqm_metric)m).name,
                       __FILE__, __LINE__);
        }
        for (size_t i = 0; i < NQM_SCALAR_ESTIMATE; ++i) {
            const double expected = exact->scalars[k][i], floor = log(1e-3 + 1.001e-5);
            if (i == NQM_SCALAR_TAIL && expected < floor)
                assert_true(fast->scalars[k][i] < floor); /* PyTorch's module has no smaller tails */
            else
                check_near(fast->scalars[k][i], expected, 1e-5 + rounding * exp(-expected), nqm_scalar_name(i),
                           __FILE__, __LINE__);
        }
    }
}

TEST(against_double) {
    nqm_sample_pair pairs[TESTS];
    features fast, exact;
    make_pairs();
    for (int with_used = 0; with_used < 2; ++with_used) {
        set_pairs(with_used, pairs);
        get_recorded_features(with_used, &exact);
        compute(pairs, 0, TESTS, true, &fast);
        check_features(&fast, &exact);
    }
}

TEST(one_by_one) {
    nqm_sample_pair pairs[TESTS];
    features together, alone;
    make_pairs();
    set_pairs(true, pairs);
    compute(pairs, 0, TESTS, true, &together);
    for (size_t k = 0; k < TESTS; ++k)
        compute(pairs, k, 1, k % 2, &alone);
    assert_memory_equal(&together, &alone, sizeof together);
}

TEST(equal_and_extreme_members) {
    nqm_sample_pair pairs[TESTS];
    features fast, exact;
    make_pairs();
    set_pairs(true, pairs);
    for (size_t k = 0; k < TESTS; ++k) {
        pairs[k].test = ref;
        memset(used[k], k > 0, N); /* the first pair has no direction */
        memcpy(roots[1 + k], roots[0], sizeof roots[1 + k]);
    }
    compute(pairs, 0, TESTS, true, &fast);
    for (size_t i = 0; i < NQM_SCALAR_COUNT; ++i)
        assert_true(isnan(fast.scalars[0][i]));
    for (size_t i = 0; i < NQM_SCALAR_REF_LEVEL; ++i)
        assert_true(fast.scalars[1][i] == 0 || fast.scalars[1][i] == log(1e-3) || fast.scalars[1][i] == log(1e-4));
    for (size_t i = 0; i < 3 * N; ++i)
        test[1][i] = FLT_MAX;
    pairs[1].test = test[1];
    memset(used[0], 1, N);
    compute(pairs, 0, TESTS, false, &fast);
    for (size_t i = 0; i < 3 * N; ++i)
        test[1][i] = 1e15f;
    compute(pairs, 0, TESTS, false, &exact);
    check_features(&fast, &exact);
}

TEST_FILE(make_directions, free_directions)
