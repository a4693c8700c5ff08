/* SPDX-License-Identifier: MIT
 *
 * gltf.h - glTF 2.0 as the reader and the writer see it: the properties of materials, and the binary container.
 */
#ifndef NQM_SRC_MATERIAL_GLTF_H
#define NQM_SRC_MATERIAL_GLTF_H

#include "io/json.h"
#include "material/rules.h"

/** An object with properties: a JSON member of the material, or an extension. */
typedef struct nqm_gltf_group {
    const char *name;
    nqm_rule rules[10];  /**< those with a key first */
    const char *refusal; /**< why materials with it are refused; NULL: they are read */
} nqm_gltf_group;

/** The members of a material itself, pbrMetallicRoughness and what may stand for it, and the other extensions. */
extern const nqm_gltf_group nqm_gltf_members, nqm_gltf_core, nqm_gltf_glossiness;
enum { NQM_GLTF_N_EXTENSIONS = 12 };
extern const nqm_gltf_group nqm_gltf_extensions[NQM_GLTF_N_EXTENSIONS];
/** Of baseColorFactor, of textures, of occlusionTexture, of iridescenceThicknessMinimum, and of glossinessFactor. */
nqm_rule_read nqm_gltf_read_base_color, nqm_gltf_read_texture, nqm_gltf_read_occlusion, nqm_gltf_read_minimum,
    nqm_gltf_read_glossiness;

enum { NQM_GLTF_N_ARRAYS = 5 };
/** The parts of a file that its textures refer to. */
typedef struct nqm_gltf_document {
    const char *path;
    nqm_json_source source;
    size_t source_at, root;            /**< of the JSON text in the file, and of the document in that */
    size_t bin_at, n_bin;              /**< the binary chunk in the file */
    json_t *arrays[NQM_GLTF_N_ARRAYS]; /**< those that are parsed */
    double film_minimum;               /**< iridescenceThicknessMinimum of the material */
    size_t n_decoded;                  /**< bytes of images so far */
    bool has_filter;                   /**< a sampler of such a texture has filters */
    bool has_other_set;                /**< a texture that was added has texture coordinates of a set other than 0 */
    char why[240];                     /**< why nqm_gltf_add_texture() failed */
} nqm_gltf_document;

/** Parse n bytes of text, which are at byte `at` of the source or a part of it with the same positions. */
NQM_MUST_CHECK nqm_status nqm_gltf_parse(const nqm_gltf_document *d, const char *text, size_t n, size_t at,
                                         json_t **value_ret, nqm_error *err);
/** Add the nodes of the texture `info`, a member `name` of a material or extension, to the maps; the shading has the factors. */
bool nqm_gltf_add_texture(nqm_gltf_document *d, const char *name, const json_t *info, nqm_reading *reading);
/** Free what has been read. */
void nqm_gltf_document_clear(nqm_gltf_document *d);

/** A property that a channel of a texture has. */
typedef struct nqm_gltf_use {
    const char *texture, *key, *space;
    size_t n, channel; /**< channels of the image, and the one that is used; SIZE_MAX: all */
} nqm_gltf_use;
enum { NQM_GLTF_N_USES = 11 };
extern const nqm_gltf_use nqm_gltf_uses[NQM_GLTF_N_USES];

/** Sizes and numbers of the container .glb. */
enum {
    NQM_GLTF_GLB_HEADER = 12,
    NQM_GLTF_CHUNK_HEADER = 8,
    NQM_GLTF_GLB_MAGIC = 0x46546C67,
    NQM_GLTF_JSON_CHUNK = 0x4E4F534A,
    NQM_GLTF_BIN_CHUNK = 0x004E4942
};

/** As nqm_material_format.write. */
NQM_MUST_CHECK nqm_status nqm_gltf_write(size_t n, const nqm_written_material *materials, const char *path,
                                         FILE *stream, nqm_error *err);

#endif
