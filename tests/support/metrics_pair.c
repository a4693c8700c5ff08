/* SPDX-License-Identifier: MIT
 *
 * Reads the pair of metrics_pair.h.
 */
#include "support/metrics_pair.h"
#include "sample/sample.h"
#include "support/check.h"

metrics_pair pair;

int read_metrics_pair(void **state) {
    (void)state;
    assert_int_equal(nqm_directions_load_csv(test_vector("metrics_pair.csv"), &pair.directions, NULL), NQM_OK);
    nqm_csv *csv;
    assert_int_equal(nqm_csv_load(test_vector("metrics_pair.csv"), &csv, NULL), NQM_OK);
    assert_int_equal(nqm_csv_rows(csv), METRICS_PAIR_N);
    for (size_t i = 0; i < METRICS_PAIR_N; ++i) {
        for (int k = 0; k < 3; ++k) {
            pair.ref[3 * i + (size_t)k] = (float)csv_number(csv, i, 3 + k);
            pair.test[3 * i + (size_t)k] = (float)csv_number(csv, i, 6 + k);
        }
        pair.used[i] = csv_number(csv, i, 9) != 0;
    }
    nqm_csv_free(csv);
    return 0;
}

int free_metrics_pair(void **state) {
    (void)state;
    nqm_directions_free(pair.directions);
    return 0;
}
