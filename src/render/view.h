/* SPDX-License-Identifier: MIT
 *
 * view.h - the viewer's rays in one frame of the turntable, for view.c and spread.c.
 */
#ifndef NQM_SRC_RENDER_VIEW_H
#define NQM_SRC_RENDER_VIEW_H

#include "render/render.h"

#define NQM_VIEW_MAX_DEG 85.0 /* BRDFs are unreliable at larger angles; less than 1 % of the picture of a sphere */

/** Uniform in [0, 1), from a hash. */
static inline double nqm_random_unit(uint64_t seed, uint64_t counter) {
    return (double)(nqm_hash_u64(seed, counter) >> 11) * 0x1p-53;
}

/** The viewer and one frame of the turntable. */
typedef struct nqm_view {
    const nqm_shape *shape;
    double axes[9];
    double distance; /* distance of the rays' origins, outside the shape */
    double turn[2];
} nqm_view;

nqm_view nqm_view_make(const nqm_shape *shape, const nqm_scene_options *o, size_t frame);
/** The visible point at (x, y), in units of half the picture's shorter side from its centre, right and up; false: none. */
bool nqm_view_look(const nqm_view *view, double x, double y, nqm_surface_point *point);

/** Fill point (n_points) evenly over the picture of a sphere. */
void nqm_spread_sphere(const nqm_scene_options *o, nqm_surface_point *point);

#endif
