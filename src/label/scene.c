/* SPDX-License-Identifier: MIT
 *
 * From two pictures of a scene to one number.
 */
#include "percept/percept.h"
#include "render/render.h"

double nqm_scene_delta_e(const nqm_scene *scene, const double *ref_cdm2, const double *test_cdm2) {
    return nqm_picture_delta_e(scene->n_points, ref_cdm2, test_cdm2, scene->peak_cdm2);
}
