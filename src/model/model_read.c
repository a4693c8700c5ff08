/* SPDX-License-Identifier: MIT
 *
 * Reads a model file (doc/files.md). A missing or surplus tensor, a wrong type or shape, a value that is not finite or
 * a wrong checksum is an error; for a tensor the message gives its name.
 */
#include "io/io.h"
#include "model/model.h"
#include "model/model_file.h"

#include <string.h>

enum { CACHE_LINE = 64 };

/* State of reading a file. */
typedef struct reader {
    const nqm_safetensors *st;
    const char *name;
    bool verify;
    bool *used; /* (tensors of the file) true once a tensor has been read as part of the model */
    nqm_error *err;
} reader;

static nqm_status refuse(const reader *r, const nqm_tensor *tensor, const char *what) {
    return nqm_fail(r->err, NQM_ERR_MODEL, tensor->byte_offset, "%s: tensor '%.64s' %s (byte %lld)", r->name,
                    tensor->name, what, (long long)tensor->byte_offset);
}

/* ---- tensors ----------------------------------------------------------------------------------------------------- */

/* The name, type and shape that a tensor must have. */
typedef struct expectation {
    const char *name;
    nqm_dtype dtype;
    size_t rows, cols; /* rows 0: a vector of length `cols` */
    bool may_be_half;  /* F16 is accepted in place of dtype */
    bool is_large;     /* checked for values that are not finite only when verifying */
} expectation;

static nqm_status get(reader *r, const expectation *e, const nqm_tensor **tensor_ret) {
    const nqm_tensor *tensor = nqm_safetensors_find(r->st, e->name);
    if (!tensor)
        return nqm_fail(r->err, NQM_ERR_MODEL, -1, "%s: tensor '%s' is missing", r->name, e->name);
    bool fits = e->rows ? tensor->n_dims == 2 && tensor->dims[0] == e->rows && tensor->dims[1] == e->cols
                        : tensor->n_dims == 1 && tensor->dims[0] == e->cols;
    bool has_type = tensor->dtype == e->dtype || (e->may_be_half && tensor->dtype == NQM_F16);
    if (!has_type || !fits)
        return refuse(r, tensor, "has the wrong type or shape");
    if ((r->verify || !e->is_large) && !nqm_tensor_all_finite(tensor))
        return refuse(r, tensor, "holds a value that is not finite");
    r->used[tensor - nqm_safetensors_at(r->st, 0)] = true;
    *tensor_ret = tensor;
    return NQM_OK;
}

static nqm_status get_doubles(reader *r, const char *name, size_t n, double *out) {
    const nqm_tensor *tensor;
    nqm_status status = get(r, &(expectation){.name = name, .dtype = NQM_F64, .cols = n}, &tensor);
    if (status == NQM_OK)
        memcpy(out, tensor->data, tensor->n_bytes);
    return status;
}

static nqm_status get_floats(reader *r, const char *name, size_t n, float *out) {
    const nqm_tensor *tensor;
    nqm_status status = get(r, &(expectation){.name = name, .dtype = NQM_F32, .cols = n}, &tensor);
    if (status == NQM_OK)
        memcpy(out, tensor->data, tensor->n_bytes);
    return status;
}

/* ---- the network ------------------------------------------------------------------------------------------------- */

/* Derive the layer widths from the shapes of the weight matrices in the file. */
static nqm_status read_shape(const reader *r, nqm_net_shape *shape) {
    *shape = (nqm_net_shape){0};
    for (size_t l = 0; l < NQM_NET_MAX_LAYERS; ++l) {
        char name[NQM_TENSOR_NAME_MAX];
        snprintf(name, sizeof name, "layers.%zu.weight", l);
        const nqm_tensor *w = nqm_safetensors_find(r->st, name);
        if (!w)
            break;
        bool follows = w->n_dims == 2 && (l == 0 || w->dims[1] == shape->sizes[l]);
        if (!follows || w->n_bytes == 0)
            return refuse(r, w, "does not follow from the layer before it");
        shape->sizes[l] = w->dims[1];
        shape->sizes[l + 1] = w->dims[0];
        shape->n_layers = l + 1;
    }
    size_t n = shape->n_layers;
    if (n == 0 || shape->sizes[n] != 1) /* the last layer has one output */
        return nqm_fail(r->err, NQM_ERR_MODEL, -1, "%s: tensor 'layers.%zu.weight' is missing", r->name, n);
    return NQM_OK;
}

