/* SPDX-License-Identifier: MIT
 *
 * textured.h - pictures of textured materials, for labels and for the tool.
 */
#ifndef NQM_SRC_LABEL_TEXTURED_H
#define NQM_SRC_LABEL_TEXTURED_H

#include "base/base.h"
#include <nqm/render.h>
#include <nqm/texture.h>

/** How a texture lies on the shape, and how it is filtered. Take the defaults from nqm_scene_texture_view_default(). */
typedef struct nqm_texture_view {
    double tiles; /**< repeats of the texture coordinates 0 to 1 along u and v of the shape, to 10^6; default 1 */
    size_t
        n_samples; /**< texels whose radiance a point averages, 1 to 4096; default 4. 1: the texel at the point; more:
                           those nearest to positions that are stratified over the footprint of the point. That is its
                           pixel; without pixels, a square of the picture with the area that the point represents */
    uint64_t seed; /**< of these positions; default 1 */
    const nqm_texture *beside; /**< the other texture of the label: where its texels are finer, positions are their
                                    centres, so that both pictures have the same; default NULL: the own texels */
} nqm_texture_view;
nqm_texture_view nqm_scene_texture_view_default(void);

/** nqm_scene_render_halves() of a textured material; nqm_scene_compare_halves() makes labels of two pictures, which have the same
 *  positions if the views are equal. The far label, of textures that are smaller than a point, needs many tiles and samples: a metal
 *  with stripes of roughness .125 and .75 in 3072 points of a sphere differs from the mean of both by Delta-E 19 at 64 tiles (a point
 *  shows a third of a tile), 2.5 at 1024 tiles and 64 samples, 1.1 at 1024 tiles and 256 samples. A sample with a tilted normal
 *  has light directions of its own, about 0.1 ms. A constant texture gives the bits of nqm_scene_render_halves().
 *
 * @param view      NULL: the defaults
 * @param rgb_cdm2  (3, n_points, 3)
 * @return NQM_ERR_ARG (the view is out of range; the scene has interreflection), NQM_ERR_NUMERIC, NQM_ERR_CANCELLED, NQM_ERR_NOMEM, or
 *         the error of a texel whose properties make no BRDF */
NQM_MUST_CHECK nqm_status nqm_scene_render_texture(const nqm_scene *scene, const nqm_texture *texture,
                                                   const nqm_texture_view *view, double *rgb_cdm2, nqm_error *err);

#endif
