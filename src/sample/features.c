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

/* d t / d f_r of n values, at most NQM_WHITEN_PERIOD. */
static void transform_slopes(size_t n, const float *rho, double *slope) {
    double f[NQM_WHITEN_PERIOD], root[NQM_WHITEN_PERIOD];
    for (size_t i = 0; i < n; ++i)
        f[i] = fmax((double)rho[i], NQM_LEAST_F);
    nqm_sample_cube_roots(n, f, root);
    for (size_t i = 0; i < n; ++i)
        slope[i] = 1 / (3 * root[i] * root[i] * (root[i] + 1));
}

void nqm_features_gradient(const nqm_features *features, size_t n_directions, const float *test, const uint8_t *used,
                           const float *x, const float *dx, double *gradient) {
    const size_t n = 3 * n_directions;
    const bool differs = features->layout != NQM_LAYOUT_REF_TEST;
    const double scale = differs ? features->difference_scale : 1;
    double slope[NQM_WHITEN_PERIOD];
    for (size_t i = 0; i < n; ++i) {
        if (i % NQM_WHITEN_PERIOD == 0)
            transform_slopes(nqm_smaller(n - i, NQM_WHITEN_PERIOD), test + i, slope);
        if (used && !used[i / 3])
            continue;
        double by_t = (double)dx[n + i];
        if (differs)
            by_t += x[n + i] > 0 ? (double)dx[2 * n + i] : x[n + i] < 0 ? -(double)dx[2 * n + i] : 0;
        gradient[i] += by_t * scale / (double)features->std[i % 3] * slope[i % NQM_WHITEN_PERIOD];
    }
}