/* The tensors of a network, layer by layer; NULL where a layer has none. */
typedef struct network {
    const nqm_tensor *part[NQM_NET_MAX_LAYERS][NQM_LAYER_TENSORS];
    size_t n_bytes; /* of all tensors, each rounded up to whole cache lines */
    bool in_place;  /* every tensor is aligned to its element size */
} network;

static size_t padded_size(const nqm_tensor *tensor) {
    return nqm_ceil_div(tensor->n_bytes, CACHE_LINE) * CACHE_LINE;
}

static nqm_status find_layer(reader *r, const nqm_net_shape *shape, size_t l, network *net) {
    const size_t in = shape->sizes[l], out = shape->sizes[l + 1];
    const bool hidden = l + 1 < shape->n_layers;
    for (size_t i = 0; i < (hidden ? NQM_LAYER_TENSORS : 2); ++i) {
        char name[NQM_TENSOR_NAME_MAX];
        snprintf(name, sizeof name, "layers.%zu.%s", l, nqm_layer_suffixes[i]);
        const expectation e = {.name = name,
                               .dtype = NQM_F32,
                               .rows = i == 0 ? out : 0,
                               .cols = i == 0 ? in : out,
                               .may_be_half = hidden && i == 0,
                               .is_large = true};
        const nqm_tensor **part = &net->part[l][i];
        nqm_status status = get(r, &e, part);
        if (status != NQM_OK)
            return status;
        const size_t item = (*part)->dtype == NQM_F16 ? sizeof(uint16_t) : sizeof(float);
        net->in_place &= (uintptr_t)(*part)->data % item == 0;
        net->n_bytes += padded_size(*part);
    }
    return NQM_OK;
}

/* Use the tensors as the network's parameters: in place, or copied if one of them is not aligned (files of other
 * writers). Models are immutable, so nothing is written through a pointer into the file. */
static nqm_status set_params(const network *net, struct nqm_model *model, nqm_error *err) {
    unsigned char *next = net->in_place ? NULL : nqm_alloc(net->n_bytes, 1);
    if (!net->in_place && !next)
        return nqm_fail_nomem(err, net->n_bytes);
    model->memory = next;
    for (size_t l = 0; l < model->params.shape.n_layers; ++l) {
        nqm_layer *layer = &model->params.layer[l];
        float **const views[NQM_LAYER_TENSORS] = {&layer->w, &layer->b, &layer->gamma, &layer->beta};
        for (size_t i = 0; i < NQM_LAYER_TENSORS && net->part[l][i]; ++i) {
            const nqm_tensor *part = net->part[l][i];
            const void *data = next ? memcpy(next, part->data, part->n_bytes) : part->data;
            next = next ? next + padded_size(part) : NULL;
            model->stores_half |= part->dtype == NQM_F16;
            if (part->dtype == NQM_F16)
                layer->half = data;
            else
                *views[i] = (float *)(uintptr_t)data;
        }
    }
    return NQM_OK;
}

static nqm_status read_network(reader *r, struct nqm_model *model) {
    nqm_net_shape *shape = &model->params.shape;
    network net = {.in_place = true};
    nqm_status status = read_shape(r, shape);
    for (size_t l = 0; status == NQM_OK && l < shape->n_layers; ++l)
        status = find_layer(r, shape, l, &net);
    if (status != NQM_OK)
        return status;
    model->params.n = nqm_params_count(shape);
    return set_params(&net, model, r->err);
}

