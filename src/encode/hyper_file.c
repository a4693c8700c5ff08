/* SPDX-License-Identifier: MIT
 *
 * The file of a hypernetwork: tensors layers.N.weight (in, out) and layers.N.bias (out), and the metadata of all encoder
 * files.
 */
#include "brdf/brdf.h"
#include "encode/encode.h"

#include <string.h>

enum { N_TENSORS = 2 * NQM_HYPER_N_LAYERS };

nqm_tensor nqm_hyper_tensor(size_t i, const nqm_hyper_layer *layer, char name[NQM_HYPER_NAME_BYTES]) {
    const bool is_bias = i % 2 != 0;
    snprintf(name, NQM_HYPER_NAME_BYTES, "layers.%zu.%s", i / 2, is_bias ? "bias" : "weight");
    return nqm_tensor_of(name, NQM_F32, is_bias ? 0 : layer->n_in, layer->n_out, is_bias ? layer->b : layer->w);
}

/* Find all tensors; the file determines the widths of the hidden layers. */
static nqm_status find_tensors(const nqm_safetensors *st, const char *file, const nqm_tensor **tensor, nqm_error *err) {
    nqm_hyper_layer layer = {.n_out = NQM_HYPER_FEATURES};
    for (size_t i = 0; i < N_TENSORS; ++i) {
        char name[NQM_HYPER_NAME_BYTES];
        if (i % 2 == 0) {
            layer.n_in = i == 2 * NQM_HYPER_POOLED ? 2 * layer.n_out + 1 : layer.n_out;
            layer.n_out = i == N_TENSORS - 2 ? NQM_NBRDF_WEIGHTS : 0; /* 0: any */
        }
        const nqm_tensor expected = nqm_hyper_tensor(i, &layer, name);
        nqm_status status = nqm_safetensors_floats(st, &expected, NQM_ERR_MODEL, &tensor[i], err);
        if (status != NQM_OK)
            return status;
        layer.n_out = tensor[i]->dims[tensor[i]->n_dims - 1];
    }
    if (nqm_safetensors_count(st) != N_TENSORS)
        return nqm_fail(err, NQM_ERR_MODEL, -1, "%s: %zu tensors instead of %d", file, nqm_safetensors_count(st),
                        N_TENSORS);
    return NQM_OK;
}

nqm_status nqm_hyper_read(const unsigned char *data, size_t n_bytes, const char *name, nqm_hyper *hyper_ret,
                          nqm_error *err) {
    nqm_safetensors *st;
    const nqm_tensor *tensor[N_TENSORS];
    nqm_hyper_shape shape;
    *hyper_ret = (nqm_hyper){0};
    nqm_status status = nqm_encoder_parse(data, n_bytes, name, "hyper", &st, err);
    if (status == NQM_OK)
        status = find_tensors(st, name, tensor, err);
    for (size_t l = 0; status == NQM_OK && l < NQM_HYPER_N_LAYERS; ++l)
        shape.n_out[l] = tensor[2 * l]->dims[1];
    if (status == NQM_OK)
        status = nqm_hyper_create(&shape, hyper_ret, err);
    float *next = hyper_ret->block;
    for (size_t i = 0; status == NQM_OK && i < N_TENSORS; ++i) {
        memcpy(next, tensor[i]->data, tensor[i]->n_bytes);
        next += tensor[i]->n_bytes / sizeof *next;
    }
    nqm_safetensors_free(st);
    return status;
}
