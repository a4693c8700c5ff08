/* SPDX-License-Identifier: MIT
 *
 * The scalar features against NumPy (tests/vectors/scalars.py), for limiting cases, and as inputs of the network.
 */
#include "metric/metric.h"
#include "support/check.h"
#include "support/metrics_pair.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { N = METRICS_PAIR_N };

static void against_numpy(void **state) {
    (void)state;
    double all[NQM_SCALAR_COUNT], kept[NQM_SCALAR_COUNT];
    nqm_scalars_compute(pair.directions, NULL, pair.ref, pair.test, NULL, all);
    nqm_scalars_compute(pair.directions, NULL, pair.ref, pair.test, pair.used, kept);
    nqm_csv *csv;
    assert_int_equal(nqm_csv_load(test_vector("scalars_expected.csv"), &csv, NULL), NQM_OK);
    assert_int_equal(nqm_csv_rows(csv), NQM_SCALAR_COUNT);
    for (size_t row = 0; row < NQM_SCALAR_COUNT; ++row) {
        assert_string_equal(nqm_csv_text(csv, row, 0), nqm_scalar_name(row));
        check_near(all[row], csv_number(csv, row, 1), 1e-6, nqm_scalar_name(row), __FILE__, __LINE__);
        check_near(kept[row], csv_number(csv, row, 2), 1e-6, nqm_scalar_name(row), __FILE__, __LINE__);
    }
    nqm_csv_free(csv);
    assert_null(nqm_scalar_name(NQM_SCALAR_COUNT));
}

/* For equal members every difference is exactly 0, or the logarithm of the floor of its feature. */
static void equal_members(void **state) {
    (void)state;
    double same[NQM_SCALAR_COUNT];
    nqm_scalars_compute(pair.directions, NULL, pair.ref, pair.ref, NULL, same);
    for (size_t i = 0; i < NQM_SCALAR_REF_LEVEL; ++i)
        assert_true(same[i] == 0 || same[i] == log(1e-3) || same[i] == log(1e-4));
}

static void no_direction_and_extremes(void **state) {
    (void)state;
    double scalars[NQM_SCALAR_COUNT];
    const uint8_t none[N] = {0};
    nqm_scalars_compute(pair.directions, NULL, pair.ref, pair.test, none, scalars);
    for (size_t i = 0; i < NQM_SCALAR_COUNT; ++i)
        assert_true(isnan(scalars[i]));
    const float black[3 * N] = {0};
    float bright[3 * N];
    for (size_t i = 0; i < 3 * N; ++i)
        bright[i] = FLT_MAX;
    const float *const members[] = {black, bright};
    for (size_t k = 0; k < 4; ++k) {
        nqm_scalars_compute(pair.directions, NULL, members[k / 2], members[k % 2], NULL, scalars);
        for (size_t i = 0; i < NQM_SCALAR_COUNT; ++i)
            if (!isfinite(scalars[i]))
                fail_msg("%s of %zu is %g", nqm_scalar_name(i), k, scalars[i]);
    }
}

static void as_inputs(void **state) {
    (void)state;
    nqm_scalar_whitening whitening = {.scale = 2};
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

static void names(void **state) {
    (void)state;
    char *text = nqm_scalar_names();
    assert_non_null(text);
    assert_int_equal(strncmp(text, "log_rmse,log_mae,", 17), 0);
    assert_string_equal(strrchr(text, ','), ",estimate_structure");
    nqm_free(text);
    for (size_t i = 0; i < NQM_SCALAR_COUNT; ++i)
        for (size_t k = 0; k < i; ++k)
            assert_string_not_equal(nqm_scalar_name(i), nqm_scalar_name(k));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(against_numpy), cmocka_unit_test(equal_members), cmocka_unit_test(no_direction_and_extremes),
        cmocka_unit_test(as_inputs),     cmocka_unit_test(names),
    };
    return cmocka_run_group_tests(tests, read_metrics_pair, free_metrics_pair);
}
