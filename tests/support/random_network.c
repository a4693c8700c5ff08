/* SPDX-License-Identifier: MIT
 *
 * A linear congruential generator (Knuth, MMIX).
 */
#include "support/random_network.h"
#include "support/check.h"

double random_unit(uint64_t *seed) {
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return (double)(*seed >> 11) / 9007199254740992.0;
}

void fill_random(uint64_t *seed, size_t n, double range, float *to) {
    for (size_t i = 0; i < n; ++i)
        to[i] = (float)((2 * random_unit(seed) - 1) * range);
}

void make_random_params(const nqm_net_shape *shape, uint64_t seed, nqm_params *params) {
    assert_int_equal(nqm_params_create(shape, params, NULL), NQM_OK);
    for (size_t l = 0; l < shape->n_layers; ++l) {
        const nqm_layer *layer = &params->layer[l];
        const size_t n_in = shape->sizes[l], n = shape->sizes[l + 1];
        fill_random(&seed, n_in * n, sqrt(3 / (double)n_in), layer->w);
        fill_random(&seed, n, 1.5, layer->b);
        if (!layer->gamma)
            continue;
        fill_random(&seed, n, 0.4, layer->gamma);
        fill_random(&seed, n, 0.4, layer->beta);
        for (size_t i = 0; i < n; ++i)
            layer->gamma[i] += 1;
    }
}
