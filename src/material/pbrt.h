/* SPDX-License-Identifier: MIT
 *
 * pbrt.h - the materials and textures of a pbrt-v4 scene, read into a list of nodes, and their translation to shadings.
 */
#ifndef NQM_SRC_MATERIAL_PBRT_H
#define NQM_SRC_MATERIAL_PBRT_H

#include "material/bsdf.h"

/** true when the first word is a directive of pbrt. */
bool nqm_pbrt_probe(const nqm_map *map);
/** Append the materials of a scene. NQM_ERR_FORMAT, NQM_ERR_LIMIT, NQM_ERR_NOMEM */
NQM_MUST_CHECK nqm_status nqm_pbrt_read(const nqm_map *map, nqm_materials *materials, nqm_error *err);
/** What is read of a scene. */
typedef struct nqm_pbrt_scene {
    const char *path;
    nqm_bsdf_nodes nodes; /**< the textures so far, then the material that is being read, each with its parameters */
    nqm_index names;      /**< of textures and materials */
    nqm_materials *materials;
} nqm_pbrt_scene;
/** The node of a "float" or "spectrum" texture, or the number of a "material"; SIZE_MAX: there is none of this name. */
size_t nqm_pbrt_find(const nqm_index *names, const char *kind, const char *name);
/** Append the material of this type at node `at`, after the textures that it can name. refusal: why it is refused; NULL: it is not. */
NQM_MUST_CHECK nqm_status nqm_pbrt_add(const nqm_pbrt_scene *scene, size_t at, const char *type, const char *refusal,
                                       nqm_error *err);

#endif
