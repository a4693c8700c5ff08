/* SPDX-License-Identifier: MIT
 *
 * The parameters of the MLP: one block of floats, views into it, and their initial values (He et al. 2015,
 * DOI 10.1109/ICCV.2015.123; the uniform form that the paper's notebook uses).
 */
#include "net/net.h"

#include <math.h>

static bool has_norm(const nqm_net_shape *shape, size_t layer) {
    return layer + 1 < shape->n_layers;
}

size_t nqm_params_count(const nqm_net_shape *shape) {
    size_t n = 0;
    for (size_t l = 0; l < shape->n_layers; ++l)
        n += shape->sizes[l + 1] * (shape->sizes[l] + 1 + (has_norm(shape, l) ? 2 : 0));
    return n;
}

static bool shape_is_sane(const nqm_net_shape *shape) {
    if (shape->n_layers < 2 || shape->n_layers > NQM_NET_MAX_LAYERS ||
        shape->sizes[shape->n_layers] > NQM_NET_MAX_OUTPUTS)
        return false;
    for (size_t l = 0; l <= shape->n_layers; ++l)
        if (shape->sizes[l] < 1 || shape->sizes[l] > (size_t)1 << 24)
            return false;
    return true;
}

static void set_views(nqm_params *params) {
    const nqm_net_shape *shape = &params->shape;
    float *next = params->block;
    for (size_t l = 0; l < shape->n_layers; ++l) {
        size_t in = shape->sizes[l], out = shape->sizes[l + 1];
        nqm_layer *layer = &params->layer[l];
        *layer = (nqm_layer){.w = next, .b = next + out * in};
        next += out * in + out;
        if (has_norm(shape, l)) {
            layer->gamma = next;
            layer->beta = next + out;
            next += 2 * out;
        }
    }
}

nqm_status nqm_net_shape_check(const nqm_net_shape *shape, nqm_error *err) {
    if (shape_is_sane(shape))
        return NQM_OK;
    return nqm_fail(err, NQM_ERR_ARG, -1,
                    "network: the number of layers (2..8) or a width (1..16777216) is out of range, or there are more "
                    "than 16 outputs");
}

nqm_status nqm_params_create(const nqm_net_shape *shape, nqm_params *params_ret, nqm_error *err) {
    *params_ret = (nqm_params){0};
    nqm_status status = nqm_net_shape_check(shape, err);
    if (status != NQM_OK)
        return status;
    size_t n = nqm_params_count(shape);
    float *block = nqm_alloc(n, sizeof *block);
    if (!block)
        return nqm_fail_nomem(err, n * sizeof *block);
    *params_ret = (nqm_params){.shape = *shape, .n = n, .block = block};
    set_views(params_ret);
    return NQM_OK;
}

void nqm_params_free(nqm_params *params) {
    nqm_free(params->block);
    *params = (nqm_params){0};
}

void nqm_params_init(nqm_params *params, uint64_t seed) {
    for (size_t l = 0; l < params->shape.n_layers; ++l) {
        size_t in = params->shape.sizes[l], out = params->shape.sizes[l + 1];
        const nqm_layer *layer = &params->layer[l];
        nqm_rng rng = nqm_rng_make(seed, l);
        double limit = sqrt(6.0 / (double)in);
        for (size_t i = 0; i < out * in; ++i)
            layer->w[i] = (float)(limit * (2.0 * nqm_rng_uniform(&rng) - 1.0));
        for (size_t i = 0; i < out; ++i)
            layer->b[i] = 0.0f;
        if (!layer->gamma)
            continue;
        for (size_t i = 0; i < out; ++i) {
            layer->gamma[i] = 1.0f;
            layer->beta[i] = 0.0f;
        }
    }
}
