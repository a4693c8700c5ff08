/* SPDX-License-Identifier: MIT
 *
 * Labels: how the pictures of two BRDFs in a scene differ, as a mean, in parts, and at every point.
 */
#include "math/math.h"
#include "percept/percept.h"
#include "render/render.h"
#include <nqm/label.h>

#include <math.h>

/* Delta-E ITP is 720 times the distance in ITP. */
static const double unit = 720;

/* ITP of a point on the display of the scene, times 720. */
static void see(const nqm_scene *scene, const double *rgb_cdm2, double *itp) {
    double shown[3];
    for (int k = 0; k < 3; ++k)
        shown[k] = fmin(rgb_cdm2[k], scene->options.peak_cdm2);
    nqm_itp_from_rgb(shown, itp);
    for (int k = 0; k < 3; ++k)
        itp[k] *= unit;
}

static double standard_deviation(double mean, double mean_of_squares) {
    return sqrt(fmax(mean_of_squares - mean * mean, 0));
}

static nqm_label compare_one(const nqm_scene *scene, const double *ref_cdm2, const double *test_cdm2) {
    const double *weights = scene->seen.weight;
    double ref_mean = 0, ref_squares = 0, test_mean = 0, test_squares = 0, squares = 0;
    nqm_label label = {.delta_e = 0};
    for (size_t i = 0; i < scene->seen.n; ++i) {
        double ref[3], test[3], weight = weights ? weights[i] : 1 / (double)scene->seen.n, square = 0;
        see(scene, ref_cdm2 + 3 * i, ref);
        see(scene, test_cdm2 + 3 * i, test);
        for (int k = 0; k < 3; ++k) {
            double d = test[k] - ref[k];
            label.shift[k] += weight * d;
            square += d * d;
        }
        label.delta_e += weight * sqrt(square);
        squares += weight * square;
        ref_mean += weight * ref[0];
        ref_squares += weight * ref[0] * ref[0];
        test_mean += weight * test[0];
        test_squares += weight * test[0] * test[0];
    }
    label.structure = sqrt(fmax(squares - nqm_dot3(label.shift, label.shift), 0));
    label.contrast =
        log((1 + standard_deviation(test_mean, test_squares)) / (1 + standard_deviation(ref_mean, ref_squares)));
    return label;
}

nqm_label nqm_scene_compare(const nqm_scene *scene, const double *ref_cdm2, const double *test_cdm2) {
    if (scene->n_parts == 0)
        return compare_one(scene, ref_cdm2, test_cdm2);
    nqm_label mean = {.delta_e = 0};
    for (size_t p = 0; p < scene->n_parts; ++p) {
        const nqm_label label = compare_one(scene->parts[p], ref_cdm2, test_cdm2);
        const double share = 1 / (double)scene->n_parts;
        mean.delta_e += share * label.delta_e;
        for (int k = 0; k < 3; ++k)
            mean.shift[k] += share * label.shift[k];
        mean.contrast += share * label.contrast;
        mean.structure += share * label.structure;
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
