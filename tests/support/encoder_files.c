/* SPDX-License-Identifier: MIT
 *
 * Writing files of encoders, and hypernetworks with random weights (He et al. 2015).
 */
#include "support/encoder_files.h"

#include <math.h>
#include <stdlib.h>

void write_encoder(const char *path, const char *kind, size_t n_tensors, const nqm_tensor *tensors) {
    const nqm_meta meta[] = {{"format", "nqm-encoder"},
                             {"schema", "1"},
                             {"kind", kind},
                             {"references", "[\"rgl/\\\"quoted\\\".bsdf\",\"sgd:nickel\"]"}};
    if (nqm_safetensors_write(path, n_tensors, tensors, sizeof meta / sizeof *meta, meta, NULL, NULL) != NQM_OK)
        abort();
}

nqm_hyper make_hyper(const nqm_hyper_shape *shape, uint64_t seed) {
    nqm_hyper hyper;
    nqm_rng rng = nqm_rng_make(seed, 0);
    if (nqm_hyper_create(shape, &hyper, NULL) != NQM_OK)
        abort();
    for (size_t l = 0; l < NQM_HYPER_N_LAYERS; ++l)
        for (size_t i = 0; i < hyper.layer[l].n_in * hyper.layer[l].n_out; ++i)
            hyper.layer[l].w[i] = (float)(sqrt(2.0 / (double)hyper.layer[l].n_in) * nqm_rng_normal(&rng));
    return hyper;
}

void write_hyper(const char *path, const nqm_hyper *hyper) {
    char name[2 * NQM_HYPER_N_LAYERS][NQM_HYPER_NAME_BYTES];
    nqm_tensor tensor[2 * NQM_HYPER_N_LAYERS];
    for (size_t i = 0; i < 2 * NQM_HYPER_N_LAYERS; ++i)
        tensor[i] = nqm_hyper_tensor(i, &hyper->layer[i / 2], name[i]);
    write_encoder(path, "hyper", 2 * NQM_HYPER_N_LAYERS, tensor);
}
