/* SPDX-License-Identifier: MIT
 *
 * materialx.h - the surface shaders of MaterialX that are read and written, with their inputs.
 */
#ifndef NQM_SRC_MATERIAL_MATERIALX_H
#define NQM_SRC_MATERIAL_MATERIALX_H

#include "material/rules.h"

typedef struct nqm_mtlx_surface {
    const char *node;       /**< "open_pbr_surface" */
    const char *model;      /**< "open-pbr" */
    const nqm_rule *inputs; /**< with the defaults of the definition; types "float", "color3" and "integer" */
} nqm_mtlx_surface;

enum { NQM_MTLX_N_SURFACES = 5 };
extern const nqm_mtlx_surface nqm_mtlx_surfaces[NQM_MTLX_N_SURFACES];

/** A key of the shading; a normal, which must be 0, 0, 1; a tangent, which is refused; occlusion. */
nqm_rule_read nqm_mtlx_read_key, nqm_mtlx_read_normal, nqm_mtlx_read_tangent, nqm_mtlx_read_occlusion;

#endif
