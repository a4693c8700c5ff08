/* SPDX-License-Identifier: MIT
 *
 * The scalar features for limiting cases, and as inputs of the network; test_metric_sums.c compares them with PyTorch.
 */
#include "metric/metric.h"
#include "metric/sums.h"
#include "support/check.h"
#include "support/metrics_pair.h"
#include "support/predict.h"

#include <float.h>

enum { N = METRICS_PAIR_N };

/* For equal members every difference is exactly 0, or the logarithm of the floor of its feature. */
TEST(equal_members) {
    double same[NQM_SCALAR_COUNT];
    compute_scalars(pair.directions, NULL, pair.ref, pair.ref, NULL, same);
    for (size_t i = 0; i < NQM_SCALAR_REF_LEVEL; ++i)
        assert_true(same[i] == 0 || same[i] == log(1e-3) || same[i] == log(1e-4));
}

/* The zones of theta_h end at 2, 5, 15, 35 degrees, those of theta_d at 30 and 60. */
TEST(zones) {
    static const double h_ends[] = {2, 5, 15, 35}, d_ends[] = {30, 60};
    for (size_t i = 0; i < 4; ++i) {
        const double below[3] = {h_ends[i] - 0.01, 0, 0}, at[3] = {h_ends[i], 0, 0};
        assert_int_equal(nqm_cell_of(below), NQM_ZONES_D * i);
        assert_int_equal(nqm_cell_of(at), NQM_ZONES_D * (i + 1));
    }
    for (size_t i = 0; i < 2; ++i) {
        const double below[3] = {0, d_ends[i] - 0.01, 0}, at[3] = {0, d_ends[i], 0};
        assert_int_equal(nqm_cell_of(below), i);
        assert_int_equal(nqm_cell_of(at), i + 1);
    }
    assert_true(nqm_is_grazing(0.2499) && !nqm_is_grazing(0.25));
}

/* 120 Delta-E for each unit of the largest difference of log(f + 0.003); directions that are not used do not count. */
TEST(the_bound_of_delta_e) {
    const float ref[6] = {1, 1, 1, 0.5F, 0.5F, 0.5F}, test[6] = {1, 1.1F, 1, 0.5F, 0.5F, 0.4F},
                far[6] = {1, 1, 1, 1, 1, 1};
    const uint8_t first[2] = {1, 0};
    assert_near(nqm_delta_e_bound(2, &(nqm_sample_pair){ref, test, NULL}), 165 * log(0.500005 / 0.400005), 1e-4);
    assert_near(nqm_delta_e_bound(2, &(nqm_sample_pair){ref, test, first}), 165 * log(1.100005 / 1.000005), 1e-4);
    assert_near(nqm_delta_e_bound(2, &(nqm_sample_pair){ref, ref, NULL}), 0, 0);
    assert_true(isinf(nqm_delta_e_bound(2, &(nqm_sample_pair){ref, far, NULL})));
}

TEST(no_direction_and_extremes) {
    double scalars[NQM_SCALAR_COUNT];
    const uint8_t none[N] = {0};
    compute_scalars(pair.directions, NULL, pair.ref, pair.test, none, scalars);
    for (size_t i = 0; i < NQM_SCALAR_COUNT; ++i)
        assert_true(isnan(scalars[i]));
    const float black[3 * N] = {0};
    float bright[3 * N];
    for (size_t i = 0; i < 3 * N; ++i)
        bright[i] = FLT_MAX;
    const float *const members[] = {black, bright};
    for (size_t k = 0; k < 4; ++k) {
        compute_scalars(pair.directions, NULL, members[k / 2], members[k % 2], NULL, scalars);
        for (size_t i = 0; i < NQM_SCALAR_COUNT; ++i)
            if (!isfinite(scalars[i]))
                fail_msg("%s of %zu is %g", nqm_scalar_name(i), k, scalars[i]);
    }
}

TEST(as_inputs) {
    nqm_scalar_whitening whitening = {.scale = 2};
    assert_int_equal(nqm_scalars_select(NULL, &whitening, NULL), NQM_OK);
    float x[NQM_SCALAR_COUNT];
    double scalars[NQM_SCALAR_COUNT] = {3, 1e30, -1e30, (double)NAN};
    for (size_t i = 0; i < NQM_SCALAR_COUNT; ++i) {
        whitening.mean[i] = 1;
        whitening.std[i] = 4;
    }
    nqm_scalars_whiten(&whitening, scalars, x);
    assert_near((double)x[0], 1, 0);
    assert_near((double)x[1], 10, 0);
    assert_near((double)x[2], -10, 0);
    assert_near((double)x[3], 0, 0);
    assert_near((double)x[4], -0.5, 0);
}

TEST(names) {
    char *text = nqm_scalar_names();
    assert_non_null(text);
    assert_int_equal(strncmp(text, "log_rmse,log_mae,", 17), 0);
    assert_string_equal(strrchr(text, ','), ",estimate_structure");
    nqm_free(text);
    for (size_t i = 0; i < NQM_SCALAR_COUNT; ++i)
        for (size_t k = 0; k < i; ++k)
            assert_string_not_equal(nqm_scalar_name(i), nqm_scalar_name(k));
}

TEST_FILE(read_metrics_pair, free_metrics_pair)
