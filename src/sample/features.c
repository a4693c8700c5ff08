/* SPDX-License-Identifier: MIT
 *
 * The numbers that the network sees (paper, section 3.1): transform, whitening, and the two layouts of a pair.
 */
#include "kernel/kernel.h"
#include "sample/sample.h"

#include <math.h>
#include <nqm/train.h>
#include <string.h>

void nqm_features_transform(size_t n, const float *rho, float *t) {
    nqm_kernels_get()->sample_log(n, rho, t);
}

void nqm_features_restore(size_t n, const float *t, float *rho) {
    for (size_t i = 0; i < n; ++i) {
        float root = expm1f(t[i]);
        rho[i] = root * root * root;
    }
}

size_t nqm_features_width(int layout, size_t n_directions) {
    return (layout == NQM_LAYOUT_REF_TEST ? 6 : 9) * n_directions;
}

/* A multiple of the three channels that is one of the processor's vectors too. */
enum { STRETCH = 48 };

/* `n` numbers of a pair, at most STRETCH, the first of them red, into the members of the layout, which lie `apart`. */
static void compose_stretch(const nqm_features *features, size_t n, size_t apart, const float *mean, const float *scale,
                            const float *ref_t, const float *test_t, float *x) {
    const float s = (float)features->difference_scale;
    if (features->layout == NQM_LAYOUT_REF_TEST) {
#pragma omp simd
        for (size_t i = 0; i < n; ++i) {
            x[i] = (ref_t[i] - mean[i]) * scale[i];
            x[apart + i] = (test_t[i] - mean[i]) * scale[i];
        }
        return;
    }
#pragma omp simd
    for (size_t i = 0; i < n; ++i) {
        float ref = (ref_t[i] - mean[i]) * scale[i], difference = (test_t[i] - mean[i]) * scale[i] - ref;
        x[i] = ref;
        x[apart + i] = s * difference;
        x[2 * apart + i] = s * fabsf(difference);
    }
}

void nqm_features_compose(const nqm_features *features, size_t n_directions, const float *ref_t, const float *test_t,
                          const uint8_t *used, float *x) {
    const size_t n = 3 * n_directions, n_members = features->layout == NQM_LAYOUT_REF_TEST ? 2 : 3;
    float mean[STRETCH], scale[STRETCH];
    for (size_t i = 0; i < STRETCH; ++i) {
        mean[i] = features->mean[i % 3];
        scale[i] = 1 / features->std[i % 3];
    }
    for (size_t i = 0; i < n; i += STRETCH)
        compose_stretch(features, n - i < STRETCH ? n - i : STRETCH, n, mean, scale, ref_t + i, test_t + i, x + i);
    for (size_t k = 0; used && k < n_directions; ++k)
        for (size_t member = 0; !used[k] && member < n_members; ++member)
            memset(x + member * n + 3 * k, 0, 3 * sizeof *x);
}
