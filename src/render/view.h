/* SPDX-License-Identifier: MIT
 *
 * view.h - what view.c and spread.c share: the viewer's rays in one frame of the turntable.
 */
#ifndef NQM_SRC_RENDER_VIEW_H
#define NQM_SRC_RENDER_VIEW_H

#include "render/render.h"

#define NQM_VIEW_MAX_DEG 85.0 /* BRDFs are hardly known beyond; less than 1 % of a sphere's picture */

/** The viewer and one frame of the turntable. */
typedef struct nqm_view {
    const nqm_shape *shape;
    double axes[9];
    double distance; /* of the rays' origins: beyond the shape */
    double turn[2];
} nqm_view;

nqm_view nqm_view_make(const nqm_shape *shape, const nqm_scene_options *o, size_t frame);
/** The point that shows at (x, y), in halves of the picture's shorter side from its middle to the right and up. */
bool nqm_view_look(const nqm_view *view, double x, double y, nqm_surface_point *point);

/** Fill point (n_points), and share (n_points) of the picture for which each stands. */
void nqm_spread_sphere(const nqm_scene_options *o, nqm_surface_point *point);
NQM_MUST_CHECK nqm_status nqm_spread_mesh(const nqm_shape *shape, const nqm_light *glow, const nqm_scene_options *o,
                                          nqm_surface_point *point, double *share, nqm_error *err);

#endif
