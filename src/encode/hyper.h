/* SPDX-License-Identifier: MIT
 *
 * hyper.h - the hypernetwork (after Gokbudak et al. 2024, arXiv:2311.15783, "Hypernetworks for Generalizable BRDF
 * Representation"): a network on each sample of a BRDF, mean and maximum over all samples, and a second network that
 * predicts the weights of an NBRDF. Network: hyper_net.c; file: hyper_file.c; input samples and use: hyper.c.
 */
#ifndef NQM_SRC_ENCODE_HYPER_H
#define NQM_SRC_ENCODE_HYPER_H

#include "encode/encode.h"

enum {
    NQM_HYPER_PLACE = 7,                      /* features of a sample's direction pair */
    NQM_HYPER_FEATURES = NQM_HYPER_PLACE + 6, /* and the features of its value */
    NQM_HYPER_N_LAYERS = 6,
    NQM_HYPER_POOLED = 3 /* index of the first layer after the pooling */
};

/** Widths of the layers: three for each sample, two after the pooling, the predicted weights (NQM_NBRDF_WEIGHTS). */
typedef struct nqm_hyper_shape {
    size_t n_out[NQM_HYPER_N_LAYERS];
} nqm_hyper_shape;

/** y = GELU(x W + b), linear in the last layer. */
typedef struct nqm_hyper_layer {
    size_t n_in, n_out;
    float *w; /* (n_in, n_out) */
    float *b; /* (n_out) */
} nqm_hyper_layer;

typedef struct nqm_hyper {
    nqm_hyper_layer layer[NQM_HYPER_N_LAYERS];
    size_t n;     /* number of parameters */
    float *block; /* (n) weights and biases, layer by layer */
} nqm_hyper;

/** A network of zeros; nqm_free(hyper->block) also after a failure. */
NQM_MUST_CHECK nqm_status nqm_hyper_create(const nqm_hyper_shape *shape, nqm_hyper *hyper_ret, nqm_error *err);
/** Predict weights (n_out of the last layer) from the features x (n_samples, NQM_HYPER_FEATURES) of samples. step: mean and
 *  maximum of the pooling are rounded to multiples of it; 0: they are not. */
NQM_MUST_CHECK nqm_status nqm_hyper_forward(const nqm_hyper *hyper, size_t n_samples, const float *x, float step,
                                            float *weights, nqm_error *err);

/** Read the bytes of a file; NQM_ERR_MODEL unless it contains a hypernetwork that predicts NBRDFs. */
NQM_MUST_CHECK nqm_status nqm_hyper_read(const unsigned char *data, size_t n_bytes, const char *name,
                                         nqm_hyper *hyper_ret, nqm_error *err);
/** Tensor i (of 2 NQM_HYPER_N_LAYERS) of the file of a network, part of `layer`: its weights if i is even, otherwise its
 *  biases. */
enum { NQM_HYPER_NAME_BYTES = 40 };
nqm_tensor nqm_hyper_tensor(size_t i, const nqm_hyper_layer *layer, char name[NQM_HYPER_NAME_BYTES]);

/** Predict the NBRDF of n samples hd, rgb (n, 3): weights (NQM_NBRDF_WEIGHTS). step: as in nqm_hyper_forward(). */
NQM_MUST_CHECK nqm_status nqm_hyper_encode(const nqm_hyper *hyper, size_t n, const double *hd, const double *rgb,
                                           float step, float *weights, nqm_error *err);
/** nqm_encode_hyper() by this network. */
NQM_MUST_CHECK nqm_status nqm_hyper_encode_brdf(const nqm_hyper *hyper, const nqm_brdf *ref,
                                                const nqm_encode_options *options, nqm_encode_report *report,
                                                nqm_brdf **brdf_ret, nqm_error *err);

#endif
