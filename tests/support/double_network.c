/* SPDX-License-Identifier: MIT
 *
 * Linear layers, LayerNorm and GELU.
 */
#include "support/double_network.h"
#include "support/check.h"

#include <math.h>
#include <string.h>

enum { WIDEST = 2048 };

static void linear(const nqm_layer *layer, size_t n_in, size_t n, const double *from, double *to) {
    for (size_t j = 0; j < n; ++j) {
        to[j] = (double)layer->b[j];
        for (size_t i = 0; i < n_in; ++i)
            to[j] += (double)layer->w[j * n_in + i] * from[i];
    }
}

static void activate(const nqm_layer *layer, size_t n, double *y) {
    double mean = 0, variance = 0;
    for (size_t j = 0; j < n; ++j)
        mean += y[j] / (double)n;
    for (size_t j = 0; j < n; ++j)
        variance += (y[j] - mean) * (y[j] - mean) / (double)n;
    for (size_t j = 0; j < n; ++j) {
        const double v = (double)layer->gamma[j] * (y[j] - mean) / sqrt(variance + 1e-5) + (double)layer->beta[j];
        y[j] = v * 0.5 * erfc(-v / sqrt(2));
    }
}

void double_network(const nqm_params *params, const double *x, double *z) {
    double y[2][WIDEST];
    const nqm_net_shape *shape = &params->shape;
    const double *from = x;
    for (size_t l = 0; l < shape->n_layers; ++l) {
        const bool is_last = l + 1 == shape->n_layers;
        double *to = is_last ? z : y[l % 2];
        linear(&params->layer[l], shape->sizes[l], shape->sizes[l + 1], from, to);
        if (!is_last)
            activate(&params->layer[l], shape->sizes[l + 1], to);
        from = to;
    }
}

void make_random_params(const nqm_net_shape *shape, uint64_t seed, nqm_params *params) {
    nqm_rng rng = nqm_rng_make(seed, 1);
    assert_int_equal(nqm_params_create(shape, params, NULL), NQM_OK);
    nqm_params_init(params, seed);
    for (size_t l = 0; l < shape->n_layers; ++l)
        for (size_t i = 0; i < shape->sizes[l + 1]; ++i) {
            params->layer[l].b[i] = (float)nqm_rng_normal(&rng);
            if (params->layer[l].gamma) {
                params->layer[l].gamma[i] = (float)(1 + 0.2 * nqm_rng_normal(&rng));
                params->layer[l].beta[i] = (float)(0.2 * nqm_rng_normal(&rng));
            }
        }
}
