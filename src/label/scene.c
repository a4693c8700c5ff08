/* SPDX-License-Identifier: MIT
 *
 * Delta-E ITP between two pictures of a scene: the mean, and at every point.
 */
#include "percept/percept.h"
#include "render/render.h"
#include <nqm/label.h>

static double delta_e_at(const nqm_scene *scene, const double *ref_cdm2, const double *test_cdm2, size_t i) {
    return nqm_picture_delta_e(1, ref_cdm2 + 3 * i, test_cdm2 + 3 * i, scene->options.peak_cdm2);
}

double nqm_scene_delta_e(const nqm_scene *scene, const double *ref_cdm2, const double *test_cdm2) {
    const double *weight = scene->seen.weight;
    if (!weight)
        return nqm_picture_delta_e(scene->seen.n, ref_cdm2, test_cdm2, scene->options.peak_cdm2);
    double sum = 0;
    for (size_t i = 0; i < scene->seen.n; ++i)
        sum += weight[i] * delta_e_at(scene, ref_cdm2, test_cdm2, i);
    return sum;
}

void nqm_scene_delta_e_map(const nqm_scene *scene, const double *ref_cdm2, const double *test_cdm2, double *delta_e) {
    for (size_t i = 0; i < scene->seen.n; ++i)
        delta_e[i] = delta_e_at(scene, ref_cdm2, test_cdm2, i);
}
