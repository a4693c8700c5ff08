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

/** Compute the transport matrix of a scene for the directions nqm_node_grid_directions(); shadows count, interreflection does
 *  not. light (n_directions, 3, n_points) as in nqm_transport; points (n_points, 3) as in nqm_picture_points. */
NQM_MUST_CHECK nqm_status nqm_transport_fill(const nqm_scene_options *scene, size_t n_points, float *light,
                                             double *points, nqm_error *err);

#endif
