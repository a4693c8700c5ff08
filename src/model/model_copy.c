/* SPDX-License-Identifier: MIT
 *
 * Copies of a model, for changes to it: calibration, text of its card, weights in float16.
 */
#include "kernel/half.h"
#include "model/model.h"

#include <math.h>
#include <string.h>

static nqm_status copy_params(const nqm_params *from, nqm_params *to, nqm_error *err) {
    nqm_status status = nqm_params_create(&from->shape, to, err);
    for (size_t l = 0; status == NQM_OK && l < from->shape.n_layers; ++l) {
        const size_t in = from->shape.sizes[l], out = from->shape.sizes[l + 1];
        const nqm_layer *a = &from->layer[l], *b = &to->layer[l];
        if (a->half)
            nqm_half_to_float(in * out, a->half, b->w);
        else
            memcpy(b->w, a->w, in * out * sizeof(float));
        memcpy(b->b, a->b, out * sizeof(float));
        if (b->gamma) {
            memcpy(b->gamma, a->gamma, out * sizeof(float));
            memcpy(b->beta, a->beta, out * sizeof(float));
        }
    }
    return status;
}

/* Copy a block of n_bytes; NULL gives NULL. false when out of memory. */
static bool copy_block(const void *from, size_t n_bytes, void **to) {
    *to = from ? nqm_alloc(n_bytes, 1) : NULL;
    if (*to)
        memcpy(*to, from, n_bytes);
    return *to || !from;
}

static bool copy_text(const char *from, char **to) {
    *to = from ? nqm_strdup(from) : NULL;
    return *to || !from;
}

static bool copy_blocks(const nqm_model *from, nqm_model *to) {
    const size_t row = 3 * sizeof(double), block = NQM_SCALAR_COUNT * NQM_NOVELTY_BLOCK * sizeof(float);
    return copy_block(from->directions_deg, from->n_directions * row, (void **)&to->directions_deg) &&
           copy_block(from->interval, from->n_interval * row, (void **)&to->interval) &&
           copy_block(from->novelty_points, from->n_novelty * block, (void **)&to->novelty_points) &&
           copy_text(from->scalar_names, &to->scalar_names) && copy_text(from->id, &to->id) &&
           copy_text(from->recipe, &to->recipe) && copy_text(from->card, &to->card) &&
           copy_text(from->licence, &to->licence) && copy_text(from->manifest_sha256, &to->manifest_sha256) &&
           copy_text(from->training, &to->training) && copy_text(from->golden, &to->golden) &&
           copy_text(from->calibration, &to->calibration);
}

nqm_status nqm_model_copy(const nqm_model *model, nqm_model **copy_ret, nqm_error *err) {
    *copy_ret = NULL;
    nqm_model *copy = nqm_alloc(1, sizeof *copy);
    if (!copy)
        return nqm_fail_nomem(err, sizeof *copy);
    memcpy(copy, model, offsetof(struct nqm_model, params));
    nqm_status status = copy_params(&model->params, &copy->params, err);
    if (status == NQM_OK && !copy_blocks(model, copy))
        status = nqm_fail_nomem(err, model->n_directions * 3 * sizeof(double));
    if (status == NQM_OK)
        status = nqm_model_attach_directions(copy, err);
    if (status == NQM_OK)
        *copy_ret = copy;
    else
        nqm_model_free(copy);
    return status;
}

nqm_status nqm_model_round_to_half(nqm_model *model, nqm_error *err) {
    const nqm_net_shape *shape = &model->params.shape;
    for (size_t l = 0; l + 1 < shape->n_layers; ++l)
        for (size_t row = 0; row < shape->sizes[l + 1]; ++row)
            for (size_t i = 0; i < shape->sizes[l]; ++i) {
                float *w = &model->params.layer[l].w[row * shape->sizes[l] + i];
                uint16_t half;
                if (!(fabsf(*w) < 65520))
                    return nqm_fail(err, NQM_ERR_NUMERIC, -1,
                                    "model '%s': weight %g of layer %zu is too large for 16 bits (65504 at most)",
                                    model->id, (double)*w, l);
                nqm_half_from_float(1, w, &half);
                nqm_half_to_float(1, &half, w);
            }
    model->stores_half = true;
    return NQM_OK;
}
