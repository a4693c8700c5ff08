/* SPDX-License-Identifier: MIT
 *
 * nqm/render.h - scenes in which BRDFs are compared: a lit shape, and the light that it reflects with any BRDF. In libnqm-full
 * only.
 */
#ifndef NQM_RENDER_H
#define NQM_RENDER_H

#include <nqm/brdf.h>

#ifdef __cplusplus
extern "C" {
#endif

/** A scene in which BRDFs are compared: a shape under a light, on a turntable, seen from far away (without
 *  perspective). The light and the viewer stand still. Immutable. */
typedef struct nqm_scene nqm_scene;

typedef struct nqm_scene_options {
    const char *light;    /**< latitude-longitude map: RGBE in PNG, OpenEXR or Radiance HDR; NULL: a built-in sky */
    const char *shape;    /**< "sphere", "blob" (a built-in smooth shape with hollows, which shadows itself), or a mesh
                               file (PLY, OBJ), which is centred and scaled to the picture; NULL: "sphere" */
    size_t width, height; /**< picture in pixels: every pixel that shows the shape is a point. 0 (default): n_points
                               instead, spread evenly over the pictures of all frames, which is quicker */
    size_t n_points;      /**< surface points in all, where width is 0; default 3072 */
    size_t n_frames;      /**< views of the turntable, evenly over 360 degrees; default 1 */
    double turn_rad;      /**< angle of the turntable in the first frame, its front to the right; default 0 */
    double elevation_rad; /**< of the viewer above the horizon of the light map, -pi/2 to pi/2; default 0 */
    size_t n_lights;      /**< light directions a point; 0 (default): 128, or 96 where width is not 0 */
    size_t light_width;   /**< the light map is filtered to light_width x light_width / 2 cells; a multiple of 16 up to
                               4096; default 256 */
    int shadows;          /**< 1: the shape keeps light from itself; default 1 */
    int interreflection;  /**< 1: light that the shape reflects once onto itself; default 0 */
    double exposure_cdm2; /**< luminance at which a white Lambert surface shows on average over the points, with no
                               shadows and no interreflection; default 200 */
    double peak_cdm2;     /**< display peak; brighter is clipped; default 1000 */
    uint64_t seed;        /**< default 1 */
} nqm_scene_options;

/** The defaults above. */
NQM_API nqm_scene_options nqm_scene_options_default(void);
/** Light directions a point: n_lights, or what 0 stands for. */
NQM_API size_t nqm_scene_options_lights(const nqm_scene_options *options);
/** Make a scene; options NULL: the defaults. Every visible point gets light directions of its own, and what shadows
 *  leave of their light, once: the balance heuristic of multiple importance sampling (Veach and Guibas 1995, DOI
 *  10.1145/218380.218498) over light map, mirror lobes of five widths and cosine. NQM_ERR_ARG (an option is out of its
 *  range; a shape other than the sphere in a build without Embree), or what reading the light map or mesh gives. */
NQM_API NQM_MUST_CHECK nqm_status nqm_scene_create(const nqm_scene_options *options, nqm_scene **scene_ret,
                                                   nqm_error *err);
/** Free a scene; NULL is allowed. */
NQM_API void nqm_scene_free(nqm_scene *scene);
/** Number of surface points, of all frames together. */
NQM_API size_t nqm_scene_count(const nqm_scene *scene);
/** Light reflected at each point: rgb_cdm2 (n_points, 3), before the clip at the display's peak. All BRDFs share points
 *  and light directions, so that equal BRDFs give equal pictures to the bit. Deterministic. */
NQM_API NQM_MUST_CHECK nqm_status nqm_scene_render(const nqm_scene *scene, const nqm_brdf *brdf, double *rgb_cdm2,
                                                   nqm_error *err);
/** The share of the picture for which each point stands: (n_points), summing to 1. Only for scenes of a mesh or blob
 *  without a width, where points are denser in possible highlights; NULL otherwise: all alike. Lent by the scene. */
NQM_API const double *nqm_scene_shares(const nqm_scene *scene);
/** Where the points lie: index (n_points) = (frame * height + y) * width + x, first row on top. Only for scenes with a
 *  width; NULL otherwise. Lent by the scene. */
NQM_API const size_t *nqm_scene_pixels(const nqm_scene *scene);
/** The light map behind the shape in any frame, in a view 60 degrees high: rgb_cdm2 (height, width, 3). Only for scenes
 *  with a width. */
NQM_API void nqm_scene_background(const nqm_scene *scene, double *rgb_cdm2);

#ifdef __cplusplus
}
#endif
#endif
