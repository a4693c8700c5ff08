/* SPDX-License-Identifier: MIT
 *
 * The description of models; their deallocation; copies of models for changes to them: calibration, text of the card,
 * weights in float16.
 */
#include "kernel/half.h"
#include "model/model_file.h"

#include <math.h>
#include <string.h>

const char *nqm_model_builtin_name(size_t i) {
    const nqm_embedded_file *file = nqm_embedded_models;
    while (i > 0 && file->name) {
        ++file;
        --i;
    }
    return file->name;
}

void nqm_model_free(struct nqm_model *model) {
    if (!model)
        return;
    nqm_directions_free(model->directions);
    nqm_params_free(&model->params);
    for (const nqm_model_text *t = nqm_model_texts; t < nqm_model_texts + NQM_MODEL_TEXTS; ++t)
        if (!t->words)
            nqm_free(*nqm_model_block(model, t->offset));
    nqm_inference_net_free(model->inference);
    nqm_free(model->interval);
    nqm_free(model->transport);
    nqm_free(model->transport_points);
    nqm_free(model->slopes);
    nqm_free(model->slope_points);
    nqm_free(model->slope_wo);
    nqm_free(model->novelty_points);
    nqm_map_close(&model->file);
    nqm_free(model->memory);
    nqm_free(model);
}

nqm_model_info nqm_model_get_info(const nqm_model *model) {
    assert(model);
    const nqm_net_shape *shape = &model->params.shape;
    nqm_model_info info = {.id = model->id,
                           .recipe = model->recipe,
                           .sha256 = model->sha256,
                           .card = model->card,
                           .licence = model->licence,
                           .manifest_sha256 = model->manifest_sha256,
                           .n_parameters = nqm_params_count(shape),
                           .n_layers = shape->n_layers,
                           .layer_sizes = shape->sizes,
                           .directions = model->directions,
                           .calibration = model->calibration ? model->calibration : ""};
    const nqm_label equal = {0}, opposite = {.delta_e = 1e9}; /* the ends of the curve */
    double at_low = nqm_model_jod(model, -INFINITY, model->transport || model->slopes ? &equal : NULL, NULL);
    double at_high = nqm_model_jod(model, INFINITY, model->transport || model->slopes ? &opposite : NULL, NULL);
    info.jod_min = fmin(at_low, at_high); /* the JOD of a model that predicts Delta-E decreases with its output */
    info.jod_max = fmax(at_low, at_high);
    return info;
}

nqm_status nqm_model_set_transport(nqm_model *model, const nqm_transport *t, nqm_error *err) {
    const size_t n_light = t->n_directions * 3 * t->points.n, n_points = 3 * t->points.n;
    float *light = nqm_alloc(n_light, sizeof *light);
    double *points = nqm_alloc(n_points, sizeof *points);
    if (!light || !points) {
        nqm_free(light);
        nqm_free(points);
        return nqm_fail_nomem(err, n_light * sizeof *light);
    }
    memcpy(light, t->light, n_light * sizeof *light);
    memcpy(points, t->points.at, n_points * sizeof *points);
    nqm_free(model->transport);
    nqm_free(model->transport_points);
    model->transport = light;
    model->transport_points = points;
    model->n_transport = t->n_directions;
    model->n_points = t->points.n;
    return NQM_OK;
}

/* ---- copies ------------------------------------------------------------------------------------------------------ */

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

/* Copy the block of n_bytes whose address is at `offset`; NULL gives NULL. false when out of memory. */
static bool copy_block(const nqm_model *from, size_t offset, size_t n_bytes, nqm_model *to) {
    const void *block = *nqm_model_block(from, offset);
    void *copy = *nqm_model_block(to, offset) = block ? nqm_alloc(n_bytes, 1) : NULL;
    if (copy)
        memcpy(copy, block, n_bytes);
    return copy || !block;
}

static bool copy_blocks(const nqm_model *from, nqm_model *to) {
    bool ok = true;
    for (const nqm_model_text *t = nqm_model_texts; ok && t < nqm_model_texts + NQM_MODEL_TEXTS; ++t) {
        const char *text = t->words ? NULL : *nqm_model_block(from, t->offset);
        ok = !text || copy_block(from, t->offset, strlen(text) + 1, to);
    }
    for (const nqm_model_array *a = nqm_model_arrays; ok && a < nqm_model_arrays + NQM_MODEL_ARRAYS; ++a)
        ok = !a->n_offset ||
             copy_block(from, a->offset,
                        nqm_model_rows(from, a) * nqm_model_extent(from, a->cols) * nqm_dtype_size(a->dtype), to);
    return ok;
}

nqm_status nqm_model_copy(const nqm_model *model, nqm_model **copy_ret, nqm_error *err) {
    *copy_ret = NULL;
    nqm_model *copy = nqm_alloc(1, sizeof *copy);
    if (!copy)
        return nqm_fail_nomem(err, sizeof *copy);
    memcpy(copy, model, offsetof(struct nqm_model, params));
    nqm_status status = nqm_model_has_network(model) ? copy_params(&model->params, &copy->params, err) : NQM_OK;
    if (status == NQM_OK && !copy_blocks(model, copy))
        status = nqm_fail_nomem(err, sizeof *copy);
    if (status == NQM_OK)
        status = nqm_directions_from_degrees(model->directions->n, model->directions->degrees, &copy->directions, err);
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
