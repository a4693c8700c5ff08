/* SPDX-License-Identifier: MIT
 *
 * label.h - what other rooms use of the labels beside the public functions.
 */
#ifndef NQM_SRC_LABEL_LABEL_H
#define NQM_SRC_LABEL_LABEL_H

#include "render/render.h"
#include <nqm/label.h>

/** The label of two pictures of nqm_scene_render_halves(), (3, n_points, 3) each, as nqm_scene_label() makes it. */
nqm_label nqm_scene_compare_halves(const nqm_scene *scene, const double *ref_cdm2, const double *test_cdm2);

/** Few points of a scene and the light that each receives, in the `column` of a model. */
typedef struct nqm_lit_point {
    const nqm_surface_point *seen;
    const nqm_incident *incident;
    double exposure;
    size_t column;
} nqm_lit_point;

/** Call fill(user, point) for n_points of the scene, in several threads and any order, and write points (n_points, 3) as in
 *  nqm_transport. options: pixels, points and interreflection are not used, and n_lights 0 stands for the given one. */
NQM_MUST_CHECK nqm_status nqm_lit_points(const nqm_scene_options *options, size_t n_points, size_t n_lights,
                                         void (*fill)(void *user, const nqm_lit_point *point), void *user,
                                         double *points, nqm_error *err);
/** Direction and light (3) of ray j of a point, cd/m2 times cosine times solid angle. */
void nqm_lit_ray(const nqm_lit_point *point, size_t j, double *wi, double *light);

/** Compute the transport matrix of a scene for the directions nqm_node_grid_directions(); shadows count, interreflection does
 *  not. light (n_directions, 3, n_points), points (n_points, 3) as in nqm_transport. */
NQM_MUST_CHECK nqm_status nqm_transport_fill(const nqm_scene_options *scene, size_t n_points, float *light,
                                             double *points, nqm_error *err);

/** Compute the light of a scene by slopes, as the members of a model. Shadows count, interreflection does not. */
NQM_MUST_CHECK nqm_status nqm_slopes_fill(const nqm_scene_options *scene, size_t n_points, nqm_model *model,
                                          nqm_error *err);

#endif
