/* SPDX-License-Identifier: MIT
 *
 * hyper.h - the hypernetwork (after Gokbudak et al. 2024, arXiv:2311.15783, "Hypernetworks for Generalizable BRDF
 * Representation"): a network on each sample of a BRDF, mean and maximum over all samples, and a second network that
 * predicts the weights of an NBRDF. Network and gradient: hyper_net.c; input samples and training examples:
 * hyper_data.c; file: hyper_file.c.
 */
#ifndef NQM_SRC_ENCODE_HYPER_H
#define NQM_SRC_ENCODE_HYPER_H

#include "encode/encode.h"
#include "kernel/panel.h"

enum {
    NQM_HYPER_PLACE = 7,                      /* features of a sample's direction pair */
    NQM_HYPER_FEATURES = NQM_HYPER_PLACE + 6, /* and the features of its value */
    NQM_HYPER_N_LAYERS = 6,
    NQM_HYPER_POOLED = 3 /* index of the first layer after the pooling */
};

/* ---- the network ------------------------------------------------------------------------------------------------- */

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
    float step;   /* mean and maximum of the pooling are rounded to multiples of it; 0 (default): they are not */
} nqm_hyper;

/** A network of zeros; nqm_free(hyper->block) also after a failure. */
NQM_MUST_CHECK nqm_status nqm_hyper_create(const nqm_hyper_shape *shape, nqm_hyper *hyper_ret, nqm_error *err);
/** Initial values: He et al. 2015. The last layer has small weights and the bias `mean` (n_out): the weights that the
 *  untrained network predicts for any BRDF. */
void nqm_hyper_init(nqm_hyper *hyper, const float *mean, uint64_t seed);

/** Activations of one pass through the network, n_sets BRDFs of n_samples each. */
typedef struct nqm_hyper_pass {
    size_t n_sets, n_samples;                                             /* at most those of the creation */
    nqm_panels forward[NQM_HYPER_N_LAYERS], backward[NQM_HYPER_N_LAYERS]; /* weights (n_in, n_out), their transpose */
    float *y[NQM_HYPER_N_LAYERS];     /* outputs: (n_sets n_samples, n_out) or (n_sets, n_out) */
    float *slope[NQM_HYPER_N_LAYERS]; /* slopes of GELU; NULL in the last layer */
    float *input;                     /* (n_sets n_samples, NQM_HYPER_FEATURES), filled by the caller */
    float *pooled;                    /* (n_sets, layer[NQM_HYPER_POOLED].n_in) mean, maximum, log of the count */
    size_t *largest; /* (n_sets, n_out of the last sample layer) index of the sample with the maximum */
    float *spare[2]; /* gradients of the backward pass */
    float *padded;   /* the result of a product, or both factors of a gradient */
} nqm_hyper_pass;

/** Buffers for at most n_sets sets of n_samples; nqm_hyper_pass_free() also after a failure. */
NQM_MUST_CHECK nqm_status nqm_hyper_pass_create(const nqm_hyper *hyper, size_t n_sets, size_t n_samples,
                                                nqm_hyper_pass *pass_ret, nqm_error *err);
void nqm_hyper_pass_free(nqm_hyper_pass *pass);

/** Forward pass from pass->input; returns the predicted weights (n_sets, n_out), owned by the pass. */
const float *nqm_hyper_forward(const nqm_hyper *hyper, nqm_hyper_pass *pass);
/** Backward pass after a forward pass; overwrites pass->slope. d_out (n_sets, n_out): gradient of a loss with respect to the
 *  predicted weights. `gradient` has the shape of the network and receives the gradient with respect to its parameters. */
void nqm_hyper_backward(const nqm_hyper *hyper, nqm_hyper_pass *pass, const float *d_out, nqm_hyper *gradient);

/* ---- input samples ----------------------------------------------------------------------------------------------- */

/** Features (NQM_HYPER_PLACE) of half-vector coordinates hd (3). */
void nqm_hyper_place(const double *hd, float *feature);
/** Features of a value rgb (3): feature (6). */
void nqm_hyper_value(const float *rgb, float *feature);
/** Draw n samples of `ref` with theta_h = 90 degrees u^2 and polar angles up to 80 degrees: hd, rgb (n, 3).
 *  NQM_ERR_INCOMPATIBLE if most directions have no value. */
NQM_MUST_CHECK nqm_status nqm_hyper_sample(const nqm_brdf *ref, size_t n, nqm_rng *rng, double *hd, double *rgb,
                                           nqm_error *err);

/* ---- training examples ------------------------------------------------------------------------------------------- */

/** References sampled at the same places: the first half dense, the second uniform. `place` owns the block of all arrays. */
typedef struct nqm_hyper_data {
    size_t n_refs, n_places;
    float *place;  /* (n_places, NQM_HYPER_PLACE) */
    float *input;  /* (6, n_places), inputs of an NBRDF */
    float *weight; /* (n_places) its cosine weight */
    float *rgb;    /* (n_refs, n_places, 3); NaN: no value */
} nqm_hyper_data;

/** Sample each reference and a copy with a random change of gloss; nqm_free(data->place) also after a failure.
 *  NQM_ERR_INCOMPATIBLE if a reference has values at less than three quarters of the places. */
NQM_MUST_CHECK nqm_status nqm_hyper_data_create(size_t n, const nqm_brdf *const *refs, size_t n_places, uint64_t seed,
                                                nqm_ticker *ticker, nqm_hyper_data *data_ret, nqm_error *err);

/** One training example: the samples that the hypernetwork reads, and the directions at which its NBRDF is compared. */
typedef struct nqm_hyper_example {
    size_t n_samples, n_queries;
    float *samples;               /* (n_samples, NQM_HYPER_FEATURES) */
    float *input, *weight, *goal; /* as in nqm_nbrdf_batch, of n_queries directions */
} nqm_hyper_example;

/** Fill an example with a random reference or mixture of two, with random changes of colour. */
void nqm_hyper_draw_example(const nqm_hyper_data *data, nqm_rng *rng, const nqm_hyper_example *example);

/* ---- file and use ------------------------------------------------------------------------------------------------ */

/** Write the network and the names of its references. */
NQM_MUST_CHECK nqm_status nqm_hyper_write(const nqm_hyper *hyper, size_t n, const char *const *names,
                                          const nqm_learn_options *options, const char *path, nqm_error *err);
/** Read the bytes of a file; NQM_ERR_MODEL unless it contains a hypernetwork that predicts NBRDFs. */
NQM_MUST_CHECK nqm_status nqm_hyper_read(const unsigned char *data, size_t n_bytes, const char *name,
                                         nqm_hyper *hyper_ret, nqm_error *err);
/** Predict the NBRDF of n samples hd, rgb (n, 3): weights (NQM_NBRDF_WEIGHTS). */
NQM_MUST_CHECK nqm_status nqm_hyper_encode(const nqm_hyper *hyper, size_t n, const double *hd, const double *rgb,
                                           float *weights, nqm_error *err);
/** nqm_encode_hyper() by this network; sets its step. */
NQM_MUST_CHECK nqm_status nqm_hyper_encode_brdf(nqm_hyper *hyper, const nqm_brdf *ref,
                                                const nqm_encode_options *options, nqm_encode_report *report,
                                                nqm_brdf **brdf_ret, nqm_error *err);

#endif
