/* SPDX-License-Identifier: MIT
 *
 * The estimate by light transport (metric/transport.c) for gradients, and its gradient by the samples of the test: from the label
 * back to the pictures, from ITP back to light, and through the transpose of the matrix. Products with the matrix are in float,
 * everything between them in double. The gradient of close pairs depends on small differences of light: they have pictures of
 * their own, to which the reference's is added.
 */
#include "kernel/kernel.h"
#include "metric/metric.h"

#include <math.h>

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

/* Whether a sample of the test is so dark that the sum of reference and difference would be rounded much more than the test. */
static bool is_darker(size_t n, const nqm_sample_pair *p) {
    int n_darker = 0;
    for (size_t i = 0; i < n; ++i)
        n_darker += p->test[i] < 0.125F * p->ref[i] && (!p->used || p->used[i / 3]);
    return n_darker > 0;
}

/* The light of n points of the test. test: NULL unless it is darker; then differences are used only where they are small. */
static void add_difference(size_t n, const float *ref, const float *difference, const float *test, double *light) {
    for (size_t p = 0; p < n; ++p)
        light[p] =
            !test || fabsf(difference[p]) < 0.5F * test[p] ? (double)ref[p] + (double)difference[p] : (double)test[p];
}

void nqm_transport_see(const nqm_transport *t, size_t n, const nqm_sample_pair *pairs, const nqm_seen_pair *seen) {
    enum { POINTS = NQM_TRANSPORT_BLOCK, NONE = NQM_TRANSPORT_MAX };
    nqm_transport_picture pictures[NQM_TRANSPORT_MAX];
    float light[NQM_TRANSPORT_MAX * 3 * POINTS];
    size_t n_pictures = 0, ref_at[NQM_COMPARE_MAX], test_at[NQM_COMPARE_MAX], difference_at[NQM_COMPARE_MAX];
    for (size_t i = 0; i < n; ++i) {
        const bool is_shared = i > 0 && seen[i].ref == seen[i - 1].ref;
        ref_at[i] = is_shared ? ref_at[i - 1] : n_pictures;
        if (!is_shared)
            pictures[n_pictures++] = (nqm_transport_picture){&pairs[i], NQM_TRANSPORT_OF_REF};
        difference_at[i] = n_pictures;
        pictures[n_pictures++] = (nqm_transport_picture){&pairs[i], NQM_TRANSPORT_OF_DIFFERENCE};
        test_at[i] = is_darker(3 * t->n_directions, &pairs[i]) ? n_pictures : NONE;
        if (test_at[i] != NONE)
            pictures[n_pictures++] = (nqm_transport_picture){&pairs[i], NQM_TRANSPORT_OF_TEST};
    }
    for (size_t first = 0, n_points; first < t->n_points; first += n_points) {
        n_points = nqm_smaller(t->n_points - first, POINTS);
        nqm_transport_radiance(t, first, n_points, n_pictures, pictures, light);
        for (size_t i = 0; i < 3 * n; ++i) {
            const size_t k = i % 3, pair = i / 3, at = k * t->n_points + first;
            const float *ref = light + (3 * ref_at[pair] + k) * n_points;
            const float *test = test_at[pair] != NONE ? light + (3 * test_at[pair] + k) * n_points : NULL;
            for (size_t p = 0; p < n_points; ++p)
                seen[pair].ref[at + p] = (double)ref[p];
            add_difference(n_points, ref, light + (3 * difference_at[pair] + k) * n_points, test,
                           seen[pair].light + at);
        }
    }
    for (size_t i = 0; i < n; ++i) {
        nqm_transport_show(t, seen[i].light, seen[i].test);
        if (i == 0 || seen[i].ref != seen[i - 1].ref)
            nqm_transport_show(t, seen[i].ref, seen[i].ref);
    }
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
                           const nqm_seen_pair *seen, double *by_light) {
    const size_t n = t->n_points;
    const double peak = t->points[3 * p + 2], weight = t->points[3 * p] * nqm_transport_share(t) * NQM_ITP_UNIT;
    double a[3], b[3], by_itp[3], by_rgb[3], shown[3];
    point_of(seen->ref, n, p, a);
    point_of(seen->test, n, p, b);
    nqm_picture_gradient(sums, weights, weight, a, b, by_itp);
    for (size_t k = 0; k < 3; ++k)
        shown[k] = fmin(seen->light[k * n + p], peak);
    nqm_rgb_gradient(shown, by_itp, by_rgb);
    for (size_t k = 0; k < 3; ++k)
        by_light[k * n + p] = seen->light[k * n + p] < peak ? by_rgb[k] : 0;
}

void nqm_transport_light_gradient(const nqm_transport *t, const nqm_label *weights, const nqm_seen_pair *seen,
                                  double *by_light) {
    for (size_t first = 0, end; first < t->n_points; first = end) {
        const nqm_picture_sums sums = sum_scene(t, first, seen->ref, seen->test, &end);
        for (size_t p = first; p < end; ++p)
            point_gradient(t, &sums, weights, p, seen, by_light);
    }
}

void nqm_transport_gradient(const nqm_transport *t, size_t n, const nqm_sample_pair *pairs, const float *by_light,
                            float *gradient) {
    const size_t n_points = t->n_points, n_values = 3 * t->n_directions;
    const nqm_kernels *kernels = nqm_kernels_get();
    for (size_t k = 0; k < n_values; ++k) /* each row of the matrix is read once for all pairs */
        for (size_t i = 0; i < n; ++i)
            if (!pairs[i].used || pairs[i].used[k / 3])
                gradient[i * n_values + k] +=
                    kernels->dot(n_points, t->light + k * n_points, by_light + (3 * i + k % 3) * n_points);
}
