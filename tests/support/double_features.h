/* SPDX-License-Identifier: MIT
 *
 * double_features.h - pairs of samples, and the scalar features of samples in plain double, for central differences: the library
 * reads float samples, which are too coarse.
 */
#ifndef NQM_TESTS_DOUBLE_FEATURES_H
#define NQM_TESTS_DOUBLE_FEATURES_H

#include "metric/metric.h"

/** More than a stretch (metric/sums.c), the last one incomplete. */
enum { DOUBLE_N = 150, DOUBLE_VALUES = 3 * DOUBLE_N };

/** Of all pairs here. Group fixtures of cmocka. */
extern nqm_directions *directions;
int make_double_directions(void **state);
int free_double_directions(void **state);

typedef struct gradient_pair {
    float ref[DOUBLE_VALUES], test[DOUBLE_VALUES];
    uint8_t used[DOUBLE_N];
} gradient_pair;

/** A diffuse part and a lobe; in no direction and channel equal to the test, and the luminance is not either, since
 *  differences across a kink have no meaning. Direction `largest` differs most and is the brightest of the test. */
gradient_pair make_pair(uint64_t seed, double strength, size_t largest);
/** In [0, 1). */
double random_unit(uint64_t *seed);

/** Features before NQM_SCALAR_ESTIMATE of samples f (reference) and g (directions->n, 3), n <= 320; x (NQM_SCALAR_ESTIMATE). */
void features_of(const double *f, const double *g, const uint8_t *used, double *x);
void to_double(const float *from, double *to);

#endif
