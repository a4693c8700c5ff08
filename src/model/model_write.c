/* SPDX-License-Identifier: MIT
 *
 * The tables of a model file's content, and its writer: safetensors with the tensors and metadata that doc/model-format.md
 * describes.
 */
#include "kernel/half.h"
#include "model/model_file.h"

#include <string.h>

const char *const nqm_layer_suffixes[] = {"weight", "bias", "norm.weight", "norm.bias"};
const char *const nqm_layout_words[] = {
    [NQM_LAYOUT_REF_TEST] = "ref_test", [NQM_LAYOUT_REF_DIFF_ABSDIFF] = "ref_diff_absdiff", NULL};
const char *const nqm_target_words[] = {[NQM_TARGET_JOD] = "jod", [NQM_TARGET_LOG_DELTA_E] = "log_delta_e", NULL};

#define FIELD(member) offsetof(struct nqm_model, member)

const nqm_model_text nqm_model_texts[NQM_MODEL_TEXTS] = {
    {"id", NQM_PART_ALWAYS, FIELD(id), NULL},
    {"recipe", NQM_PART_ALWAYS, FIELD(recipe), NULL},
    {"layout", NQM_PART_ALWAYS, FIELD(features.layout), nqm_layout_words},
    {"target", NQM_PART_ALWAYS, FIELD(target), nqm_target_words},
    {"licence", NQM_PART_ALWAYS, FIELD(licence), NULL},
    {"card", NQM_PART_ALWAYS, FIELD(card), NULL},
    {"training", NQM_PART_ALWAYS, FIELD(training), NULL},
    {"manifest_sha256", NQM_PART_ALWAYS, FIELD(manifest_sha256), NULL},
    {"golden", NQM_PART_GOLDEN, FIELD(golden), NULL},
    {"scalars", NQM_PART_SCALARS, FIELD(scalar_names), NULL},
    {"calibration", NQM_PART_INTERVAL, FIELD(calibration), NULL},
};

const nqm_model_array nqm_model_arrays[NQM_MODEL_ARRAYS] = {
    {"whitening.mean", NQM_PART_ALWAYS, NQM_F32, 0, 3, FIELD(features.mean), 0},
    {"whitening.std", NQM_PART_ALWAYS, NQM_F32, 0, 3, FIELD(features.std), 0},
    {"difference_scale", NQM_PART_ALWAYS, NQM_F64, 0, 1, FIELD(features.difference_scale), 0},
    {"target", NQM_PART_ALWAYS, NQM_F64, 0, 4, FIELD(output), 0},
    {"label_parts", NQM_PART_LABEL, NQM_F64, NQM_LABEL_PARTS, 4, FIELD(parts), 0},
    {"jod_curve", NQM_PART_ALWAYS, NQM_F64, 0, 3, FIELD(curve), 0},
    {"scalars.mean", NQM_PART_SCALARS, NQM_F32, 0, NQM_EXTENT_SCALARS, FIELD(scalars.mean), 0},
    {"scalars.std", NQM_PART_SCALARS, NQM_F32, 0, NQM_EXTENT_SCALARS, FIELD(scalars.std), 0},
    {"scalars.scale", NQM_PART_SCALARS, NQM_F64, 0, 1, FIELD(scalars.scale), 0},
    {"interval", NQM_PART_INTERVAL, NQM_F64, 0, 3, FIELD(interval), FIELD(n_interval)},
    {"novelty.points", NQM_PART_NOVELTY, NQM_F32, 0, NQM_EXTENT_BLOCKS, FIELD(novelty_points), FIELD(n_novelty)},
    {"novelty.map", NQM_PART_NOVELTY, NQM_F32, NQM_EXTENT_SCALARS, NQM_EXTENT_SCALARS, FIELD(novelty_map), 0},
    {"transport.points", NQM_PART_TRANSPORT, NQM_F64, 0, 3, FIELD(transport_points), FIELD(n_points)},
    {"transport", NQM_PART_TRANSPORT, NQM_F32, 0, NQM_EXTENT_POINTS, FIELD(transport), FIELD(n_transport)},
    {"slopes.points", NQM_PART_SLOPES, NQM_F64, 0, 3, FIELD(slope_points), FIELD(n_slope_points)},
    {"slopes.wo", NQM_PART_SLOPES, NQM_F64, 0, 3, FIELD(slope_wo), FIELD(n_slope_wo)},
    {"slopes", NQM_PART_SLOPES, NQM_F32, 0, NQM_EXTENT_SLOPES, FIELD(slopes), FIELD(n_slopes)},
    {"novelty.scale", NQM_PART_NOVELTY, NQM_F64, 0, 2, FIELD(novelty_unit), 0},
    {"interval.spread", NQM_PART_SPREAD, NQM_F64, 0, NQM_SPREAD_FEATURES, FIELD(spread_growth), 0},
    {"interval.floor", NQM_PART_SPREAD, NQM_F64, 0, NQM_INTERVAL_KNOTS, FIELD(interval_floor), 0},
    {"similarity", NQM_PART_SIMILARITY, NQM_F64, 0, NQM_APART + 1, FIELD(similarity), 0},
};
_Static_assert(sizeof(nqm_output_range) == 4 * sizeof(double) && sizeof(nqm_curve) == 3 * sizeof(double) &&
                   FIELD(novelty_growth) == FIELD(novelty_unit) + sizeof(double),
               "members that one tensor stores are adjacent");

