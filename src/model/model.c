/* SPDX-License-Identifier: MIT
 *
 * Loading of models from files, from memory and from the library; their description; their deallocation.
 */
#include "model/model_file.h"
#include "model/models_table.h"

#include <math.h>
#include <string.h>

nqm_status nqm_model_load(const char *path, nqm_model **model_ret, nqm_error *err) {
    *model_ret = NULL;
    nqm_map map = {0};
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

nqm_status nqm_model_from_memory(const void *data, size_t n_bytes, const char *name, nqm_model **model_ret,
                                 nqm_error *err) {
    *model_ret = NULL;
    unsigned char *copy = nqm_alloc(n_bytes, 1);
    if (!copy)
        return nqm_fail_nomem(err, n_bytes);
    if (n_bytes)
        memcpy(copy, data, n_bytes);
    nqm_status status = nqm_model_parse(copy, n_bytes, name, true, model_ret, err);
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
            return nqm_model_parse(m->begin, (size_t)(m->end - m->begin), m->name, false, model_ret, err);
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
    for (const nqm_model_text *t = nqm_model_texts; t < nqm_model_texts + NQM_MODEL_TEXTS; ++t)
        if (!t->words)
            nqm_free(*nqm_model_block(model, t->offset));
    for (size_t i = 0; i < NQM_PRECISION_COUNT; ++i)
        nqm_inference_net_free(model->inference[i]);
    nqm_free(model->interval);
    nqm_free(model->novelty_points);
    nqm_map_close(&model->file);
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
                           .target_mean = model->output.mean,
                           .target_std = model->output.std,
                           .directions = model->directions,
                           .calibration = model->calibration ? model->calibration : ""};
    for (size_t k = 0; k < 3; ++k) {
        info.whitening_mean[k] = (double)model->features.mean[k];
        info.whitening_std[k] = (double)model->features.std[k];
    }
    double at_low = nqm_model_jod(model, -INFINITY, NULL), at_high = nqm_model_jod(model, INFINITY, NULL);
    info.jod_min = fmin(at_low, at_high); /* the JOD of a model that predicts Delta-E decreases with its output */
    info.jod_max = fmax(at_low, at_high);
    return info;
}
