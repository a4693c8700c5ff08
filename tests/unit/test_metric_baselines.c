/* SPDX-License-Identifier: MIT
 *
 * The nine scalar metrics against NumPy (tests/vectors/metrics.py), with and without dropped directions, and for
 * limiting cases.
 */
#include "io/io.h"
#include "metric/metric.h"
#include "sample/sample.h"
#include "support/check.h"
#include "support/metrics_pair.h"

#include <nqm/metric.h>

enum { N = METRICS_PAIR_N };

TEST(test_against_numpy) {
    double all[NQM_METRIC_COUNT], kept[NQM_METRIC_COUNT];
    assert_int_equal(nqm_metrics_compute(pair.directions, pair.ref, pair.test, NULL, all, NULL), NQM_OK);
    assert_int_equal(nqm_metrics_compute(pair.directions, pair.ref, pair.test, pair.used, kept, NULL), NQM_OK);
    nqm_csv *csv;
    assert_int_equal(nqm_csv_load(test_vector("metrics_expected.csv"), &csv, NULL), NQM_OK);
    assert_int_equal(nqm_csv_rows(csv), NQM_METRIC_COUNT);
    for (size_t row = 0; row < NQM_METRIC_COUNT; ++row) {
        assert_string_equal(nqm_csv_text(csv, row, 0), nqm_metric_get_info((nqm_metric)row).name);
        assert_relative(all[row], csv_number(csv, row, 1), 1e-6);
        assert_relative(kept[row], csv_number(csv, row, 2), 1e-6);
    }
    nqm_csv_free(csv);
}

TEST(test_equal_and_empty) {
    double metrics[NQM_METRIC_COUNT];
    assert_int_equal(nqm_metrics_compute(pair.directions, pair.ref, pair.ref, NULL, metrics, NULL), NQM_OK);
    for (size_t m = 0; m < NQM_METRIC_COUNT; ++m)
        assert_near(metrics[m], 0, 0);
    const uint8_t none[N] = {0};
    assert_int_equal(nqm_metrics_compute(pair.directions, pair.ref, pair.test, none, metrics, NULL), NQM_OK);
    for (size_t m = 0; m < NQM_METRIC_COUNT; ++m)
        assert_true(isnan(metrics[m]));
}

TEST(test_symmetry) {
    double there[NQM_METRIC_COUNT], back[NQM_METRIC_COUNT];
    assert_int_equal(nqm_metrics_compute(pair.directions, pair.ref, pair.test, NULL, there, NULL), NQM_OK);
    assert_int_equal(nqm_metrics_compute(pair.directions, pair.test, pair.ref, NULL, back, NULL), NQM_OK);
    for (size_t m = 0; m < NQM_METRIC_COUNT; ++m)
        assert_relative(there[m], back[m], 1e-6);
}

TEST_FILE(read_metrics_pair, free_metrics_pair)
