/* SPDX-License-Identifier: MIT
 *
 * texture.h - textured materials inside the library: nodes evaluated texel by texel, different texels, mean BRDFs. The public
 * functions are declared in <nqm/texture.h>.
 */
#ifndef NQM_SRC_TEXTURE_H
#define NQM_SRC_TEXTURE_H

#include "material/maps.h"
#include <nqm/texture.h>

/** The BRDF at a position of the surface, and its normal (unit vector: tangent, which is the direction of u; bitangent; normal). u
 *  to the right and v downwards, 0 to 1 over the texture, which is repeated. Any thread. */
NQM_MUST_CHECK nqm_status nqm_texture_at(const nqm_texture *texture, double u, double v, nqm_brdf **brdf_ret,
                                         double normal[3], nqm_error *err);

#endif