/* ---- writing ----------------------------------------------------------------------------------------------------- */

enum { MAX_TENSORS = NQM_LAYER_TENSORS * NQM_NET_MAX_LAYERS + 1 + NQM_MODEL_ARRAYS };

/* The tensors to write, with storage for their names. */
typedef struct contents {
    size_t n;
    nqm_tensor tensor[MAX_TENSORS];
    char name[MAX_TENSORS][NQM_TENSOR_NAME_MAX];
    uint16_t *half; /* the hidden layers' weights, if they are stored as float16; else NULL */
} contents;

static void add_layers(contents *c, const nqm_params *params) {
    uint16_t *half = c->half;
    for (size_t l = 0; l < params->shape.n_layers; ++l) {
        size_t in = params->shape.sizes[l], out = params->shape.sizes[l + 1];
        const nqm_layer *layer = &params->layer[l];
        const float *const parts[NQM_LAYER_TENSORS] = {layer->w, layer->b, layer->gamma, layer->beta};
        for (size_t i = 0; i < NQM_LAYER_TENSORS && (parts[i] || i == 0); ++i) {
            char *name = c->name[c->n];
            snprintf(name, NQM_TENSOR_NAME_MAX, "layers.%zu.%s", l, nqm_layer_suffixes[i]);
            if (i > 0) {
                c->tensor[c->n++] = nqm_tensor_of(name, NQM_F32, 0, out, parts[i]);
            } else if (!half || l + 1 == params->shape.n_layers) {
                c->tensor[c->n++] = nqm_tensor_of(name, NQM_F32, out, in, layer->w);
            } else {
                if (layer->half)
                    memcpy(half, layer->half, out * in * sizeof *half);
                else
                    nqm_half_from_float(out * in, layer->w, half);
                c->tensor[c->n++] = nqm_tensor_of(name, NQM_F16, out, in, half);
                half += out * in;
            }
        }
    }
}

static void collect(contents *c, const struct nqm_model *model, const bool *has) {
    add_layers(c, &model->params);
    c->tensor[c->n++] = nqm_tensor_of("directions_deg", NQM_F64, model->directions->n, 3, model->directions->degrees);
    for (const nqm_model_array *a = nqm_model_arrays; a < nqm_model_arrays + NQM_MODEL_ARRAYS; ++a) {
        const void *values = a->n_offset ? *nqm_model_block(model, a->offset) : nqm_model_at(model, a->offset);
        if (has[a->part])
            c->tensor[c->n++] =
                nqm_tensor_of(a->name, a->dtype, nqm_model_rows(model, a), nqm_model_extent(model, a->cols), values);
    }
}

static const char *text_of(const nqm_model *model, const nqm_model_text *t) {
    if (t->words)
        return t->words[*(const int *)nqm_model_at(model, t->offset)];
    const char *text = *nqm_model_block(model, t->offset);
    return text ? text : "";
}

nqm_status nqm_model_save(const nqm_model *model, const char *path, nqm_error *err) {
    NQM_REQUIRE(err, model, path);
    contents *c;
    uint16_t *half;
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&c, 1, sizeof *c},
                   {&half, model->stores_half ? nqm_params_count(&model->params.shape) : 0, sizeof *half}),
        err);
    if (status != NQM_OK)
        return status;
    const bool has[NQM_PART_COUNT] = {[NQM_PART_ALWAYS] = true,
                                      [NQM_PART_GOLDEN] = true,
                                      [NQM_PART_SCALARS] = model->scalar_names,
                                      [NQM_PART_INTERVAL] = model->interval,
                                      [NQM_PART_NOVELTY] = model->n_novelty > 0,
                                      [NQM_PART_LABEL] = nqm_model_has_parts(model),
                                      [NQM_PART_TRANSPORT] = model->transport,
                                      [NQM_PART_SLOPES] = model->slopes,
                                      [NQM_PART_SPREAD] = model->interval && nqm_model_has_spread(model),
                                      [NQM_PART_SIMILARITY] = model->similarity[NQM_APART] > 0};
    c->half = model->stores_half ? half : NULL;
    collect(c, model, has);
    nqm_meta meta[2 + NQM_MODEL_TEXTS] = {{"format", NQM_MODEL_FORMAT}, {"schema", NQM_MODEL_SCHEMA}};
    size_t n_meta = 2;
    for (const nqm_model_text *t = nqm_model_texts; t < nqm_model_texts + NQM_MODEL_TEXTS; ++t)
        if (has[t->part])
            meta[n_meta++] = (nqm_meta){t->key, text_of(model, t)};
    status = nqm_safetensors_write(path, c->n, c->tensor, n_meta, meta, NULL, err);
    nqm_free(c);
    return status;
}
