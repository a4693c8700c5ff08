/* SPDX-License-Identifier: MIT
 *
 * nqm/material.h - the material files of renderers: list the materials of a file, and write one.
 *
 * nqm_brdf_open() opens a material as "FILE" or, in a file of several, as "FILE:NAME". A material becomes the spec of a
 * shading model, whose keys are the properties of the file (doc/materials.md). A material with a property that the spec
 * does not have, such as transmission, is refused, and the refusal names the property. "ignore:WORDS:FILE:NAME" opens
 * what of it reflects; WORDS are some of transmission, subsurface, emission, opacity, displacement and bump, separated by commas. A
 * material with image maps has no BRDF either, but it is a texture (<nqm/texture.h>).
 */
#ifndef NQM_MATERIAL_H
#define NQM_MATERIAL_H

#include <nqm/base.h>

#ifdef __cplusplus
extern "C" {
#endif

/** The materials of a file. Immutable; any thread. */
typedef struct nqm_materials nqm_materials;

/** One of them. The strings belong to the nqm_materials. */
typedef struct nqm_material_info {
    const char *name;    /**< name in the file; "material1", ... for materials without a name */
    const char *surface; /**< the shading model, as the file calls it: "open_pbr_surface" */
    const char
        *spec; /**< argument of nqm_brdf_open(): a spec, or a path relative to the file's folder; NULL: refused */
    const char *refusal; /**< the property that cannot be honoured, and why; NULL: the material is accepted */
    size_t
        n_maps; /**< image maps of a material that nqm_texture_open() takes; 0: none. `refusal` has the property that varies */
    const char *remark; /**< what of the file is not used although it may matter, or is assumed; NULL: nothing */
    const char *
        unused; /**< names of what it gives without effect on a BRDF, or on this one: "doubleSided; clearcoatTexture"; NULL: none */
    int64_t byte_offset;   /**< position of the material or of the refused property in the file; -1: unknown */
    const char *ignorable; /**< what the surface does besides reflecting, if the material is refused for that alone:
                                "transmission,opacity"; nqm_brdf_open() takes "ignore:transmission,opacity:FILE:NAME". NULL: not so */
    const char
        *reflection; /**< spec of what reflects when that is ignored; NULL: as `ignorable`, or image maps change it */
} nqm_material_info;

/**
 * Read the materials of a file, in its order. The format is recognised by the content.
 *
 * @param materials_ret  receives the materials; free with nqm_materials_free()
 * @return NQM_ERR_IO, NQM_ERR_FORMAT (malformed, not a material file, or without any material), NQM_ERR_LIMIT, NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_materials_open(const char *path, nqm_materials **materials_ret, nqm_error *err);
/** Material i; its name is NULL if there are fewer. */
NQM_API nqm_material_info nqm_materials_get(const nqm_materials *materials, size_t i);
/** Free; NULL is allowed. */
NQM_API void nqm_materials_free(nqm_materials *materials);

#ifdef __cplusplus
}
#endif
#endif
