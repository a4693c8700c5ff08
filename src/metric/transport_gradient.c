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

void nqm_transport_see(const nqm_transport *t, size_t n, const nqm_sample_pair *pairs, const nqm_shown_pair *shown) {
    enum { POINTS = NQM_PICTURE_BLOCK, NONE = NQM_TRANSPORT_MAX };
    nqm_transport_picture pictures[NQM_TRANSPORT_MAX];
    float light[NQM_TRANSPORT_MAX * 3 * POINTS];
    size_t n_pictures = 0, ref_at[NQM_COMPARE_MAX], test_at[NQM_COMPARE_MAX], difference_at[NQM_COMPARE_MAX];
    for (size_t i = 0; i < n; ++i) {
        const bool is_shared = i > 0 && shown[i].ref == shown[i - 1].ref;
        ref_at[i] = is_shared ? ref_at[i - 1] : n_pictures;
        if (!is_shared)
            pictures[n_pictures++] = (nqm_transport_picture){&pairs[i], NQM_TRANSPORT_OF_REF};
        difference_at[i] = n_pictures;
        pictures[n_pictures++] = (nqm_transport_picture){&pairs[i], NQM_TRANSPORT_OF_DIFFERENCE};
        test_at[i] = is_darker(3 * t->n_directions, &pairs[i]) ? n_pictures : NONE;
        if (test_at[i] != NONE)
            pictures[n_pictures++] = (nqm_transport_picture){&pairs[i], NQM_TRANSPORT_OF_TEST};
    }
    for (size_t first = 0, n_points; first < t->points.n; first += n_points) {
        n_points = nqm_smaller(t->points.n - first, POINTS);
        nqm_transport_radiance(t, first, n_points, n_pictures, pictures, light);
        for (size_t i = 0; i < 3 * n; ++i) {
            const size_t k = i % 3, pair = i / 3, at = k * t->points.n + first;
            const float *ref = light + (3 * ref_at[pair] + k) * n_points;
            const float *test = test_at[pair] != NONE ? light + (3 * test_at[pair] + k) * n_points : NULL;
            for (size_t p = 0; p < n_points; ++p)
                shown[pair].ref[at + p] = (double)ref[p];
            add_difference(n_points, ref, light + (3 * difference_at[pair] + k) * n_points, test,
                           shown[pair].light + at);
        }
    }
    for (size_t i = 0; i < n; ++i) {
        nqm_picture_show(&t->points, shown[i].light, shown[i].test);
        if (i == 0 || shown[i].ref != shown[i - 1].ref)
            nqm_picture_show(&t->points, shown[i].ref, shown[i].ref);
    }
}

void nqm_transport_gradient(const nqm_transport *t, size_t n, const nqm_sample_pair *pairs, const float *by_light,
                            float *gradient) {
    const size_t n_points = t->points.n, n_values = 3 * t->n_directions;
    const nqm_kernels *kernels = nqm_kernels_get();
    for (size_t k = 0; k < n_values; ++k) /* each row of the matrix is read once for all pairs */
        for (size_t i = 0; i < n; ++i)
            if (!pairs[i].used || pairs[i].used[k / 3])
                gradient[i * n_values + k] +=
                    kernels->dot(n_points, t->light + k * n_points, by_light + (3 * i + k % 3) * n_points);
}
