/* SPDX-License-Identifier: MIT
 *
 * Random direction pairs for fits and for the training of networks.
 */
#include "encode/encode.h"
#include "math/math.h"

#include <math.h>

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
