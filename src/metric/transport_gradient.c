/* SPDX-License-Identifier: MIT
 *
 * The estimate by light transport (metric/transport.c) in double, and its gradient by the samples
 * of the test: from the label back to the pictures, from ITP back to light, and through the transpose of the matrix.
 */
#include "kernel/kernel.h"
#include "metric/metric.h"

#include <math.h>
#include <string.h>

enum { DIRECTIONS = 64 }; /* computed together */

/* Light of two pictures, (3, n_points) each. The gradient of close pairs depends on small differences of these sums. */
static void add_light(const nqm_transport *t, const nqm_transport_samples *samples, double *const *rgb) {
    const nqm_kernels *kernels = nqm_kernels_get();
    float f[2][3 * DIRECTIONS];
    for (size_t first = 0, n; first < t->n_directions; first += n) {
        n = nqm_smaller(t->n_directions - first, DIRECTIONS);
        for (size_t i = 0; i < 2; ++i)
            nqm_transport_read(&samples[i], first, n, f[i]);
        for (size_t c = 0; c < 3; ++c)
            for (size_t p = 0; p < t->n_points; p += NQM_PANEL)
                kernels->double_product(
                    &(nqm_double_product){.k = n,
                                          .add = first > 0,
                                          .a = {f[0] + c, f[1] + c},
                                          .step = 3,
                                          .b = t->light + (3 * first + c) * t->n_points + p,
                                          .ldb = 3 * t->n_points,
                                          .c = {rgb[0] + c * t->n_points + p, rgb[1] + c * t->n_points + p}});
    }
}

void nqm_transport_show(const nqm_transport *t, const double *rgb, double *itp) {
    const size_t n = t->n_points;
    for (size_t p = 0; p < n; ++p) {
        double shown[3], lms[3], point[3], slope;
        for (size_t k = 0; k < 3; ++k)
            shown[k] = fmin(rgb[k * n + p], t->points[3 * p + 2]);
        nqm_lms_from_rgb(shown, lms);
        for (size_t k = 0; k < 3; ++k)
            lms[k] = nqm_pq_interpolate(lms[k], &slope);
        nqm_itp_from_pq_lms(lms, point);
        for (size_t k = 0; k < 3; ++k)
            itp[k * n + p] = NQM_ITP_UNIT * point[k];
    }
}

void nqm_transport_see(const nqm_transport *t, size_t n, const nqm_transport_samples *samples, double *const *rgb,
                       double *const *itp) {
    for (size_t i = 0; i < n; i += 2) {
        const size_t other =
            i + 1 < n ? i + 1 : i - 1; /* of an odd number the last one is computed beside its neighbour again */
        const nqm_transport_samples two[2] = {samples[i], samples[other]};
        double *const light[2] = {rgb[i], rgb[other]};
        add_light(t, two, light);
    }
    for (size_t i = 0; i < n; ++i)
        nqm_transport_show(t, rgb[i], itp[i]);
}

static void point_of(const double *picture, size_t n, size_t p, double *point) {
    for (size_t k = 0; k < 3; ++k)
        point[k] = picture[k * n + p];
}

/* The sums of the scene that begins at point `first`; *end receives the point after it. */
static nqm_picture_sums sum_scene(const nqm_transport *t, size_t first, const double *ref, const double *test,
                                  size_t *end) {
    nqm_picture_sums sums = {0};
    size_t p = first;
    do {
        double a[3], b[3];
        point_of(ref, t->n_points, p, a);
        point_of(test, t->n_points, p, b);
        nqm_picture_sums_add(&sums, t->points[3 * p], a, b);
    } while (!nqm_transport_ends_scene(t, p++));
    *end = p;
    return sums;
}

nqm_label nqm_transport_label(const nqm_transport *t, const double *ref, const double *test) {
    nqm_label mean = {.delta_e = 0};
    for (size_t first = 0, end; first < t->n_points; first = end) {
        const nqm_picture_sums sums = sum_scene(t, first, ref, test, &end);
        const nqm_label label = nqm_picture_sums_label(&sums);
        nqm_label_add(&mean, nqm_transport_share(t), &label);
    }
    return mean;
}

/* The gradient by the light (3) of point p. */
static void point_gradient(const nqm_transport *t, const nqm_picture_sums *sums, const nqm_label *weights, size_t p,
                           const double *ref, const double *test, const double *rgb, double *by_light) {
    const size_t n = t->n_points;
    const double peak = t->points[3 * p + 2], weight = t->points[3 * p] * nqm_transport_share(t) * NQM_ITP_UNIT;
    double a[3], b[3], by_itp[3], by_rgb[3], shown[3];
    point_of(ref, n, p, a);
    point_of(test, n, p, b);
    nqm_picture_gradient(sums, weights, weight, a, b, by_itp);
    for (size_t k = 0; k < 3; ++k)
        shown[k] = fmin(rgb[k * n + p], peak);
    nqm_rgb_gradient(shown, by_itp, by_rgb);
    for (size_t k = 0; k < 3; ++k)
        by_light[k * n + p] = rgb[k * n + p] < peak ? by_rgb[k] : 0;
}

void nqm_transport_light_gradient(const nqm_transport *t, const nqm_label *weights, const double *ref,
                                  const double *test, const double *rgb, double *by_light) {
    for (size_t first = 0, end; first < t->n_points; first = end) {
        const nqm_picture_sums sums = sum_scene(t, first, ref, test, &end);
        for (size_t p = first; p < end; ++p)
            point_gradient(t, &sums, weights, p, ref, test, rgb, by_light);
    }
}

void nqm_transport_gradient(const nqm_transport *t, const nqm_label *weights, const double *ref, const double *test,
                            const double *rgb, const uint8_t *used, double *scratch, double *gradient) {
    const nqm_kernels *kernels = nqm_kernels_get();
    const size_t n = t->n_points;
    nqm_transport_light_gradient(t, weights, ref, test, rgb, scratch);
    for (size_t i = 0; i < 3 * t->n_directions; ++i)
        gradient[i] = !used || used[i / 3] ? kernels->double_dot(n, t->light + i * n, scratch + i % 3 * n) : 0;
}
