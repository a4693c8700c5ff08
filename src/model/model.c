/* SPDX-License-Identifier: MIT
 *
 * Loading of models from files, from memory and from the library; their description; their deallocation.
 */
#include "model/model.h"
#include "model/models_table.h"

#include <math.h>
#include <string.h>

nqm_status nqm_model_attach_directions(nqm_model *model, nqm_error *err) {
    return nqm_directions_from_degrees(model->n_directions, model->directions_deg, &model->directions, err);
}

/* A model can be used only if its scalar features are those that this version computes. */
static nqm_status check_scalars(const nqm_model *model, const char *name, nqm_error *err) {
    if (!model->scalar_names)
        return NQM_OK;
    char *ours = nqm_scalar_names();
    if (!ours)
        return nqm_fail_nomem(err, strlen(model->scalar_names));
    bool same = strcmp(ours, model->scalar_names) == 0;
    nqm_free(ours);
    return same ? NQM_OK
                : nqm_fail(err, NQM_ERR_MODEL, -1,
                           "%s: the model's scalar features (metadata 'scalars') are not those of this version", name);
}

/* Parse a model and create its direction set. On failure *model_ret is NULL. */
static nqm_status make_model(const unsigned char *data, size_t n_bytes, const char *name, bool verify,
                             nqm_model **model_ret, nqm_error *err) {
    *model_ret = NULL;
    nqm_model *model;
    nqm_status status = nqm_model_parse(data, n_bytes, name, verify, &model, err);
    if (status != NQM_OK)
        return status;
    status = check_scalars(model, name, err);
    if (status != NQM_OK) {
        nqm_model_free(model);
        return status;
    }
    nqm_error inner = {0};
    status = nqm_model_attach_directions(model, &inner);
    if (status != NQM_OK) {
        nqm_model_free(model);
        status = status == NQM_ERR_ARG ? NQM_ERR_MODEL : status; /* the fault is in the file, not in an argument */
        return nqm_fail(err, status, -1, "%s: %s", name, inner.message);
    }
    *model_ret = model;
    return NQM_OK;
}

nqm_status nqm_model_load(const char *path, nqm_model **model_ret, nqm_error *err) {
    *model_ret = NULL;
    nqm_map *map = nqm_alloc(1, sizeof *map);
    if (!map)
        return nqm_fail_nomem(err, sizeof *map);
    nqm_status status = nqm_map_open(path, map, err);
    if (status == NQM_OK)
        status = make_model(map->data, map->n_bytes, path, true, model_ret, err);
    if (status == NQM_OK && !(*model_ret)->memory) {
        (*model_ret)->file = map;
        return NQM_OK;
    }
    nqm_map_close(map);
    nqm_free(map);
    return status;
}

nqm_status nqm_model_from_memory(const void *data, size_t n_bytes, const char *name, nqm_model **model_ret,
                                 nqm_error *err) {
    *model_ret = NULL;
    unsigned char *copy = nqm_alloc(n_bytes, 1);
    if (!copy)
        return nqm_fail_nomem(err, n_bytes);
    if (n_bytes)
        memcpy(copy, data, n_bytes);
    nqm_status status = make_model(copy, n_bytes, name, true, model_ret, err);
    if (status == NQM_OK && !(*model_ret)->memory)
        (*model_ret)->memory = copy;
    else
        nqm_free(copy);
    return status;
}

nqm_status nqm_model_builtin(const char *name, nqm_model **model_ret, nqm_error *err) {
    *model_ret = NULL;
    for (const nqm_embedded_file *m = nqm_embedded_models; m->name; ++m)
        if (strcmp(m->name, name) == 0)
            return make_model(m->begin, (size_t)(m->end - m->begin), m->name, false, model_ret, err);
    if (nqm_model_builtin_count() == 0)
        return nqm_fail(err, NQM_ERR_MODEL, -1,
                        "model '%s': no model is built into this library: train one (nqm train) and give its file",
                        name);
    return nqm_fail(err, NQM_ERR_MODEL, -1, "model '%s' is not built in", name);
}

size_t nqm_model_builtin_count(void) {
    size_t n = 0;
    while (nqm_embedded_models[n].name)
        ++n;
    return n;
}

const char *nqm_model_builtin_name(size_t i) {
    return nqm_embedded_models[i].name;
}

void nqm_model_free(struct nqm_model *model) {
    if (!model)
        return;
    nqm_directions_free(model->directions);
    nqm_params_free(&model->params);
    char *texts[] = {model->id,      model->recipe,       model->card,
                     model->licence, model->training,     model->manifest_sha256,
                     model->golden,  model->scalar_names, model->calibration};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; ++i)
        nqm_free(texts[i]);
    for (size_t i = 0; i < NQM_PRECISION_COUNT; ++i)
        nqm_inference_net_free(model->inference[i]);
    nqm_free(model->directions_deg);
    nqm_free(model->interval);
    nqm_free(model->novelty_points);
    if (model->file)
        nqm_map_close(model->file);
    nqm_free(model->file);
    nqm_free(model->memory);
    nqm_free(model);
}

nqm_model_info nqm_model_get_info(const nqm_model *model) {
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
                           .target_mean = model->target_mean,
                           .target_std = model->target_std,
                           .directions = model->directions,
                           .calibration = model->calibration ? model->calibration : ""};
    for (size_t k = 0; k < 3; ++k) {
        info.whitening_mean[k] = (double)model->mean[k];
        info.whitening_std[k] = (double)model->std[k];
    }
    double at_low = nqm_model_jod(model, -INFINITY, NULL), at_high = nqm_model_jod(model, INFINITY, NULL);
    info.jod_min = fmin(at_low, at_high); /* the JOD of a model that predicts Delta-E decreases with its output */
    info.jod_max = fmax(at_low, at_high);
    return info;
}
