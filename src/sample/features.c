/* SPDX-License-Identifier: MIT
 *
 * The numbers that the network sees (paper, section 3.1): transform, whitening, and the two layouts of a pair.
 */
#include "sample/sample.h"

#include <math.h>
#include <nqm/train.h>

void nqm_features_transform(size_t n, const float *rho, float *t) {
    for (size_t i = 0; i < n; ++i)
        t[i] = log1pf(cbrtf(rho[i]));
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

void nqm_features_compose(const nqm_features *features, size_t n_directions, const float *ref_t, const float *test_t,
                          const uint8_t *used, float *x) {
    const size_t n = 3 * n_directions;
    const float s = (float)features->difference_scale;
    for (size_t i = 0; i < n; ++i) {
        size_t channel = i % 3;
        float mean = features->mean[channel], std = features->std[channel];
        bool counts = !used || used[i / 3];
        float ref = counts ? (ref_t[i] - mean) / std : 0;
        float test = counts ? (test_t[i] - mean) / std : 0;
        x[i] = ref;
        if (features->layout == NQM_LAYOUT_REF_TEST) {
            x[n + i] = test;
        } else {
            x[n + i] = s * (test - ref);
            x[2 * n + i] = s * fabsf(test - ref);
        }
    }
}
