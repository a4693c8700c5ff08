/* SPDX-License-Identifier: MIT
 *
 * nqm/texture.h - scores of materials whose properties vary over a surface by image maps: near, where the texels are seen, and far,
 * where they are smaller than a pixel; which map is to blame. NQM_EXPERIMENTAL.
 *
 * Delta-E ITP of a picture is a mean over its pixels, so the Delta-E of two textured materials that are seen from near
 * is the mean over the texels of the Delta-E of both BRDFs there (doc/textures.md).
 */
#ifndef NQM_TEXTURE_H
#define NQM_TEXTURE_H

#include <nqm/brdf.h>
#include <nqm/model.h>
#include <nqm/percept.h>

#ifdef __cplusplus
extern "C" {
#endif

/** A textured material with its decoded maps. Immutable; any thread. */
typedef struct nqm_texture nqm_texture;

/** Facts about one. The strings belong to the nqm_texture. */
typedef struct nqm_texture_info {
    const char *name;     /**< the argument of nqm_texture_open() */
    const char *model;    /**< the shading model: "gltf"; of a BRDF that is none of a shading model its format */
    size_t width, height; /**< texels of one period of the texture; 1 and 1: it does not vary */
    size_t n_images;      /**< image maps */
    size_t n_bytes;       /**< of the decoded maps */
    const char
        *varying; /**< the properties that maps change, separated by blanks: "base_color roughness normal"; "": none */
    const char *remark; /**< what of the file or folder is not used or assumed: "not used: a_ao.png"; "": nothing */
} nqm_texture_info;

/**
 * Open a textured material and decode its maps: "FILE" or "FILE:MATERIAL" of a renderer's material file
 * (<nqm/material.h>); a folder of maps, or "maps:base_color=a.png;roughness=b.png;model=gltf" (doc/textures.md). Any
 * other argument of nqm_brdf_open() is a texture of one texel.
 *
 * @param progress  called while maps are decoded; NULL: silent
 * @return NQM_ERR_ARG, NQM_ERR_IO (a map is missing; the message names map and material), NQM_ERR_FORMAT (malformed, refused, or a map
 *         is no picture that is read), NQM_ERR_LIMIT, NQM_ERR_CANCELLED, NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_texture_open(const char *argument, nqm_progress_fn progress, void *progress_user,
                                                   nqm_texture **texture_ret, nqm_error *err);

/** One map of the caller. */
typedef struct nqm_texture_map {
    const char *key;      /**< a property of the model, or "normal": tangent-space vectors, y up */
    size_t height, width; /**< of the map */
    size_t channels;      /**< 1 or 3, as the property has; 3 for "normal" */
    const float *values; /**< (height, width, channels), copied; colours linear BT.709, normals of any length above 0 */
} nqm_texture_map;

/** Make a textured material of arrays. base: spec of a shading model, with the values of other properties ("gltf:metallic=1").
 *  NQM_ERR_ARG (no such property, or a value that is not finite), NQM_ERR_LIMIT (a side above 16384), NQM_ERR_NOMEM */
NQM_API NQM_MUST_CHECK nqm_status nqm_texture_create(const char *base, size_t n_maps, const nqm_texture_map *maps,
                                                     nqm_texture **texture_ret, nqm_error *err);
/** Free; NULL is allowed. */
NQM_API void nqm_texture_free(nqm_texture *texture);
/** Facts about one; beside another one (NULL: alone), width and height are those at which nqm_texture_score() compares them. */
NQM_API nqm_texture_info nqm_texture_get_info(const nqm_texture *texture, const nqm_texture *beside);

/** How nqm_texture_score() works. Take the defaults from nqm_texture_options_default(). */
typedef struct nqm_texture_options {
    int exact; /**< 1: every different pair of texels is scored; default 0: at most n_texels, drawn evenly from all */
    size_t
        n_texels; /**< 16 to 10^6; default 2048. Half as many (a quarter where normals differ) if their error is below .01 JOD */
    size_t
        texels_per_pixel; /**< along each side of the pixels whose BRDFs, means over their texels, are compared, 1 to 16384;
                                   then 256 pixels (48 where normals vary) are drawn, and n_texels and exact do not count;
                                   default 1: the texels are compared */
    int blame;            /**< 1: each map is exchanged alone; default 1 */
    int far;              /**< 1: the far score too; default 1 */
    uint64_t seed;        /**< of the choice of texels; default 1 */
    nqm_progress_fn progress; /**< NULL (default): silent */
    void *progress_user;
} nqm_texture_options;
NQM_API nqm_texture_options nqm_texture_options_default(void);

/** What the exchange of one property alone changes. */
typedef struct nqm_texture_blame {
    char key[48]; /**< the property, or "normal" */
    double jod;   /**< near score of the reference with this property of the test; 10: no difference */
    char mistake
        [80]; /**< what the test did with the map, if that is one of the mistakes that are known: "roughness is squared";
                           "": none of them */
} nqm_texture_blame;

enum { NQM_TEXTURE_MAX_BLAME = 32 };

/** The score of a pair of textured materials. */
typedef struct nqm_texture_result {
    double jod, jod_low,
        jod_high;         /**< near: of the mean Delta-E over the texels, and its 95 % interval (as of nqm_score()) */
    double delta_e;       /**< that mean */
    double error;         /**< standard error of jod by the choice of texels; 0: all were scored */
    nqm_label parts;      /**< means of the predicted parts; NaN if the model does not predict them */
    double median, worst; /**< JOD of the median texel, and of the 5 % of texels with the largest Delta-E at least */
    double below[2];      /**< shares of texels below JOD 9 and 8 */
    double far_jod[3]; /**< JOD of the mean BRDFs, with the spread of their normals, and both ends of its interval; NaN:
                                        not wanted */
    double far_delta_e;
    size_t width, height;    /**< texels that are compared */
    size_t n_different;      /**< different pairs among them, as far as they are told apart */
    size_t n_scored;         /**< pairs that were scored, of texels or of pixels */
    size_t texels_per_pixel; /**< that of the options */
    size_t n_blame;          /**< worst first; 0: the materials have different models */
    nqm_texture_blame blame[NQM_TEXTURE_MAX_BLAME];
} nqm_texture_result;

/**
 * Score a textured material beside its reference. Textures of different sizes are compared at the finer size, with bilinear
 * interpolation.
 *
 * @param model    a model that predicts Delta-E
 * @param options  NULL: the defaults
 * @param delta_e  (height, width) of the finer texture receives the Delta-E of each texel, first row on top; NULL: not wanted.
 *                 nqm_texture_get_info() tells the size
 * @return NQM_ERR_ARG, NQM_ERR_INCOMPATIBLE (a texel cannot be compared), NQM_ERR_CANCELLED, NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_texture_score(const nqm_model *model, const nqm_texture *ref,
                                                    const nqm_texture *test, const nqm_texture_options *options,
                                                    nqm_texture_result *result_ret, float *delta_e, nqm_error *err);

#ifdef __cplusplus
}
#endif
#endif
