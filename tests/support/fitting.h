/* SPDX-License-Identifier: MIT
 *
 * fitting.h - fit a spec with another model, and compare the values of two specs.
 */
#ifndef NQM_TESTS_SUPPORT_FITTING_H
#define NQM_TESTS_SUPPORT_FITTING_H

#include <nqm/fit.h>

struct nqm_fit_target; /* fit.h */

/** Fit `model` to the BRDF `spec`; the test fails if the fit fails. */
nqm_fit_report fit_spec(const char *spec, const char *model, const nqm_fit_options *options);
/** The loss of a spec at the directions of a target. */
double loss_of_spec(const struct nqm_fit_target *target, const char *spec);
/** nqm_fit() from each of n random values of an analytic model (nqm_fit_path()); the best result. */
nqm_fit_report fit_from_random(const char *spec, const char *model, const nqm_fit_options *options, size_t n);
/** The values after "key=" in a spec, up to three; a single value is repeated for all three channels. */
void spec_values(const char *spec, const char *key, double v[3]);
/** Check that every value of `key` in both specs agrees within `tolerance` times the truth plus 1e-4. */
void check_spec_values(const char *fitted, const char *truth, const char *key, double tolerance);

#endif
