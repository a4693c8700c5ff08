/* SPDX-License-Identifier: MIT
 *
 * nqm/label.h - labels by rendering: Delta-E ITP between pictures of two BRDFs. In libnqm-full only.
 */
#ifndef NQM_LABEL_H
#define NQM_LABEL_H

#include <nqm/model.h>
#include <nqm/percept.h>
#include <nqm/render.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- labels ------------------------------------------------------------------------------------------------------ */

/** Compare two renderings of the scene, (n_points, 3) cd/m2 each, clipped at the display's peak; points are weighted by
 *  nqm_scene_info.weights. label.error is the standard error by the choice of the points, measured between groups of them of two
 *  sizes; where the pictures are smooth, it may be overstated by a factor of four. delta_e: (n_points) receives the Delta-E ITP of each
 *  point; NULL allowed. */
NQM_API nqm_label nqm_scene_compare(const nqm_scene *scene, const double *ref_cdm2, const double *test_cdm2,
                                    double *delta_e);
/** A BRDF and what nqm_scene_render_halves() made of it. */
typedef struct nqm_scene_picture {
    const nqm_brdf *brdf;   /**< NULL: a picture of another origin, which cannot be rendered again */
    const double *rgb_cdm2; /**< (3, n_points, 3) */
    double valid;           /**< the fraction of the light at directions with a value */
} nqm_scene_picture;

/** The label of two BRDFs by their pictures in the scene. Where one of them has no value, neither counts: if valid < 1, both are
 *  rendered again at the directions where both have one. Any thread.
 *
 * @param label_ret  as of nqm_scene_compare(). Noise of the light directions adds to Delta-E, which is a mean of absolute values: the
 *                   label is extrapolated from halves and whole to the label without this noise, and half of the extrapolation
 *                   counts as error. This is the label of `nqm label` and of corpora. Equal pictures have exactly 0
 * @param delta_e    (n_points) receives the Delta-E ITP of each point; NULL allowed
 * @param valid_ret  receives the fraction of the light at directions where both have a value; NULL allowed
 * @return NQM_ERR_INCOMPATIBLE (less than min_valid of the scene's options), or the errors of nqm_scene_render() */
NQM_API NQM_MUST_CHECK nqm_status nqm_scene_label(const nqm_scene *scene, const nqm_scene_picture *ref,
                                                  const nqm_scene_picture *test, nqm_label *label_ret, double *delta_e,
                                                  double *valid_ret, nqm_error *err);
/** Compare the random pictures of two BRDFs, and differentiate: a loss for training. Noise is common to both pictures: equal values
 *  give exactly 0. Where it makes them differ in shape it adds a little to Delta-E, less with more rays. Any thread.
 *
 * @param ref, test  (rays->n, 3) f_r in 1/sr at the rays
 * @param gradient   (rays->n, 3) receives the derivatives of label_ret->delta_e by `test`, exact but for points that are equal, black
 *                   or brighter than the display, which have 0; NULL allowed
 * @return NQM_ERR_NUMERIC (a value is not finite; the message names its row), NQM_ERR_NOMEM */
NQM_API NQM_MUST_CHECK nqm_status nqm_rays_compare(const nqm_rays *rays, const double *ref, const double *test,
                                                   nqm_label *label_ret, double *gradient, nqm_error *err);

/* ---- light transport --------------------------------------------------------------------------------------------- */

/**
 * Make a model without a network that estimates labels in a scene by light transport: with fixed light, the radiance of
 * every point is linear in the BRDF (precomputed radiance transfer: Sloan et al. 2002, DOI 10.1145/566654.566612), so a
 * matrix makes pictures of few points from samples. The model predicts labels with parts and has no intervals;
 * nqm_model_save() writes it. The directions are the nodes of a grid (nqm_directions_options.grid). More points make it
 * more exact, larger (16.6 KB each) and slower; doc/labels.md has the errors. The built-in model "transport" has the
 * standard scenes.
 *
 * @param scene       NULL: the defaults, the standard scenes; its pixels, points and interreflection are not used, and n_lights 0
 *                    stands for 1024
 * @param anisotropic  nonzero: a model for anisotropic BRDFs, too, of how much light each point receives by the slope of
 *                    the half vector. BRDFs are evaluated at half vectors that are placed by their lobe, so that lobes
 *                    of any width, shape and tilt are right; samples at fixed directions have no score. The built-in
 *                    model "anisotropic" has the standard scenes
 * @param n_points    of all scenes together: a multiple of 32 up to 4096; anisotropic: 4 to 4096 of 22 KB each
 * @param id          of the model; copied
 * @return NQM_ERR_ARG (an option or n_points is out of range), NQM_ERR_IO, NQM_ERR_FORMAT (light or shape), NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_transport_create(const nqm_scene_options *scene, int anisotropic, size_t n_points,
                                                       const char *id, nqm_model **model_ret, nqm_error *err);

#ifdef __cplusplus
}
#endif
#endif
