/* SPDX-License-Identifier: MIT
 *
 * label.h - what other rooms use of the labels beside the public functions.
 */
#ifndef NQM_SRC_LABEL_LABEL_H
#define NQM_SRC_LABEL_LABEL_H

#include <nqm/label.h>

/** Compute the transport matrix of a scene for the directions nqm_node_grid_directions(); shadows count, interreflection does
 *  not. light (n_directions, 3, n_points), points (n_points, 3) as in nqm_transport. */
NQM_MUST_CHECK nqm_status nqm_transport_fill(const nqm_scene_options *scene, size_t n_points, float *light,
                                             double *points, nqm_error *err);

/** Complete a model without a network: texts, constants and golden scores. */
NQM_MUST_CHECK nqm_status nqm_untrained_finish(nqm_model *model, const char *id, const char *card, nqm_error *err);

#endif
