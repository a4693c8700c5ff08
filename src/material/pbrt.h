/* SPDX-License-Identifier: MIT
 *
 * pbrt.h - parameters of pbrt-v4 materials that are colours or textures.
 */
#ifndef NQM_SRC_MATERIAL_PBRT_H
#define NQM_SRC_MATERIAL_PBRT_H

#include "material/bsdf.h"

enum { NQM_PBRT_MAX_TOKEN = 256 };

/** A constant colour, also by the name of a metal; `v` keeps its value when the parameter is not given. */
bool nqm_pbrt_colour(nqm_bsdf_reading *r, const char *name, double v[3]);
/** The value of a parameter of the material that is a texture: n = 1 of type float, 3 of type spectrum. */
bool nqm_pbrt_map(nqm_bsdf_reading *r, const nqm_bsdf_node *node, size_t n, uint16_t *value_ret);
/** The value of a parameter that is a texture or a constant; `missing`: when it is not given. */
bool nqm_pbrt_operand(nqm_bsdf_reading *r, const char *name, size_t n, double missing, uint16_t *value_ret);
/** The rule for the normal map, RGB of a file. */
nqm_rule_read nqm_pbrt_normal_map;

#endif
