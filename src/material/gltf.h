/* SPDX-License-Identifier: MIT
 *
 * gltf.h - glTF 2.0 as the reader and the writer see it: the properties of materials, and the binary container.
 */
#ifndef NQM_SRC_MATERIAL_GLTF_H
#define NQM_SRC_MATERIAL_GLTF_H

#include "material/rules.h"

/** An object with properties: a JSON member of the material, or an extension. */
typedef struct nqm_gltf_group {
    const char *name;
    const char *refusal; /**< why materials with it are refused; NULL: they are read */
    nqm_rule rules[8];   /**< those with a key first */
} nqm_gltf_group;

/** The members of a material itself, pbrMetallicRoughness, and the extensions. */
extern const nqm_gltf_group nqm_gltf_members, nqm_gltf_core;
enum { NQM_GLTF_N_EXTENSIONS = 13 };
extern const nqm_gltf_group nqm_gltf_extensions[NQM_GLTF_N_EXTENSIONS];
/** Of baseColorFactor, of textures, and of occlusionTexture. */
nqm_rule_read nqm_gltf_read_base_color, nqm_gltf_read_texture, nqm_gltf_read_occlusion;

/** Sizes and numbers of the container .glb. */
enum {
    NQM_GLTF_GLB_HEADER = 12,
    NQM_GLTF_CHUNK_HEADER = 8,
    NQM_GLTF_GLB_MAGIC = 0x46546C67,
    NQM_GLTF_JSON_CHUNK = 0x4E4F534A
};

/** As nqm_material_format.write. */
NQM_MUST_CHECK nqm_status nqm_gltf_write(size_t n, const nqm_named_shading *materials, const char *path, FILE *stream,
                                         nqm_error *err);

#endif
