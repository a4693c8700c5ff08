/* SPDX-License-Identifier: MIT
 *
 * Reads a model (doc/model-format.md) from a file, from memory or from the library. A missing or surplus tensor, a
 * wrong type or shape, a value that is not finite or a wrong checksum is an error; for a tensor the message gives its
 * name.
 */
#include "base/os.h"
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
        return refuse(r, tensor, "contains a value that is not finite");
    r->used[tensor - nqm_safetensors_at(r->st, 0)] = true;
    *tensor_ret = tensor;
    return NQM_OK;
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
    const bool has_transport = nqm_safetensors_find(r->st, "transport") || nqm_safetensors_find(r->st, "slopes");
    if (n == 0 && has_transport && !nqm_safetensors_find(r->st, "layers.0.bias"))
        return NQM_OK; /* a model without a network */
    const bool known = n > 1 && (shape->sizes[n] == 1 || shape->sizes[n] == 1 + NQM_LABEL_PARTS);
    if (!known) /* a hidden layer is the last */
        return nqm_fail(r->err, NQM_ERR_MODEL, -1, "%s: tensor 'layers.%zu.weight' is missing%s", r->name, n,
                        n == 0 && !has_transport ? "; a model without a network needs tensor 'transport'" : "");
    return NQM_OK;
}

/* The tensors of a network, layer by layer; NULL where a layer has none. */
typedef struct network {
    const nqm_tensor *part[NQM_NET_MAX_LAYERS][NQM_LAYER_TENSORS];
    size_t n_bytes; /* bytes of all tensors, each rounded up to whole cache lines */
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
    const char *format = nqm_safetensors_meta(r->st, "format");
    if (!format || strcmp(format, NQM_MODEL_FORMAT) != 0)
        return nqm_fail(r->err, NQM_ERR_MODEL, 8, "%s: safetensors, but not an nqm model (byte 8)", r->name);
    return nqm_safetensors_verify(r->st, NQM_MODEL_SCHEMA, r->verify, NQM_ERR_MODEL, r->err);
}

static nqm_status read_one_text(const reader *r, const nqm_model_text *t, struct nqm_model *model) {
    const char *value = nqm_safetensors_meta(r->st, t->key);
    if (!value && t->part != NQM_PART_ALWAYS)
        return NQM_OK;
    if (value && !t->words) {
        void **text = nqm_model_block(model, t->offset);
        *text = nqm_strdup(value);
        return *text ? NQM_OK : nqm_fail_nomem(r->err, strlen(value));
    }
    for (int i = 0; value && t->words[i]; ++i)
        if (strcmp(value, t->words[i]) == 0) {
            *(int *)nqm_model_at(model, t->offset) = i;
            return NQM_OK;
        }
    return nqm_fail(r->err, NQM_ERR_MODEL, 8, "%s: metadata '%s' is missing or unknown (byte 8)", r->name, t->key);
}

static nqm_status read_scalars(const reader *r, struct nqm_model *model) {
    nqm_error inner = {0};
    const nqm_status status =
        model->scalar_names ? nqm_scalars_select(model->scalar_names, &model->scalars, &inner) : NQM_OK;
    return status == NQM_OK ? NQM_OK : nqm_fail(r->err, status, -1, "%s: %s", r->name, inner.message);
}

static nqm_status read_directions(reader *r, struct nqm_model *model) {
    size_t width = model->params.shape.sizes[0], n_scalars = model->scalars.n;
    size_t per_direction = nqm_features_width(model->features.layout, 1);
    size_t n = width > n_scalars ? (width - n_scalars) / per_direction : 0;
    const nqm_tensor *tensor = nqm_safetensors_find(r->st, "directions_deg");
    if (!nqm_model_has_network(model))
        n = tensor && tensor->n_dims == 2 ? tensor->dims[0] : 1;
    else if (n == 0 || n * per_direction + n_scalars != width)
        return nqm_fail(r->err, NQM_ERR_MODEL, -1, "%s: tensor 'layers.0.weight': input of %zu does not fit the layout",
                        r->name, width);
    nqm_error inner = {0};
    nqm_status status =
        get(r, &(expectation){.name = "directions_deg", .dtype = NQM_F64, .rows = n, .cols = 3}, &tensor);
    if (status != NQM_OK)
        return status;
    double *degrees = nqm_alloc(n, 3 * sizeof *degrees); /* aligned */
    if (!degrees)
        return nqm_fail_nomem(r->err, tensor->n_bytes);
    memcpy(degrees, tensor->data, tensor->n_bytes);
    status = nqm_directions_from_degrees(n, degrees, &model->directions, &inner);
    nqm_free(degrees);
    if (status == NQM_OK)
        return NQM_OK;
    status = status == NQM_ERR_ARG ? NQM_ERR_MODEL : status; /* the fault is in the file, not in an argument */
    return nqm_fail(r->err, status, -1, "%s: %s", r->name, inner.message);
}

