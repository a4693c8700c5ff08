/* SPDX-License-Identifier: MIT
 *
 * Writes a model file: safetensors with the tensors and metadata that doc/files.md describes.
 */
#include "io/io.h"
#include "kernel/half.h"
#include "model/model.h"
#include "model/model_file.h"

#include <string.h>

const char *const nqm_layer_suffixes[] = {"weight", "bias", "norm.weight", "norm.bias"};
const char *const nqm_layout_names[] = {
    [NQM_LAYOUT_REF_TEST] = "ref_test", [NQM_LAYOUT_REF_DIFF_ABSDIFF] = "ref_diff_absdiff"};
const char *const nqm_target_names[] = {[NQM_TARGET_JOD] = "jod", [NQM_TARGET_LOG_DELTA_E] = "log_delta_e"};

enum { MAX_TENSORS = NQM_LAYER_TENSORS * NQM_NET_MAX_LAYERS + 13 };

/* The tensors to write, with storage for their names and for tensors that combine several fields of the model. */
typedef struct contents {
    size_t n;
    nqm_tensor tensor[MAX_TENSORS];
    char name[MAX_TENSORS][NQM_TENSOR_NAME_MAX];
    double target[4], curve[3], novelty[2];
    uint16_t *half; /* the hidden layers' weights, if they are stored as float16; else NULL */
} contents;

static nqm_tensor *add(contents *c, const char *name, nqm_dtype dtype, size_t n, const void *data) {
    nqm_tensor *tensor = &c->tensor[c->n++];
    size_t item = dtype == NQM_F64 ? sizeof(double) : dtype == NQM_F32 ? sizeof(float) : sizeof(uint16_t);
    *tensor = (nqm_tensor){.name = name, .dtype = dtype, .n_dims = 1, .dims = {n}, .n_bytes = n * item, .data = data};
    return tensor;
}

static void set_matrix(nqm_tensor *tensor, size_t rows, size_t cols) {
    tensor->n_dims = 2;
    tensor->dims[0] = rows;
    tensor->dims[1] = cols;
}

static void add_layers(contents *c, const nqm_params *params) {
    uint16_t *half = c->half;
    for (size_t l = 0; l < params->shape.n_layers; ++l) {
        size_t in = params->shape.sizes[l], out = params->shape.sizes[l + 1];
        const nqm_layer *layer = &params->layer[l];
        const float *const parts[NQM_LAYER_TENSORS] = {layer->w, layer->b, layer->gamma, layer->beta};
        for (size_t i = 0; i < NQM_LAYER_TENSORS && (parts[i] || i == 0); ++i) {
            char *name = c->name[c->n];
            snprintf(name, NQM_TENSOR_NAME_MAX, "layers.%zu.%s", l, nqm_layer_suffixes[i]);
            const bool in_half = half && i == 0 && l + 1 < params->shape.n_layers;
            if (in_half && layer->half)
                memcpy(half, layer->half, out * in * sizeof *half);
            else if (in_half)
                nqm_half_from_float(out * in, layer->w, half);
            nqm_tensor *tensor = add(c, name, in_half ? NQM_F16 : NQM_F32, i == 0 ? out * in : out,
                                     in_half ? (const void *)half : parts[i]);
            if (i == 0)
                set_matrix(tensor, out, in);
            if (in_half)
                half += out * in;
        }
    }
}

static void collect(contents *c, const struct nqm_model *model) {
    const double target[4] = {model->target_mean, model->target_std, model->out_lo, model->out_hi};
    const double curve[3] = {model->curve.b1, model->curve.b2, model->curve.b3};
    memcpy(c->target, target, sizeof target);
    memcpy(c->curve, curve, sizeof curve);
    add_layers(c, &model->params);
    set_matrix(add(c, "directions_deg", NQM_F64, 3 * model->n_directions, model->directions_deg), model->n_directions,
               3);
    add(c, "whitening.mean", NQM_F32, 3, model->mean);
    add(c, "whitening.std", NQM_F32, 3, model->std);
    add(c, "difference_scale", NQM_F64, 1, &model->difference_scale);
    add(c, "target", NQM_F64, 4, c->target);
    add(c, "jod_curve", NQM_F64, 3, c->curve);
    if (model->scalar_names) {
        add(c, "scalars.mean", NQM_F32, NQM_SCALAR_COUNT, model->scalar_mean);
        add(c, "scalars.std", NQM_F32, NQM_SCALAR_COUNT, model->scalar_std);
        add(c, "scalars.scale", NQM_F64, 1, &model->scalar_scale);
    }
    if (model->interval)
        set_matrix(add(c, "interval", NQM_F64, 3 * model->n_interval, model->interval), model->n_interval, 3);
    if (model->n_novelty) {
        const size_t width = NQM_SCALAR_COUNT * NQM_NOVELTY_BLOCK;
        c->novelty[0] = model->novelty_unit, c->novelty[1] = model->novelty_growth;
        set_matrix(add(c, "novelty.points", NQM_F32, width * model->n_novelty, model->novelty_points), model->n_novelty,
                   width);
        set_matrix(add(c, "novelty.map", NQM_F32, NQM_SCALAR_COUNT * NQM_SCALAR_COUNT, model->novelty_map),
                   NQM_SCALAR_COUNT, NQM_SCALAR_COUNT);
        add(c, "novelty.scale", NQM_F64, 2, c->novelty);
    }
}

static const char *text_or_empty(const char *text) {
    return text ? text : "";
}

nqm_status nqm_model_save(const nqm_model *model, const char *path, nqm_error *err) {
    contents *c = nqm_alloc(1, sizeof *c);
    uint16_t *half = model->stores_half ? nqm_alloc(nqm_params_count(&model->params.shape), sizeof *half) : NULL;
    if (!c || (model->stores_half && !half)) {
        nqm_free(c);
        return nqm_fail_nomem(err, sizeof *c);
    }
    c->half = half;
    collect(c, model);
    enum { N_ALWAYS = 11, N_OPTIONAL = 2 };
    nqm_meta meta[N_ALWAYS + N_OPTIONAL] = {{"format", NQM_MODEL_FORMAT},
                                            {"schema", NQM_MODEL_SCHEMA},
                                            {"id", text_or_empty(model->id)},
                                            {"recipe", text_or_empty(model->recipe)},
                                            {"layout", nqm_layout_names[model->layout]},
                                            {"target", nqm_target_names[model->target]},
                                            {"licence", text_or_empty(model->licence)},
                                            {"card", text_or_empty(model->card)},
                                            {"training", text_or_empty(model->training)},
                                            {"manifest_sha256", text_or_empty(model->manifest_sha256)},
                                            {"golden", text_or_empty(model->golden)}};
    size_t n_meta = N_ALWAYS;
    if (model->scalar_names)
        meta[n_meta++] = (nqm_meta){"scalars", model->scalar_names};
    if (model->interval)
        meta[n_meta++] = (nqm_meta){"calibration", text_or_empty(model->calibration)};
    nqm_status status = nqm_safetensors_write(path, c->n, c->tensor, n_meta, meta, NULL, err);
    nqm_free(half);
    nqm_free(c);
    return status;
}
