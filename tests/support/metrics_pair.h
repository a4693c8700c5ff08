/* SPDX-License-Identifier: MIT
 *
 * metrics_pair.h - the sampled pair of tests/vectors/metrics_pair.csv, the input of vectors/metrics.py.
 */
#ifndef NQM_TESTS_SUPPORT_METRICS_PAIR_H
#define NQM_TESTS_SUPPORT_METRICS_PAIR_H

#include <nqm/samples.h>
#include <stdint.h>

enum { METRICS_PAIR_N = 60 };

/** One pair for all tests of a group. */
typedef struct metrics_pair {
    nqm_directions *directions;
    float ref[3 * METRICS_PAIR_N], test[3 * METRICS_PAIR_N]; /* (METRICS_PAIR_N, 3) */
    uint8_t used[METRICS_PAIR_N];
} metrics_pair;
extern metrics_pair pair;

/** Group fixtures of cmocka. */
int read_metrics_pair(void **state);
int free_metrics_pair(void **state);

#endif
