/* SPDX-License-Identifier: MIT
 *
 * random_network.h - numbers and parameters that scripts of tests/vectors make too.
 */
#ifndef NQM_TESTS_RANDOM_NETWORK_H
#define NQM_TESTS_RANDOM_NETWORK_H

#include "net/net.h"

/** In [0, 1). */
double random_unit(uint64_t *seed);
/** n numbers in [-range, range]. */
void fill_random(uint64_t *seed, size_t n, double range, float *to);
/** Parameters of a network with random biases, gamma and beta too. */
void make_random_params(const nqm_net_shape *shape, uint64_t seed, nqm_params *params);

#endif