static nqm_status read_array(reader *r, const nqm_model_array *a, struct nqm_model *model) {
    const nqm_tensor *tensor = nqm_safetensors_find(r->st, a->name);
    expectation e = {.name = a->name,
                     .dtype = a->dtype,
                     .rows = nqm_model_extent(model, a->rows),
                     .cols = nqm_model_extent(model, a->cols)};
    e.is_large = a->part == NQM_PART_TRANSPORT || a->part == NQM_PART_SLOPES;
    if (a->n_offset) /* any number of rows but 0 */
        e.rows = tensor && tensor->n_dims == 2 && tensor->dims[0] > 0 ? tensor->dims[0] : 1;
    nqm_status status = get(r, &e, &tensor);
    if (status != NQM_OK)
        return status;
    void *values = nqm_model_at(model, a->offset);
    if (a->n_offset) {
        values = *nqm_model_block(model, a->offset) = nqm_alloc(tensor->n_bytes, 1);
        if (!values)
            return nqm_fail_nomem(r->err, tensor->n_bytes);
        *(size_t *)nqm_model_at(model, a->n_offset) = e.rows;
    }
    memcpy(values, tensor->data, tensor->n_bytes);
    return NQM_OK;
}

static nqm_status read_arrays(reader *r, struct nqm_model *model) {
    const nqm_tensor *interval = nqm_safetensors_find(r->st, "interval");
    const nqm_tensor *points = nqm_safetensors_find(r->st, "novelty.points");
    const nqm_tensor *spread = nqm_safetensors_find(r->st, "interval.spread");
    const bool has[NQM_PART_COUNT] = {[NQM_PART_ALWAYS] = true,
                                      [NQM_PART_SCALARS] = model->scalar_names,
                                      [NQM_PART_INTERVAL] = model->calibration,
                                      [NQM_PART_NOVELTY] = points,
                                      [NQM_PART_LABEL] = nqm_model_has_parts(model),
                                      [NQM_PART_TRANSPORT] = nqm_safetensors_find(r->st, "transport") ||
                                                             nqm_safetensors_find(r->st, "transport.points"),
                                      [NQM_PART_SLOPES] = nqm_safetensors_find(r->st, "slopes"),
                                      [NQM_PART_SPREAD] = spread,
                                      [NQM_PART_SIMILARITY] = nqm_safetensors_find(r->st, "similarity")};
    if (spread && !model->calibration)
        return refuse(r, spread, "needs an interval");
    if (interval && !model->calibration)
        return refuse(r, interval, "needs the metadata 'calibration'");
    if (points && !(model->calibration && model->scalar_names))
        return refuse(r, points, "needs an interval and scalar features");
    nqm_status status = NQM_OK;
    for (const nqm_model_array *a = nqm_model_arrays; status == NQM_OK && a < nqm_model_arrays + NQM_MODEL_ARRAYS; ++a)
        if (has[a->part])
            status = read_array(r, a, model);
    return status;
}

static nqm_status check_arrays(const reader *r, const struct nqm_model *model) {
    const float *std = model->features.std;
    const nqm_transport transport = nqm_model_transport(model);
    const char *transport_fault = model->transport ? nqm_transport_fault(&transport, r->verify) : NULL;
    if (model->transport && model->n_transport != model->directions->n)
        transport_fault = "tensor 'transport' does not have a row for each direction";
    if (model->transport && model->target != NQM_TARGET_LOG_DELTA_E)
        transport_fault = "tensor 'transport' needs the target log_delta_e";
    if (model->slopes && (model->n_slopes != NQM_SLOPE_CELLS || model->n_slope_wo != model->n_slope_points))
        transport_fault = "tensor 'slopes' or 'slopes.wo' has the wrong number of rows";
    else if (model->slopes)
        transport_fault = nqm_transport_points_fault(&(nqm_picture_points){model->n_slope_points, model->slope_points});
    if (transport_fault)
        return nqm_fail(r->err, NQM_ERR_MODEL, -1, "%s: %s", r->name, transport_fault);
    const char *bad = NULL,
               *fault = model->interval ? nqm_interval_table_fault(model->n_interval, model->interval) : NULL;
    if (fault)
        return refuse(r, nqm_safetensors_find(r->st, "interval"), fault);
    if (!(std[0] > 0 && std[1] > 0 && std[2] > 0))
        bad = "whitening.std";
    if (!(model->output.std > 0 && model->output.lo < model->output.hi))
        bad = "target";
    for (size_t i = 0; nqm_model_has_parts(model) && i < NQM_LABEL_PARTS; ++i)
        if (!(model->parts[i].std > 0 && model->parts[i].lo < model->parts[i].hi))
            bad = "label_parts";
    for (size_t i = 0; i < model->scalars.n; ++i)
        if (!(model->scalars.std[i] > 0))
            bad = "scalars.std";
    if (model->n_novelty &&
        !(model->novelty_unit > 0 && model->novelty_growth >= 0 && model->novelty_growth <= NQM_NOVELTY_MAX_GROWTH))
        bad = "novelty.scale";
    for (size_t k = 0; k < NQM_SPREAD_FEATURES; ++k)
        if (!(model->spread_growth[k] >= 0 && model->spread_growth[k] <= NQM_NOVELTY_MAX_GROWTH))
            bad = "interval.spread";
    for (size_t k = 0; k < NQM_INTERVAL_KNOTS; ++k)
        if (!(model->interval_floor[k] >= 0)) /* finite, as all values */
            bad = "interval.floor";
    for (size_t k = 0; k <= NQM_APART; ++k)
        if (!(model->similarity[k] >= 0))
            bad = "similarity";
    return bad ? nqm_fail(r->err, NQM_ERR_MODEL, -1, "%s: tensor '%s' is out of range", r->name, bad) : NQM_OK;
}

