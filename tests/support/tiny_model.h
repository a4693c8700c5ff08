/* SPDX-License-Identifier: MIT
 *
 * tiny_model.h - a model with random weights, for tests that must not depend on the built-in models. Its scores have no
 * meaning, except that equal BRDFs are reported as identical.
 */
#ifndef NQM_TESTS_TINY_MODEL_H
#define NQM_TESTS_TINY_MODEL_H

#include "metric/metric.h"

/** A model with n directions; free with nqm_model_free(). */
nqm_status make_tiny_model(size_t n, nqm_model **model_ret, nqm_error *err);

#endif
