/* SPDX-License-Identifier: MIT
 *
 * tiny_model.h - a model with random weights, for tests that need one whatever is built in. What it scores means nothing,
 * except that equal pairs are equal.
 */
#ifndef NQM_TESTS_TINY_MODEL_H
#define NQM_TESTS_TINY_MODEL_H

#include "metric/metric.h"

/** A model of n directions; nqm_model_free() it. */
nqm_status make_tiny_model(size_t n, nqm_model **model_ret, nqm_error *err);

#endif
