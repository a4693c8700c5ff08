/* SPDX-License-Identifier: MIT
 *
 * double_network.h - the network in plain loops of double, the paper's formulas.
 */
#ifndef NQM_TESTS_DOUBLE_NETWORK_H
#define NQM_TESTS_DOUBLE_NETWORK_H

#include "net/net.h"

/** z (n_outputs), before the sigmoid, of inputs x; layers are at most 2048 wide. */
void double_network(const nqm_params *params, const double *x, double *z);
/** Parameters of a network with random biases, gamma and beta too. */
void make_random_params(const nqm_net_shape *shape, uint64_t seed, nqm_params *params);

#endif