/* ---- everything else --------------------------------------------------------------------------------------------- */

static nqm_status check_header(const reader *r) {
    const char *format = nqm_safetensors_meta(r->st, "format"), *schema = nqm_safetensors_meta(r->st, "schema");
    if (!format || strcmp(format, NQM_MODEL_FORMAT) != 0)
        return nqm_fail(r->err, NQM_ERR_MODEL, 8, "%s: safetensors, but not an nqm model (byte 8)", r->name);
    if (!schema || strcmp(schema, NQM_MODEL_SCHEMA) != 0)
        return nqm_fail(r->err, NQM_ERR_MODEL, 8,
                        "%s: model files of schema %.16s are not known here, only %s (byte 8)", r->name,
                        schema ? schema : "(none)", NQM_MODEL_SCHEMA);
    if (!r->verify)
        return NQM_OK;
    char hex[65];
    bool matches;
    if (!nqm_safetensors_checksum(r->st, hex, &matches))
        return nqm_fail(r->err, NQM_ERR_MODEL, 8, "%s: has no checksum (byte 8)", r->name);
    if (!matches)
        return nqm_fail(r->err, NQM_ERR_MODEL, -1,
                        "%s: checksum is not the stored one: the file was changed or damaged", r->name);
    return NQM_OK;
}

static nqm_status read_text(const reader *r, const char *key, char **text_ret) {
    const char *value = nqm_safetensors_meta(r->st, key);
    if (!value)
        return nqm_fail(r->err, NQM_ERR_MODEL, 8, "%s: metadata '%s' is missing (byte 8)", r->name, key);
    *text_ret = nqm_strdup(value);
    return *text_ret ? NQM_OK : nqm_fail_nomem(r->err, strlen(value));
}

static nqm_status read_texts(const reader *r, struct nqm_model *model) {
    const struct {
        const char *key;
        char **text;
    } texts[] = {{"id", &model->id},     {"recipe", &model->recipe},     {"licence", &model->licence},
                 {"card", &model->card}, {"training", &model->training}, {"manifest_sha256", &model->manifest_sha256}};
    nqm_status status = NQM_OK;
    for (size_t i = 0; status == NQM_OK && i < sizeof texts / sizeof *texts; ++i)
        status = read_text(r, texts[i].key, texts[i].text);
    if (status == NQM_OK && nqm_safetensors_meta(r->st, "golden"))
        status = read_text(r, "golden", &model->golden);
    if (status == NQM_OK && nqm_safetensors_meta(r->st, "scalars")) /* absent in models without scalar inputs */
        status = read_text(r, "scalars", &model->scalar_names);
    if (status == NQM_OK && nqm_safetensors_meta(r->st, "calibration"))
        status = read_text(r, "calibration", &model->calibration);
    const char *sha256 = nqm_safetensors_meta(r->st, "sha256");
    snprintf(model->sha256, sizeof model->sha256, "%s", sha256 ? sha256 : "");
    return status;
}

/* The index in `names` of the value of metadata `key`. */
static nqm_status read_choice(const reader *r, const char *key, size_t n_names, const char *const *names, int *ret) {
    const char *value = nqm_safetensors_meta(r->st, key);
    for (size_t i = 0; value && i < n_names; ++i)
        if (strcmp(value, names[i]) == 0) {
            *ret = (int)i;
            return NQM_OK;
        }
    return nqm_fail(r->err, NQM_ERR_MODEL, 8, "%s: metadata '%s' is missing or unknown (byte 8)", r->name, key);
}

