/* SPDX-License-Identifier: MIT
 *
 * pbrt.h - parameters of pbrt-v4 materials that are colours or textures.
 */
#ifndef NQM_SRC_MATERIAL_PBRT_H
#define NQM_SRC_MATERIAL_PBRT_H

#include "material/bsdf.h"

enum { NQM_PBRT_MAX_TOKEN = 256 };

/** The value of a parameter that is a constant, a metal or a texture: n = 1 of type float, 3 of type spectrum. missing (n): when it is
 *  not given. */
bool nqm_pbrt_value(nqm_bsdf_reading *r, const char *name, size_t n, const double *missing, uint16_t *value_ret);
/** The rule for the normal map, RGB of a file. */
nqm_rule_read nqm_pbrt_normal_map;

#endif
