/* SPDX-License-Identifier: MIT
 *
 * usda.h - a layer of USD (usda.c), of which usda_material.c makes materials.
 */
#ifndef NQM_SRC_MATERIAL_USDA_H
#define NQM_SRC_MATERIAL_USDA_H

#include "io/xml.h"
#include "material/material.h"

/** The property that names what a prim is composed of and this layer does not have. */
#define NQM_USDA_EXTERNAL "info:external"

enum { NQM_USDA_MAX_DEPTH = 60, NQM_USDA_MAX_TEXT = 1024 };

/** Prims are elements named by their type: "Shader"; "prim" has none, "class:Shader" is a class, "over" is one. Attributes: name; until
 *  the prim is composed, arcs: the paths that it is composed of, the strongest first, each with a blank after it. Properties are
 *  elements of a prim, named by their type. Attributes: name ("inputs:a", "inputs:a.connect", "inputs:a.timeSamples": the first
 *  sample), which alone has a ':'; space, of the metadata; value, "" for None, absent if the property is declared only. */
typedef struct nqm_usda {
    const char *path; /**< of the file */
    nqm_xml prims;
    nqm_index names; /**< of all elements but the root */
    size_t max_elements;
    nqm_status status;
    nqm_error *err;
} nqm_usda;

/** The prim that "/Looks/M/tex.outputs:rgb", or a path relative to `base`, begins with; NULL: there is none. *property_ret: the name of
 *  the property; NULL: it has none. */
const nqm_xml_element *nqm_usda_find(const nqm_usda *layer, const nqm_xml_element *base, const char *path,
                                     const char **property_ret);
/** The path of a prim; "" if it is long. */
void nqm_usda_path(const nqm_xml_element *prim, char path[NQM_USDA_MAX_TEXT]);
/** Append the materials of a layer that is composed. */
NQM_MUST_CHECK nqm_status nqm_usda_add_materials(const nqm_usda *layer, nqm_materials *materials);

#endif
