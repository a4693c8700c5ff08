/* SPDX-License-Identifier: MIT
 *
 * The network's input against NumPy (tests/vectors/metrics.py): transform, whitening, dropped directions, both layouts.
 */
#include "io/io.h"
#include "sample/sample.h"
#include "support/check.h"
#include "support/metrics_pair.h"

#include <nqm/train.h>

enum { N = METRICS_PAIR_N };

TEST(test_transform) {
    const float rho[4] = {0, 1, 8, 0.001f};
    float t[4];
    nqm_features_transform(4, rho, t);
    assert_near(t[0], 0, 0);
    assert_near(t[1], log(2), 1e-7);
    assert_near(t[2], log(3), 1e-7);
    assert_near(t[3], log(1.1), 1e-8);
    nqm_features_transform(4, t, t); /* in place */
    assert_near(t[1], log(cbrt(log(2)) + 1), 1e-7);
}

TEST(test_layouts) {
    float ref_t[3 * N], test_t[3 * N], x[9 * N];
    nqm_features_transform(3 * N, pair.ref, ref_t);
    nqm_features_transform(3 * N, pair.test, test_t);
    nqm_csv *csv;
    assert_int_equal(nqm_csv_load(test_vector("features_expected.csv"), &csv, NULL), NQM_OK);
    size_t row = 0;
    for (int layout = NQM_LAYOUT_REF_TEST; layout <= NQM_LAYOUT_REF_DIFF_ABSDIFF; ++layout) {
        nqm_features features = {
            .layout = layout, .difference_scale = 3, .mean = {0.31f, 0.42f, 0.53f}, .std = {0.2f, 0.25f, 0.3f}};
        size_t width = nqm_features_width(layout, N);
        assert_int_equal(width, layout == NQM_LAYOUT_REF_TEST ? 6 * N : 9 * N);
        nqm_features_compose(&features, N, ref_t, test_t, pair.used, x);
        for (size_t i = 0; i < width; ++i, ++row) {
            assert_int_equal((int)csv_number(csv, row, 0), layout);
            assert_near(x[i], csv_number(csv, row, 1), 4e-6);
        }
    }
    assert_int_equal(row, nqm_csv_rows(csv));
    nqm_csv_free(csv);
}

TEST(test_equal_members_do_not_differ) {
    float t[3 * N], x[9 * N];
    nqm_features_transform(3 * N, pair.ref, t);
    nqm_features features = {.layout = NQM_LAYOUT_REF_DIFF_ABSDIFF,
                             .difference_scale = 3,
                             .mean = {0.3f, 0.4f, 0.5f},
                             .std = {0.7f, 0.7f, 0.7f}};
    nqm_features_compose(&features, N, t, t, NULL, x);
    for (size_t i = 3 * N; i < 9 * N; ++i)
        assert_true(x[i] == 0);
}

TEST_FILE(read_metrics_pair, free_metrics_pair)
