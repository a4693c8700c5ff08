/* SPDX-License-Identifier: MIT
 *
 * Random direction pairs for fits and for the training of networks, and values of a BRDF there.
 */
#include "encode/encode.h"
#include "math/math.h"

#include <math.h>
#include <string.h>

void nqm_encode_draw_uniform(nqm_rng *rng, double max_polar, double *wi, double *wo) {
    double cos_max = cos(max_polar);
    double *both[2] = {wi, wo};
    for (int k = 0; k < 2; ++k) {
        double cos_theta = 1 - nqm_rng_uniform(rng) * (1 - cos_max);
        nqm_spherical(acos(cos_theta), 2 * NQM_PI * nqm_rng_uniform(rng), both[k]);
    }
}

void nqm_encode_draw_dense(nqm_rng *rng, double max_polar, double max_theta, double max_phi, double *hd) {
    double cos_max = cos(max_polar), wi[3], wo[3];
    do {
        double u = nqm_rng_uniform(rng);
        hd[0] = max_theta * u * u;
        hd[1] = max_theta * nqm_rng_uniform(rng);
        hd[2] = max_phi * nqm_rng_uniform(rng);
        nqm_half_diff_to_pair(hd, wi, wo);
    } while (wi[2] < cos_max || wo[2] < cos_max);
}

size_t nqm_encode_keep_valid(size_t n, const uint8_t *flag, double *hd, double *rgb) {
    size_t kept = 0;
    for (size_t i = 0; i < n; ++i) {
        if (!nqm_has_value(flag[i]))
            continue;
        memmove(hd + 3 * kept, hd + 3 * i, 3 * sizeof *hd);
        memmove(rgb + 3 * kept++, rgb + 3 * i, 3 * sizeof *rgb);
    }
    return kept;
}

size_t nqm_encode_sample(const nqm_brdf *ref, size_t n, void (*draw)(nqm_rng *rng, double *hd), nqm_rng *rng,
                         double *hd, double *rgb) {
    enum { AT_ONCE = 256 };
    size_t kept = 0;
    for (size_t tried = 0, n_new; kept < n && tried < NQM_ENCODE_MAX_TRIES * n; tried += n_new) {
        uint8_t flag[AT_ONCE];
        double *own_hd = hd + 3 * kept, *own_rgb = rgb + 3 * kept;
        n_new = nqm_smaller(n - kept, AT_ONCE);
        for (size_t i = 0; i < n_new; ++i)
            draw(rng, own_hd + 3 * i);
        nqm_brdf_eval_half_diff(ref, n_new, own_hd, own_rgb, flag);
        kept += nqm_encode_keep_valid(n_new, flag, own_hd, own_rgb);
    }
    return kept;
}
