/* SPDX-License-Identifier: MIT
 *
 * nqm/translate.h - materials as materials of another shading model: shared properties are copied, the others fitted. NQM_EXPERIMENTAL.
 * In libnqm-full only. Any thread.
 */
#ifndef NQM_TRANSLATE_H
#define NQM_TRANSLATE_H

#include <nqm/match.h>
#include <nqm/texture.h>

#ifdef __cplusplus
extern "C" {
#endif

/** A translation. */
typedef struct nqm_translation {
    nqm_match_report match;     /**< match.fit.spec is the result; of a texture, that of its constant properties */
    char copied[2048];          /**< spec of the properties that both models have; "": none */
    char dropped[300];          /**< properties of the source without counterpart, separated by ", " */
    nqm_texture_result texture; /**< of a texture: the score of what was written */
} nqm_translation;

/** A shading model to which materials are translated. */
typedef struct nqm_translate_model {
    const char *name;  /**< "gltf"; NULL: there are fewer models */
    const char *alias; /**< another name, "openpbr"; NULL: none */
    const char *about; /**< what it is, "OpenPBR Surface" */
    char extension[8]; /**< of the first format that holds its materials, ".gltf" */
} nqm_translate_model;

/** Model i of them. */
NQM_API nqm_translate_model nqm_translate_target(size_t i);

/**
 * Translate a BRDF to a shading model: a fit as nqm_match(), which "auto" starts from the copied properties or, without
 * these, from the anisotropy of the highlight. Of the fit and the copied properties the one with the higher JOD by
 * loss->metric is the result.
 *
 * @param ref      any BRDF; properties are copied where its spec is that of a shading model
 * @param model    a name of nqm_translate_target(), or its other name
 * @param path     the material file to write, whose extension is checked before the fit; NULL: none
 * @param name     of the material in the file; NULL: "material"
 * @param loss     as in nqm_match(); `metric` is needed
 * @param options  as in nqm_match(); NULL: defaults
 * @return as nqm_match(); NQM_ERR_ARG also for another model, with the names, and a path whose extension is not
 *         that of a format of the model; NQM_ERR_IO
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_translate(const nqm_brdf *ref, const char *model, const char *path,
                                                const char *name, const nqm_match_loss *loss,
                                                const nqm_fit_options *options, nqm_translation *result,
                                                nqm_error *err);

/**
 * Translate a material with image maps to glTF with PNG files beside it, and score what was written, near and far.
 * Shared properties are copied texel by texel; fits to 16 texels correct them, and the constant properties.
 *
 * @param path  of the file, which ends in ".gltf"; maps are PATH without its ending, "_", the texture, ".png". All files are
 *              replaced together, or none
 * @param name  of the material in the file
 * @return as nqm_translate(); NQM_ERR_ARG for another path, NQM_ERR_IO
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_translate_texture(const nqm_texture *ref, const char *path, const char *name,
                                                        const nqm_match_loss *loss, const nqm_fit_options *options,
                                                        nqm_translation *result, nqm_error *err);

#ifdef __cplusplus
}
#endif
#endif
