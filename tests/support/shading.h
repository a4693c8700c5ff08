/* SPDX-License-Identifier: MIT
 *
 * shading.h - checks of shading models, by the specs of their BRDFs.
 */
#ifndef NQM_TESTS_SHADING_H
#define NQM_TESTS_SHADING_H

#include "support/check.h"

/** A file of tests/vectors with n_rows and the columns spec, wi, wo, r, g, b, which are met within both tolerances together. Returns the
 *  largest relative difference of f_r(wi, wo) from f_r(wo, wi). */
double check_shading_vectors(const char *name, size_t n_rows, double relative, double absolute);
/** f_r(wi, wo) = f_r(wo, wi) to rounding, at 200 random pairs. */
void check_shading_reciprocity(const char *spec);
int is_shading_reciprocal(const char *spec);
/** The largest albedo of the channels for light at the polar angle theta (radians), to about 1 percent for roughness above 0.3. */
double shading_albedo(const char *spec, double theta);

#endif
