/* SPDX-License-Identifier: MIT
 *
 * The file of a hypernetwork: tensors layers.N.weight (in, out) and layers.N.bias (out), and the metadata of all encoder
 * files.
 */
#include "brdf/brdf.h"
#include "fit/hyper.h"

#include <string.h>

enum { N_TENSORS = 2 * NQM_HYPER_N_LAYERS, NAME_MAX_BYTES = 24 };
static const char kind[] = "hyper";
static const char *const suffixes[2] = {"weight", "bias"};

static void tensor_name(size_t layer, size_t part, char name[NAME_MAX_BYTES]) {
    snprintf(name, NAME_MAX_BYTES, "layers.%zu.%s", layer, suffixes[part]);
}

nqm_status nqm_hyper_write(const nqm_hyper *hyper, size_t n, const char *const *names, const nqm_learn_options *options,
                           const char *path, nqm_error *err) {
    char name[N_TENSORS][NAME_MAX_BYTES];
    nqm_tensor tensor[N_TENSORS];
    for (size_t l = 0; l < NQM_HYPER_N_LAYERS; ++l) {
        const nqm_hyper_layer *layer = &hyper->layer[l];
        tensor_name(l, 0, name[2 * l]);
        tensor_name(l, 1, name[2 * l + 1]);
        tensor[2 * l] = (nqm_tensor){.name = name[2 * l],
                                     .dtype = NQM_F32,
                                     .n_dims = 2,
                                     .dims = {layer->n_in, layer->n_out},
                                     .n_bytes = layer->n_in * layer->n_out * sizeof(float),
                                     .data = layer->w};
        tensor[2 * l + 1] = (nqm_tensor){.name = name[2 * l + 1],
                                         .dtype = NQM_F32,
                                         .n_dims = 1,
                                         .dims = {layer->n_out},
                                         .n_bytes = layer->n_out * sizeof(float),
                                         .data = layer->b};
    }
    return nqm_encoder_write(path, kind, n, names, options, N_TENSORS, tensor, err);
}

/* Find all tensors; the file determines the widths of the hidden layers. */
static nqm_status find_tensors(const nqm_safetensors *st, const char *name, const nqm_tensor **tensor, nqm_error *err) {
    size_t n_in = NQM_HYPER_FEATURES;
    for (size_t l = 0; l < NQM_HYPER_N_LAYERS; ++l) {
        char parts[2][NAME_MAX_BYTES];
        tensor_name(l, 0, parts[0]);
        tensor_name(l, 1, parts[1]);
        n_in = l == NQM_HYPER_POOLED ? 2 * n_in + 1 : n_in;
        size_t dims[2] = {n_in, l + 1 == NQM_HYPER_N_LAYERS ? NQM_NBRDF_WEIGHTS : 0};
        nqm_status status = nqm_encoder_tensor(st, name, parts[0], 2, dims, &tensor[2 * l], err);
        if (status != NQM_OK)
            return status;
        n_in = tensor[2 * l]->dims[1];
        status = nqm_encoder_tensor(st, name, parts[1], 1, &n_in, &tensor[2 * l + 1], err);
        if (status != NQM_OK)
            return status;
    }
    if (nqm_safetensors_count(st) != N_TENSORS)
        return nqm_fail(err, NQM_ERR_MODEL, -1, "%s: %zu tensors instead of %d", name, nqm_safetensors_count(st),
                        N_TENSORS);
    return NQM_OK;
}

static nqm_status copy_tensors(const nqm_tensor *const *tensor, nqm_hyper *hyper, nqm_error *err) {
    nqm_hyper_shape shape = {.sample = {tensor[0]->dims[1], tensor[2]->dims[1], tensor[4]->dims[1]},
                             .set = {tensor[6]->dims[1], tensor[8]->dims[1]},
                             .n_out = tensor[10]->dims[1]};
    nqm_status status = nqm_hyper_create(&shape, hyper, err);
    if (status != NQM_OK)
        return status;
    for (size_t l = 0; l < NQM_HYPER_N_LAYERS; ++l) {
        memcpy(hyper->layer[l].w, tensor[2 * l]->data, tensor[2 * l]->n_bytes);
        memcpy(hyper->layer[l].b, tensor[2 * l + 1]->data, tensor[2 * l + 1]->n_bytes);
    }
    return NQM_OK;
}

nqm_status nqm_hyper_read(const unsigned char *data, size_t n_bytes, const char *name, nqm_hyper *hyper_ret,
                          nqm_error *err) {
    nqm_safetensors *st;
    const nqm_tensor *tensor[N_TENSORS];
    *hyper_ret = (nqm_hyper){0};
    nqm_status status = nqm_encoder_parse(data, n_bytes, name, kind, &st, err);
    if (status != NQM_OK)
        return status;
    status = find_tensors(st, name, tensor, err);
    if (status == NQM_OK)
        status = copy_tensors(tensor, hyper_ret, err);
    nqm_safetensors_free(st);
    return status;
}
