/* SPDX-License-Identifier: MIT
 *
 * Pictures and labels by their definition (nqm_label), in two passes over the points.
 */
#include "support/double_transport.h"
#include "support/double_features.h"

#include <math.h>
#include <string.h>

enum { N = DOUBLE_N, N_VALUES = DOUBLE_VALUES };

nqm_transport make_transport(size_t n_points, size_t n_scenes, double peak_cdm2) {
    uint64_t seed = n_points + n_scenes;
    float *light = nqm_alloc(N_VALUES, n_points * sizeof *light);
    double *points = nqm_alloc(n_points, 3 * sizeof *points);
    for (size_t i = 0; light && i < N_VALUES * n_points; ++i)
        light[i] = random_unit(&seed) < 0.3 ? (float)(2000.0 / N * random_unit(&seed)) : 0;
    for (size_t s = 0; points && s < n_scenes; ++s) {
        const size_t begin = n_points * s / n_scenes, end = n_points * (s + 1) / n_scenes;
        double sum = 0;
        for (size_t p = begin; p < end; ++p)
            sum += points[3 * p] = 0.1 + random_unit(&seed);
        for (size_t p = begin; p < end; ++p) {
            points[3 * p] /= sum;
            points[3 * p + 1] = (double)s;
            points[3 * p + 2] = peak_cdm2 * (double)(s + 1);
        }
    }
    return (nqm_transport){N, n_points, light, points};
}

void drop_transport(nqm_transport *transport) {
    nqm_free((void *)(uintptr_t)transport->light);
    nqm_free((void *)(uintptr_t)transport->points);
}

/* itp (n_points, 3) in units of Delta-E; g: used directions, f: the others. */
static void see(const nqm_transport *t, const double *f, const double *g, const uint8_t *used, double *itp) {
    static double rgb[3][NQM_TRANSPORT_MAX_POINTS];
    memset(rgb, 0, sizeof rgb);
    for (size_t i = 0; i < N_VALUES; ++i)
        for (size_t p = 0; p < t->n_points; ++p)
            rgb[i % 3][p] += (double)t->light[i * t->n_points + p] * (!used || used[i / 3] ? g[i] : f[i]);
    for (size_t p = 0; p < t->n_points; ++p) {
        const double peak = t->points[3 * p + 2];
        const double shown[3] = {fmin(rgb[0][p], peak), fmin(rgb[1][p], peak), fmin(rgb[2][p], peak)};
        nqm_itp_from_rgb(shown, itp + 3 * p);
        for (size_t k = 0; k < 3; ++k)
            itp[3 * p + k] *= 720;
    }
}

static double deviation(size_t n, const double *weight, const double *itp) {
    double mean = 0, square = 0;
    for (size_t p = 0; p < n; ++p)
        mean += weight[3 * p] * itp[3 * p];
    for (size_t p = 0; p < n; ++p)
        square += weight[3 * p] * pow(itp[3 * p] - mean, 2);
    return sqrt(square);
}

/* The label of one scene of n points. weight: every third value; a, b: (n, 3). */
static nqm_label scene_label(size_t n, const double *weight, const double *a, const double *b) {
    nqm_label label = {.delta_e = 0};
    double square = 0;
    for (size_t p = 0; p < n; ++p) {
        double distance = 0;
        for (size_t k = 0; k < 3; ++k) {
            const double d = b[3 * p + k] - a[3 * p + k];
            label.shift[k] += weight[3 * p] * d;
            distance += d * d;
        }
        label.delta_e += weight[3 * p] * sqrt(distance);
    }
    for (size_t p = 0; p < n; ++p)
        for (size_t k = 0; k < 3; ++k)
            square += weight[3 * p] * pow(b[3 * p + k] - a[3 * p + k] - label.shift[k], 2);
    label.structure = sqrt(square);
    label.contrast = log((1 + deviation(n, weight, b)) / (1 + deviation(n, weight, a)));
    return label;
}

nqm_label double_label(const nqm_transport *t, const double *f, const double *g, const uint8_t *used) {
    static double a[3 * NQM_TRANSPORT_MAX_POINTS], b[3 * NQM_TRANSPORT_MAX_POINTS];
    nqm_label mean = {.delta_e = 0};
    size_t n_scenes = 0;
    see(t, f, f, NULL, a);
    see(t, f, g, used, b);
    for (size_t begin = 0, end; begin < t->n_points; begin = end, ++n_scenes) {
        for (end = begin; end < t->n_points && t->points[3 * end + 1] == (double)n_scenes;)
            ++end;
        const nqm_label label = scene_label(end - begin, t->points + 3 * begin, a + 3 * begin, b + 3 * begin);
        nqm_label_add(&mean, 1, &label);
    }
    nqm_label result = {.delta_e = 0};
    nqm_label_add(&result, 1 / (double)n_scenes, &mean);
    return result;
}
