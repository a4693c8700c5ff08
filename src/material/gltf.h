/* SPDX-License-Identifier: MIT
 *
 * gltf.h - glTF 2.0 as the reader and the writer see it: the properties of materials, and the binary container.
 */
#ifndef NQM_SRC_MATERIAL_GLTF_H
#define NQM_SRC_MATERIAL_GLTF_H

#include "material/material.h"

/** What a property of the file is. */
typedef enum nqm_gltf_kind {
    NQM_GLTF_NUMBER,
    NQM_GLTF_COLOR,
    NQM_GLTF_BASE_COLOR, /**< RGB and alpha, which alphaMode interprets */
    NQM_GLTF_TEXTURE,    /**< refused, unless the factor of its layer is 0 */
    NQM_GLTF_ZERO,       /**< refused, unless 0 */
    NQM_GLTF_IGNORED     /**< has no effect without the other properties of the layer */
} nqm_gltf_kind;

typedef struct nqm_gltf_property {
    const char *name;
    nqm_gltf_kind kind;
    const char *key; /**< of the spec */
    double fallback; /**< value of a missing number by the specification, for the writer */
} nqm_gltf_property;

/** An object with properties: a JSON member of the material, or an extension. */
typedef struct nqm_gltf_group {
    const char *name;
    const char *why;                 /**< reason of a refusal, for properties of kind NQM_GLTF_ZERO */
    bool is_off_by_default;          /**< a missing first property is 0 */
    nqm_gltf_property properties[8]; /**< the first is the factor of the whole layer; ends with NULL */
} nqm_gltf_group;

/** pbrMetallicRoughness, and the extensions of materials. */
extern const nqm_gltf_group nqm_gltf_core;
enum { NQM_GLTF_N_EXTENSIONS = 11 };
extern const nqm_gltf_group nqm_gltf_extensions[NQM_GLTF_N_EXTENSIONS];

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
