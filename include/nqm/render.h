/* SPDX-License-Identifier: MIT
 *
 * nqm/render.h - scenes for comparing BRDFs: a shape under a light map, and the light that it reflects with any BRDF. In
 * libnqm-full only.
 */
#ifndef NQM_RENDER_H
#define NQM_RENDER_H

#include <nqm/brdf.h>

#ifdef __cplusplus
extern "C" {
#endif

/** A shape on a turntable under a light map, seen by an orthographic viewer, or the standard set of four such scenes. Light and
 *  viewer are fixed. Immutable; may be used by several threads at once.
 *
 *  The standard set (neither light nor shape is given) is what the built-in model "default" predicts: a blob under a low sun,
 *  a sphere on an overcast day, a sphere in a studio, a blob in a room with windows. Its points are those of the four scenes
 *  one after the other, and each scene has a quarter of the weight.
 *
 *  The tangent of a surface, to which anisotropic BRDFs refer, is horizontal, as on a turned workpiece: the cross product of the upward
 *  direction and the normal (to the viewer's right where the normal is vertical).
 *
 *  Texture coordinates follow from the unit direction (x, y, z) from the centre of the shape, in the axes of the shape:
 *  u = 1/2 + atan2(x, z) / (2 pi), v = acos(y) / pi, downwards from the upper pole. So the seam is at the back of the first frame. On a
 *  sphere the tangent is the direction of growing u and the bitangent, cross(normal, tangent), that of falling v; on other shapes
 *  both are those of a sphere with the same normal. */
typedef struct nqm_scene nqm_scene;

/** Which scene the options describe. */
typedef enum nqm_scene_kind {
    NQM_SCENE_STANDARD, /**< the standard set, or another scene if light or shape is given */
    NQM_SCENE_PAPER /**< the scene of Kavoosighafi et al. 2025: light and shape, which are files and must both be given
                             (the Pixar Campus light map and the Stanford bunny), in 8 views of the turntable */
} nqm_scene_kind;

typedef struct nqm_scene_options {
    nqm_scene_kind scene; /**< default NQM_SCENE_STANDARD */
    const char
        *light; /**< "sun", "overcast", "studio", "interior", or a latitude-longitude map: RGBE in PNG, OpenEXR or
                               Radiance HDR; default NULL: the standard set, or "sun" if a shape is given */
    const char *shape;    /**< "sphere", "blob" (a built-in smooth shape that casts shadows on itself), or a mesh file
                               (PLY, OBJ), which is centred and scaled to the picture; default NULL: the standard set, or
                               "sphere" if a light is given */
    size_t width, height; /**< picture in pixels, up to 8192; every pixel that shows the shape is a point. Default 0:
                               n_points points, distributed evenly over the pictures of all frames (faster) */
    size_t n_points;      /**< surface points in total if width is 0; 1 (standard set: 4) to 10^7; default 3072 */
    size_t n_frames;      /**< views of the turntable, evenly over 360 degrees, 1 to 4096; default 0: 1, or 8 for
                               NQM_SCENE_PAPER */
    double turn_rad;      /**< angle of the turntable in the first frame, its front to the right; default 0 */
    double elevation_rad; /**< elevation of the viewer above the horizon of the light map, -pi/2 to pi/2; default 0 */
    size_t n_lights;      /**< light directions per point, 16 to 65536; default 0: 128, or 96 if width is not 0 */
    size_t light_width;   /**< the light map is filtered to light_width x light_width / 2 cells; a multiple of 16 up to
                               4096; default 256 */
    int shadows;          /**< 1: the shape casts shadows on itself; default 1 */
    int interreflection;  /**< 1: add light that the shape reflects once onto itself, needs shadows; default 0 */
    double
        exposure_cdm2; /**< mean luminance of a white Lambert surface without shadows and interreflection, 0.01 to 10000
                               cd/m2; default 200 */
    double peak_cdm2;  /**< peak luminance of the display, where Delta-E clips, 0.01 to 10000 cd/m2; default 1000 */
    double min_valid; /**< least fraction of the light that falls at directions where a BRDF has a value; default 0.9 */
    uint64_t seed;    /**< seed of points and light directions; default 1 */
    int exact; /**< 0 (default): BRDFs that are costly to evaluate (neural processes) are evaluated once into a table of
                               180 x 32 x 12 nodes where that is less work; 1: always evaluated themselves */
    nqm_progress_fn
        progress; /**< called by nqm_scene_create() and nqm_scene_render(), on the calling thread; NULL (default):
                                 silent */
    void *progress_user;
} nqm_scene_options;

/** The defaults above. */
NQM_API nqm_scene_options nqm_scene_options_default(void);
/** Create a scene; options NULL: the defaults. Light directions and shadows of every visible point are computed here, by
 *  multiple importance sampling with the balance heuristic (Veach and Guibas 1995, DOI 10.1145/218380.218498) over light
 *  map, cosine, and a spiral of half vectors that is even in the logarithm of tan(theta_h): lobes of any width, down to perfect
 *  mirrors, reflect the right amount of light. NQM_ERR_ARG (an option out of range; NQM_SCENE_PAPER without
 *  light or shape; a shape other than the sphere in a build without Embree), NQM_ERR_CANCELLED, or the error of reading the light
 *  map or mesh. */
NQM_API NQM_MUST_CHECK nqm_status nqm_scene_create(const nqm_scene_options *options, nqm_scene **scene_ret,
                                                   nqm_error *err);
/** Free a scene; NULL is allowed. */
NQM_API void nqm_scene_free(nqm_scene *scene);
/** The points of a scene; the arrays belong to the scene. */
typedef struct nqm_scene_info {
    size_t n_points; /**< surface points of all frames together */
    /** (n_points) the fraction of the picture that each point represents, summing to 1. Only for the standard set, and for scenes
     *  of a mesh or blob without a width, whose points are denser in possible highlights; NULL otherwise: all weights are equal. */
    const double *weights;
    /** (n_points) (frame * height + y) * width + x with the first row at the top; the scenes of the standard set have n_frames
     *  frames each, one scene after the other. Only for scenes with a width; NULL otherwise. */
    const size_t *pixels;
} nqm_scene_info;

NQM_API nqm_scene_info nqm_scene_get_info(const nqm_scene *scene);
/** Light reflected at each point towards the viewer: rgb_cdm2 (n_points, 3), linear BT.709 in cd/m2, not clipped. All BRDFs
 *  use the same points and light directions, so that equal BRDFs give bit-identical pictures. Deterministic for any number
 *  of threads. Light at directions where the BRDF has no value (NQM_VALUE_INVALID) is not reflected: the picture is too dark there.
 *
 * @param with_halves  1: rgb_cdm2 (3, n_points, 3) also receives what either half of the light directions alone shows. The halves differ
 *                     by the noise that is left in the picture, which nqm_scene_label() measures and takes off
 * @param valid_ret  receives the fraction of the light of the scene, by luminance, that falls at directions where the BRDF has a
 *                   value: 1 without holes, also when that is less than options.min_valid; NULL allowed
 * @return NQM_ERR_INCOMPATIBLE (less than options.min_valid), NQM_ERR_NUMERIC (a value is not finite), NQM_ERR_CANCELLED,
 *         NQM_ERR_NOMEM */
NQM_API NQM_MUST_CHECK nqm_status nqm_scene_render(const nqm_scene *scene, const nqm_brdf *brdf, int with_halves,
                                                   double *rgb_cdm2, double *valid_ret, nqm_error *err);
/* ---- random pictures --------------------------------------------------------------------------------------------- */

/** A random picture of few points of a scene, as the rays whose BRDF values make it: point p reflects the sum of weight times
 *  f_r(wi, wo) over the rays with point == p to the viewer, in cd/m2. Its mean over seeds is the picture of
 *  nqm_scene_render() without interreflection (stochastic transport). So a loss on new rays at each step of a training
 *  (nqm_rays_compare) cannot be satisfied at some directions only. `wi` owns the block of the arrays. */
typedef struct nqm_rays {
    size_t n;        /**< rays with light */
    size_t n_points; /**< points of all scenes together */
    double *wi; /**< (n, 3) unit vectors to the light, in the axes of the surface: the third is the normal, the first
                          the tangent, which is horizontal */
    double *wo; /**< (n, 3) unit vectors to the viewer */
    double *weight; /**< (n, 3) radiance times cosine times solid angle, linear BT.709 in cd/m2 */
    size_t *point;  /**< (n) ascending */
    double *
        points; /**< (n_points, 3) fraction of the scene's picture, summing to 1 in each scene; number of the scene in the
                          standard set, from 0, ascending; peak luminance of the display, cd/m2 */
} nqm_rays;

/** Draw at most n rays of a scene, equally many in each scene of the standard set; the few without light (shadows, directions
 *  below the horizon) are left out. Points are a stratified random selection among those of the scene and have sqrt(n)/2 light
 *  directions each, more if the scene has too few points. Any thread; the same for any number of threads. 4096 rays take 2
 *  milliseconds.
 *
 * @param n         at least 16 for each scene of the set
 * @param seed      of points and directions
 * @param rays_ret  free the contents with nqm_rays_clear(); empty on failure
 * @return NQM_ERR_ARG (n out of range), NQM_ERR_NOMEM */
NQM_API NQM_MUST_CHECK nqm_status nqm_rays_draw(const nqm_scene *scene, size_t n, uint64_t seed, nqm_rays *rays_ret,
                                                nqm_error *err);
/** Free the contents; NULL and zeroed rays are allowed. */
NQM_API void nqm_rays_clear(nqm_rays *rays);

#ifdef __cplusplus
}
#endif
#endif