static nqm_status read_directions(reader *r, struct nqm_model *model) {
    size_t width = model->params.shape.sizes[0], n_scalars = nqm_model_n_scalars(model);
    size_t per_direction = model->layout == NQM_LAYOUT_REF_TEST ? 6 : 9; /* RGB of two or three members */
    size_t n = width > n_scalars ? (width - n_scalars) / per_direction : 0;
    if (n == 0 || n * per_direction + n_scalars != width)
        return nqm_fail(r->err, NQM_ERR_MODEL, -1, "%s: tensor 'layers.0.weight': input of %zu does not fit the layout",
                        r->name, width);
    const nqm_tensor *tensor;
    nqm_status status =
        get(r, &(expectation){.name = "directions_deg", .dtype = NQM_F64, .rows = n, .cols = 3}, &tensor);
    if (status != NQM_OK)
        return status;
    model->n_directions = n;
    model->directions_deg = nqm_alloc(n, 3 * sizeof(double));
    if (!model->directions_deg)
        return nqm_fail_nomem(r->err, tensor->n_bytes);
    memcpy(model->directions_deg, tensor->data, tensor->n_bytes);
    return NQM_OK;
}

static nqm_status read_scalar_whitening(reader *r, struct nqm_model *model) {
    if (!model->scalar_names)
        return NQM_OK;
    nqm_status status = get_floats(r, "scalars.mean", NQM_SCALAR_COUNT, model->scalar_mean);
    if (status == NQM_OK)
        status = get_floats(r, "scalars.std", NQM_SCALAR_COUNT, model->scalar_std);
    if (status == NQM_OK)
        status = get_doubles(r, "scalars.scale", 1, &model->scalar_scale);
    for (size_t i = 0; status == NQM_OK && i < NQM_SCALAR_COUNT; ++i)
        if (!(model->scalar_std[i] > 0))
            status = nqm_fail(r->err, NQM_ERR_MODEL, -1, "%s: tensor 'scalars.std' is not positive", r->name);
    return status;
}

static nqm_status read_interval(reader *r, struct nqm_model *model) {
    const nqm_tensor *tensor = nqm_safetensors_find(r->st, "interval");
    if (!model->calibration && !tensor)
        return NQM_OK;
    if (!model->calibration)
        return refuse(r, tensor, "needs the metadata 'calibration'");
    size_t n = tensor && tensor->n_dims == 2 ? tensor->dims[0] : 1;
    nqm_status status = get(r, &(expectation){.name = "interval", .dtype = NQM_F64, .rows = n, .cols = 3}, &tensor);
    if (status != NQM_OK)
        return status;
    model->n_interval = n;
    model->interval = nqm_alloc(n, 3 * sizeof(double));
    if (!model->interval)
        return nqm_fail_nomem(r->err, tensor->n_bytes);
    memcpy(model->interval, tensor->data, tensor->n_bytes);
    const char *fault = nqm_interval_table_fault(n, model->interval);
    return fault ? refuse(r, tensor, fault) : NQM_OK;
}

static nqm_status read_novelty(reader *r, struct nqm_model *model) {
    const nqm_tensor *points = nqm_safetensors_find(r->st, "novelty.points"), *map;
    const size_t width = NQM_SCALAR_COUNT * NQM_NOVELTY_BLOCK;
    size_t n = points && points->n_dims == 2 && points->dims[0] > 0 ? points->dims[0] : 1;
    double scale[2];
    if (!points)
        return NQM_OK;
    if (!model->interval || !model->scalar_names)
        return refuse(r, points, "needs an interval and scalar features");
    nqm_status status =
        get(r, &(expectation){.name = "novelty.points", .dtype = NQM_F32, .rows = n, .cols = width}, &points);
    if (status == NQM_OK)
        status = get(
            r,
            &(expectation){.name = "novelty.map", .dtype = NQM_F32, .rows = NQM_SCALAR_COUNT, .cols = NQM_SCALAR_COUNT},
            &map);
    if (status == NQM_OK)
        status = get_doubles(r, "novelty.scale", 2, scale);
    if (status != NQM_OK)
        return status;
    if (!(scale[0] > 0 && scale[1] >= 0 && scale[1] <= NQM_NOVELTY_MAX_GROWTH))
        return nqm_fail(r->err, NQM_ERR_MODEL, -1, "%s: tensor 'novelty.scale' is out of range", r->name);
    model->novelty_points = nqm_alloc(n, width * sizeof(float));
    if (!model->novelty_points)
        return nqm_fail_nomem(r->err, points->n_bytes);
    memcpy(model->novelty_points, points->data, points->n_bytes);
    memcpy(model->novelty_map, map->data, map->n_bytes);
    model->n_novelty = n;
    model->novelty_unit = scale[0], model->novelty_growth = scale[1];
    return NQM_OK;
}

