/* SPDX-License-Identifier: MIT
 *
 * recorded.h - pairs of samples for which tests/vectors/metric_torch.py has recorded what nqm.torch.Metric says in double: values,
 * and how they change along given changes of the test.
 */
#ifndef NQM_TESTS_RECORDED_H
#define NQM_TESTS_RECORDED_H

#include "metric/metric.h"

/** Directions: more than a stretch (metric/sums.c), the last one incomplete. */
enum { PAIR_N = 150, PAIR_VALUES = 3 * PAIR_N, N_WAYS = 12 };
/** The pairs by number; _K: the differences are about this large. */
enum {
    PAIR_002,
    PAIR_02,
    PAIR_1,
    PAIR_UNUSED, /* some directions, among them the first zone */
    PAIR_ZEROS,
    PAIR_EQUAL,
    PAIR_MAXIMA,       /* direction 10 differs a little more than 100 and is a little brighter */
    PAIR_OTHER_MAXIMA, /* and a little less */
    PAIR_0002,
    PAIR_005,
    PAIR_06, /* without every 13th direction */
    N_PAIRS_RECORDED
};

/** Of all pairs here. Group fixtures of cmocka. */
extern nqm_directions *directions;
int make_recorded_directions(void **state);
int free_recorded_directions(void **state);

typedef struct gradient_pair {
    float ref[PAIR_VALUES], test[PAIR_VALUES];
    uint8_t used[PAIR_N];
} gradient_pair;

gradient_pair recorded_pair(size_t number);

/** Copy an array of metric_torch.safetensors. */
void get_recorded(const char *name, size_t n_bytes, void *to);
/** Compare a gradient (PAIR_VALUES) with recorded slopes (N_WAYS), within `tolerance` of its norm. only: NULL, or the values that count
 *  are those where it is above 0. Returns the error relative to the norm. */
double check_slopes(const char *what, const float *gradient, const double *slopes, const float *only, double tolerance);

/** A transport matrix of n_points in n_scenes with random light; free its arrays with drop_transport(). The light of a BRDF of
 *  1 / sr is about 300 cd/m2. peak_cdm2: of the displays, times 1, 2, ... in the scenes. */
nqm_transport make_transport(size_t n_points, size_t n_scenes, double peak_cdm2);
void drop_transport(nqm_transport *transport);

#endif
