/* SPDX-License-Identifier: MIT
 *
 * Input samples of the hypernetwork: direction pairs dense around the mirror direction, because few samples would otherwise
 * miss narrow lobes, and values on two logarithmic scales, one that resolves dark bases and one for bright highlights.
 */
#include "brdf/brdf.h"
#include "fit/hyper.h"
#include "math/math.h"

#include <math.h>
#include <string.h>

static const double max_polar_rad = 80 * NQM_PI / 180; /* measurements at larger angles are often extrapolated */

void nqm_hyper_draw_dense(nqm_rng *rng, double *hd) {
    double cos_max = cos(max_polar_rad), wi[3], wo[3];
    do {
        double u = nqm_rng_uniform(rng);
        hd[0] = NQM_PI / 2 * u * u;
        hd[1] = NQM_PI / 2 * nqm_rng_uniform(rng);
        hd[2] = NQM_PI * nqm_rng_uniform(rng);
        nqm_half_diff_to_pair(hd, wi, wo);
    } while (wi[2] < cos_max || wo[2] < cos_max);
}

void nqm_hyper_draw_uniform(nqm_rng *rng, double *hd) {
    double cos_max = cos(max_polar_rad), pair[2][3];
    for (size_t k = 0; k < 2; ++k) {
        double theta = acos(1 - nqm_rng_uniform(rng) * (1 - cos_max));
        nqm_spherical(theta, 2 * NQM_PI * nqm_rng_uniform(rng), pair[k]);
    }
    nqm_half_diff_from_pair(pair[0], pair[1], hd);
}

void nqm_hyper_place(const double *hd, float *feature) {
    double wi[3], wo[3], difference[3];
    nqm_half_diff_to_pair(hd, wi, wo);
    nqm_spherical(hd[1], hd[2], difference);
    feature[0] = (float)sin(hd[0]);
    feature[1] = (float)cos(hd[0]);
    for (size_t k = 0; k < 3; ++k)
        feature[2 + k] = (float)difference[k];
    feature[5] = (float)(2 * sqrt(hd[0] / (NQM_PI / 2)) - 1);
    feature[6] = (float)(2 * wi[2] * wo[2] - 1);
}

void nqm_hyper_value(const float *rgb, float *feature) {
    const float dark = 1e-3f, centre = 2, spread = 0.5f;
    for (size_t c = 0; c < 3; ++c) {
        feature[c] = spread * (logf(rgb[c] + dark) + centre);
        feature[3 + c] = log1pf(rgb[c]);
    }
}

nqm_status nqm_hyper_sample(const nqm_brdf *ref, size_t n, nqm_rng *rng, double *hd, double *rgb, nqm_error *err) {
    enum { MAX_ROUNDS = 8 };
    uint8_t *flag = nqm_alloc(n, 1);
    if (!flag)
        return nqm_fail_nomem(err, n);
    size_t kept = 0;
    for (int round = 0; round < MAX_ROUNDS && kept < n; ++round) {
        size_t n_new = n - kept, from = kept;
        for (size_t i = 0; i < n_new; ++i)
            nqm_hyper_draw_dense(rng, hd + 3 * (from + i));
        nqm_brdf_eval_half_diff(ref, n_new, hd + 3 * from, rgb + 3 * from, flag);
        for (size_t i = 0; i < n_new; ++i) {
            if (!nqm_has_value(flag[i]))
                continue;
            memmove(hd + 3 * kept, hd + 3 * (from + i), 3 * sizeof *hd);
            memmove(rgb + 3 * kept, rgb + 3 * (from + i), 3 * sizeof *rgb);
            ++kept;
        }
    }
    nqm_free(flag);
    if (kept < n)
        return nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "%s: values at only %zu of %zu directions",
                        nqm_brdf_get_info(ref).name, kept, n);
    return NQM_OK;
}
