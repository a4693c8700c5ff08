/* SPDX-License-Identifier: MIT
 *
 * label.h - what other rooms use of the labels beside the public functions.
 */
#ifndef NQM_SRC_LABEL_LABEL_H
#define NQM_SRC_LABEL_LABEL_H

#include "base/base.h"
#include <nqm/label.h>

/** Compute the transport matrix of a scene for the directions nqm_node_grid_directions(); shadows count, interreflection does
 *  not. light (n_directions, 3, n_points), points (n_points, 3) as in nqm_transport. */
NQM_MUST_CHECK nqm_status nqm_transport_fill(const nqm_scene_options *scene, size_t n_points, float *light,
                                             double *points, nqm_error *err);

/** Whether nqm_label_aimed() is needed for a pair: one of them is anisotropic. */
bool nqm_label_needs_aim(const nqm_brdf *ref, const nqm_brdf *test);
/** Label of a pair in a scene of its own with these options, whose light directions are fitted to the lobes of both. points_error: the
 *  part of its error that the choice of points makes, Delta-E; may be NULL. */
NQM_MUST_CHECK nqm_status nqm_label_aimed(const nqm_scene_options *options, const nqm_brdf *ref, const nqm_brdf *test,
                                          nqm_label *label_ret, double *points_error, nqm_error *err);

#endif