static nqm_status refuse_surplus(const reader *r) {
    for (size_t i = 0; i < nqm_safetensors_count(r->st); ++i)
        if (!r->used[i])
            return refuse(r, nqm_safetensors_at(r->st, i), "does not belong in a model");
    return NQM_OK;
}

static nqm_status read_model(reader *r, struct nqm_model *model) {
    nqm_status status = check_header(r);
    for (size_t i = 0; status == NQM_OK && i < NQM_MODEL_TEXTS; ++i)
        status = read_one_text(r, &nqm_model_texts[i], model);
    if (status == NQM_OK)
        status = read_scalars(r, model);
    if (status == NQM_OK)
        status = read_network(r, model);
    if (status == NQM_OK)
        status = read_directions(r, model);
    if (status == NQM_OK)
        status = read_arrays(r, model);
    if (status == NQM_OK)
        status = check_arrays(r, model);
    if (status == NQM_OK)
        status = refuse_surplus(r);
    const char *sha256 = nqm_safetensors_meta(r->st, "sha256");
    snprintf(model->sha256, sizeof model->sha256, "%s", sha256 ? sha256 : "");
    return status;
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
    status = r.used && model ? read_model(&r, model) : nqm_fail_nomem(err, sizeof *model);
    if (status == NQM_OK) {
        if (!model->memory)
            model->memory = nqm_safetensors_take(st);
        *model_ret = model;
        model = NULL;
    }
    nqm_model_free(model);
    nqm_free(r.used);
    nqm_safetensors_free(st);
    return status;
}

/* ---- public entries ---------------------------------------------------------------------------------------------- */

static bool is_builtin(const char *name) {
    const nqm_embedded_file *m = nqm_embedded_models;
    while (m->name && strcmp(m->name, name) != 0)
        ++m;
    return m->name != NULL;
}

/* end: of what is said of the name first. */
static nqm_status fail_builtin(const char *name, nqm_status status, const char *end, nqm_error *err) {
    nqm_nearest nearest = nqm_nearest_begin(name);
    for (const nqm_embedded_file *m = nqm_embedded_models; m->name; ++m)
        nqm_nearest_add(&nearest, m->name);
    return nqm_model_builtin_name(0)
               ? nqm_fail(err, status, -1, "%s: %sthere is no built-in model of this name%s", name, end, nearest.advice)
               : nqm_fail(err, status, -1, "%s: %sno model is built in: train one (nqm train) and give its file", name,
                          end);
}

nqm_status nqm_model_load(const char *name_or_path, nqm_model **model_ret, nqm_error *err) {
    NQM_MAKE(err, model_ret, name_or_path);
    const char *path = name_or_path;
    nqm_map map = {0};
    if (is_builtin(path))
        return nqm_model_builtin(path, model_ret, err);
    if (!strpbrk(path, "/.") && !nqm_os_exists(path))
        return fail_builtin(path, NQM_ERR_IO, "No such file or directory, and ", err);
    nqm_status status = nqm_map_open(path, &map, err);
    if (status == NQM_OK)
        status = nqm_model_parse(map.data, map.n_bytes, path, true, model_ret, err);
    map.path = NULL; /* the string belongs to the caller */
    if (status == NQM_OK && !(*model_ret)->memory)
        (*model_ret)->file = map;
    else
        nqm_map_close(&map);
    return status;
}

nqm_status nqm_model_builtin(const char *name, nqm_model **model_ret, nqm_error *err) {
    NQM_MAKE(err, model_ret, name);
    for (const nqm_embedded_file *m = nqm_embedded_models; m->name; ++m)
        if (strcmp(m->name, name) == 0)
            return nqm_model_parse(m->begin, (size_t)(m->end - m->begin), m->name, false, model_ret, err);
    return fail_builtin(name, NQM_ERR_MODEL, "", err);
}
