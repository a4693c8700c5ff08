/* SPDX-License-Identifier: MIT
 *
 * From two pictures of a scene to one number, or to one at every point.
 */
#include "percept/percept.h"
#include "render/render.h"

double nqm_scene_delta_e(const nqm_scene *scene, const double *ref_cdm2, const double *test_cdm2) {
    return nqm_picture_delta_e(scene->n_points, ref_cdm2, test_cdm2, scene->options.peak_cdm2);
}

void nqm_scene_delta_e_map(const nqm_scene *scene, const double *ref_cdm2, const double *test_cdm2, double *delta_e) {
    for (size_t i = 0; i < scene->n_points; ++i)
        delta_e[i] = nqm_picture_delta_e(1, ref_cdm2 + 3 * i, test_cdm2 + 3 * i, scene->options.peak_cdm2);
}
