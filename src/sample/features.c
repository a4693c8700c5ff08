/* SPDX-License-Identifier: MIT
 *
 * Input features of the network (paper, section 3.1): transform, whitening, and the two layouts of a pair.
 */
#include "sample/loops.h"
#include "sample/sample.h"

#include <math.h>
#include <string.h>

void nqm_features_transform(size_t n, const float *rho, float *t) {
    nqm_sample_logs(n, rho, t, t);
}

void nqm_features_restore(size_t n, const float *t, float *rho) {
    for (size_t i = 0; i < n; ++i) {
        float root = expm1f(t[i]);
        rho[i] = root * root * root;
    }
}

size_t nqm_features_width(nqm_layout layout, size_t n_directions) {
    return (layout == NQM_LAYOUT_REF_TEST ? 6 : 9) * n_directions;
}

void nqm_features_compose(const nqm_features *features, size_t n_directions, const float *ref_t, const float *test_t,
                          const uint8_t *used, float *x) {
    const size_t n = 3 * n_directions, n_members = features->layout == NQM_LAYOUT_REF_TEST ? 2 : 3;
    float mean[NQM_WHITEN_PERIOD], scale[NQM_WHITEN_PERIOD];
    for (size_t i = 0; i < NQM_WHITEN_PERIOD; ++i) {
        mean[i] = features->mean[i % 3];
        scale[i] = 1 / features->std[i % 3];
    }
    nqm_sample_whiten(n, mean, scale, ref_t, x);
    nqm_sample_whiten(n, mean, scale, test_t, x + n);
    if (features->layout != NQM_LAYOUT_REF_TEST)
        nqm_sample_differences(n, (float)features->difference_scale, x, x + n, x + n, x + 2 * n);
    for (size_t k = 0; used && k < n_directions; ++k)
        for (size_t member = 0; !used[k] && member < n_members; ++member)
            memset(x + member * n + 3 * k, 0, 3 * sizeof *x);
}

/* The same of n values, at most NQM_WHITEN_PERIOD. scale: (NQM_WHITEN_PERIOD) difference_scale, or 1, by the standard deviation. */
NQM_FOR_EACH_VECTOR_WIDTH
static void find_slopes(size_t n, const float *scale, const float *root, const float *by_test, const float *difference,
                        const float *by_magnitude, float *gradient) {
    const float least = cbrtf((float)NQM_LEAST_F);
#pragma omp simd
    for (size_t i = 0; i < n; ++i) {
        const float r = root[i] > least ? root[i] : least;
        const float sign = (difference[i] > 0 ? 1.0F : 0.0F) - (difference[i] < 0 ? 1.0F : 0.0F);
        gradient[i] = (by_test[i] + sign * by_magnitude[i]) * scale[i] / (3 * r * r * (r + 1));
    }
}

void nqm_features_gradient(const nqm_features *features, size_t n_directions, const float *root, const uint8_t *used,
                           const float *x, const float *dx, float *gradient) {
    static const float zeros[NQM_WHITEN_PERIOD];
    const size_t n = 3 * n_directions;
    const bool differs = features->layout != NQM_LAYOUT_REF_TEST;
    float scale[NQM_WHITEN_PERIOD];
    for (size_t i = 0; i < NQM_WHITEN_PERIOD; ++i)
        scale[i] = (differs ? (float)features->difference_scale : 1) / features->std[i % 3];
    for (size_t i = 0; i < n; i += NQM_WHITEN_PERIOD)
        find_slopes(nqm_smaller(n - i, NQM_WHITEN_PERIOD), scale, root + i, dx + n + i, differs ? x + n + i : zeros,
                    differs ? dx + 2 * n + i : zeros, gradient + i);
    for (size_t k = 0; used && k < n_directions; ++k)
        if (!used[k])
            memset(gradient + 3 * k, 0, 3 * sizeof *gradient);
}
