/* SPDX-License-Identifier: MIT
 *
 * anisotropy.h - the anisotropic lobe of the base of shading models, in their own keys.
 */
#ifndef NQM_SRC_FIT_ANISOTROPY_H
#define NQM_SRC_FIT_ANISOTROPY_H

#include "base/base.h"
#include "schema/schema.h"
#include <nqm/brdf.h>

/** Whether a model has anisotropic lobes, and a key of their azimuth. */
bool nqm_fit_can_be_anisotropic(const nqm_schema *schema, bool needs_azimuth);
/** Set the keys of `to` so that the lobe of its base has the anisotropy of that of `from`, which is a canonical spec;
 *  keys that say how are 0 where the model of `to` cannot have it. */
void nqm_fit_copy_anisotropy(const nqm_values *from, nqm_values *to);
/** A spec with the anisotropy of the lobe of a BRDF, along the axes of the model if that is turned by other means; nqm_free() it.
 *  NULL: the BRDF is isotropic, or the model has no anisotropic lobes. */
char *nqm_fit_measure_anisotropy(const nqm_brdf *ref, const nqm_schema *schema, bool is_turned);

#endif
