/* SPDX-License-Identifier: MIT
 *
 * Labels: how the pictures of two BRDFs in a scene differ, as a mean, in parts, and at every point.
 */
#include "math/math.h"
#include "percept/percept.h"
#include "render/render.h"
#include <nqm/label.h>

#include <math.h>

/* ITP of a point on the display of the scene, in units of Delta-E. */
static void see(const nqm_scene *scene, const double *rgb_cdm2, double *itp) {
    double shown[3];
    for (int k = 0; k < 3; ++k)
        shown[k] = fmin(rgb_cdm2[k], scene->options.peak_cdm2);
    nqm_itp_from_rgb(shown, itp);
    for (int k = 0; k < 3; ++k)
        itp[k] *= NQM_ITP_UNIT;
}

static nqm_label compare_one(const nqm_scene *scene, const double *ref_cdm2, const double *test_cdm2) {
    const double *weights = scene->seen.weight;
    nqm_picture_sums sums = {0};
    for (size_t i = 0; i < scene->seen.n; ++i) {
        double ref[3], test[3];
        see(scene, ref_cdm2 + 3 * i, ref);
        see(scene, test_cdm2 + 3 * i, test);
        nqm_picture_sums_add(&sums, weights ? weights[i] : 1 / (double)scene->seen.n, ref, test);
    }
    return nqm_picture_sums_label(&sums);
}

nqm_label nqm_scene_compare(const nqm_scene *scene, const double *ref_cdm2, const double *test_cdm2) {
    if (scene->n_parts == 0)
        return compare_one(scene, ref_cdm2, test_cdm2);
    nqm_label mean = {.delta_e = 0};
    for (size_t p = 0; p < scene->n_parts; ++p) {
        const nqm_label label = compare_one(scene->parts[p], ref_cdm2, test_cdm2);
        nqm_label_add(&mean, 1 / (double)scene->n_parts, &label);
        ref_cdm2 += 3 * scene->parts[p]->seen.n;
        test_cdm2 += 3 * scene->parts[p]->seen.n;
    }
    return mean;
}

void nqm_scene_delta_e_map(const nqm_scene *scene, const double *ref_cdm2, const double *test_cdm2, double *delta_e) {
    for (size_t i = 0; i < scene->seen.n; ++i) {
        double ref[3], test[3];
        see(scene, ref_cdm2 + 3 * i, ref);
        see(scene, test_cdm2 + 3 * i, test);
        double d[3] = {test[0] - ref[0], test[1] - ref[1], test[2] - ref[2]};
        delta_e[i] = sqrt(nqm_dot3(d, d));
    }
}