static nqm_status read_numbers(reader *r, struct nqm_model *model) {
    double target[4], curve[3];
    nqm_status status = get_floats(r, "whitening.mean", 3, model->mean);
    if (status == NQM_OK)
        status = get_floats(r, "whitening.std", 3, model->std);
    if (status == NQM_OK)
        status = get_doubles(r, "difference_scale", 1, &model->difference_scale);
    if (status == NQM_OK)
        status = get_doubles(r, "target", 4, target);
    if (status == NQM_OK)
        status = get_doubles(r, "jod_curve", 3, curve);
    if (status != NQM_OK)
        return status;
    model->target_mean = target[0], model->target_std = target[1];
    model->out_lo = target[2], model->out_hi = target[3];
    model->curve = (nqm_curve){curve[0], curve[1], curve[2]};
    if (!(model->std[0] > 0 && model->std[1] > 0 && model->std[2] > 0))
        return nqm_fail(r->err, NQM_ERR_MODEL, -1, "%s: tensor 'whitening.std' is not positive", r->name);
    if (!(model->target_std > 0 && model->out_lo < model->out_hi))
        return nqm_fail(r->err, NQM_ERR_MODEL, -1, "%s: tensor 'target': deviation or range is empty", r->name);
    return NQM_OK;
}

static nqm_status refuse_surplus(const reader *r) {
    for (size_t i = 0; i < nqm_safetensors_count(r->st); ++i)
        if (!r->used[i])
            return refuse(r, nqm_safetensors_at(r->st, i), "does not belong in a model");
    return NQM_OK;
}

static nqm_status read_model(reader *r, struct nqm_model *model) {
    nqm_status status = read_texts(r, model);
    int layout = 0, target = 0;
    if (status == NQM_OK)
        status = read_choice(r, "layout", NQM_LAYOUT_COUNT, nqm_layout_names, &layout);
    if (status == NQM_OK)
        status = read_choice(r, "target", NQM_TARGET_COUNT, nqm_target_names, &target);
    model->layout = (nqm_layout)layout;
    model->target = (nqm_target)target;
    if (status == NQM_OK)
        status = read_network(r, model);
    if (status == NQM_OK)
        status = read_directions(r, model);
    if (status == NQM_OK)
        status = read_numbers(r, model);
    if (status == NQM_OK)
        status = read_scalar_whitening(r, model);
    if (status == NQM_OK)
        status = read_interval(r, model);
    if (status == NQM_OK)
        status = read_novelty(r, model);
    return status == NQM_OK ? refuse_surplus(r) : status;
}

nqm_status nqm_model_parse(const unsigned char *data, size_t n_bytes, const char *name, bool verify,
                           struct nqm_model **model_ret, nqm_error *err) {
    *model_ret = NULL;
    nqm_safetensors *st;
    nqm_status status = nqm_safetensors_parse(data, n_bytes, name, &st, err);
    if (status != NQM_OK)
        return status;
    reader r = {.st = st, .name = name, .verify = verify, .err = err};
    r.used = nqm_alloc(nqm_safetensors_count(st), sizeof *r.used);
    struct nqm_model *model = nqm_alloc(1, sizeof *model);
    if (!r.used || !model)
        status = nqm_fail_nomem(err, sizeof *model);
    else if ((status = check_header(&r)) == NQM_OK)
        status = read_model(&r, model);
    if (status == NQM_OK) {
        *model_ret = model;
        model = NULL;
    }
    nqm_model_free(model);
    nqm_free(r.used);
    nqm_safetensors_free(st);
    return status;
}
