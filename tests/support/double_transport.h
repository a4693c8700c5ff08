/* SPDX-License-Identifier: MIT
 *
 * double_transport.h - transport matrices of random light, and the label of two sampled BRDFs in plain double.
 */
#ifndef NQM_TESTS_DOUBLE_TRANSPORT_H
#define NQM_TESTS_DOUBLE_TRANSPORT_H

#include "metric/metric.h"

/** A matrix of double_features.h's directions with n_points in n_scenes; free its arrays with drop_transport(). The light of a
 *  BRDF of 1 / sr is about 300 cd/m2. peak_cdm2: of the displays, times 1, 2, ... in the scenes. */
nqm_transport make_transport(size_t n_points, size_t n_scenes, double peak_cdm2);
void drop_transport(nqm_transport *transport);

/** The label of samples f (reference) and g (DOUBLE_VALUES). Where `used` is 0, g counts as f. */
nqm_label double_label(const nqm_transport *transport, const double *f, const double *g, const uint8_t *used);

#endif
