/* SPDX-License-Identifier: MIT
 *
 * hyper.h - the hypernetwork (after Gokbudak et al. 2024, arXiv:2311.15783, "Hypernetworks for Generalizable BRDF
 * Representation"): a network on each sample of a BRDF, the mean and the largest over all samples, and a second network
 * that writes the weights of an NBRDF. Its parts: the network with its gradient (hyper_net.c), the samples it
 * reads (hyper_samples.c), training examples (hyper_data.c), its file (hyper_file.c).
 */
#ifndef NQM_SRC_FIT_HYPER_H
#define NQM_SRC_FIT_HYPER_H

#include "fit/encoders.h"

enum {
    NQM_HYPER_PLACE = 7,                      /* features of where a sample lies */
    NQM_HYPER_FEATURES = NQM_HYPER_PLACE + 6, /* and of its value */
    NQM_HYPER_N_LAYERS = 6,
    NQM_HYPER_POOLED = 3 /* the first layer behind the pooling */
};

/* ---- the network ------------------------------------------------------------------------------------------------- */

/** Widths of the hidden layers: three on each sample, two behind the pooling. */
typedef struct nqm_hyper_shape {
    size_t sample[3], set[2];
    size_t n_out; /* numbers that it writes: NQM_NBRDF_WEIGHTS, fewer in tests */
} nqm_hyper_shape;

/** y = GELU(x W + b), linear in the last layer. */
typedef struct nqm_hyper_layer {
    size_t n_in, n_out;
    float *w; /* (n_in, n_out) */
    float *b; /* (n_out) */
} nqm_hyper_layer;

typedef struct nqm_hyper {
    nqm_hyper_layer layer[NQM_HYPER_N_LAYERS];
    size_t n;     /* numbers in the block */
    float *block; /* all weights and biases, layer by layer */
} nqm_hyper;

/** A network of zeros; free with nqm_hyper_free() whatever the outcome. */
NQM_MUST_CHECK nqm_status nqm_hyper_create(const nqm_hyper_shape *shape, nqm_hyper *hyper_ret, nqm_error *err);
void nqm_hyper_free(nqm_hyper *hyper);
/** Initial values: He et al. 2015; the last layer is small and its bias, the network that is written for any BRDF at
 *  first, is `mean` (n_out). */
void nqm_hyper_init(nqm_hyper *hyper, const float *mean, uint64_t seed);

/** What one pass through the network keeps: n_sets BRDFs of n_samples each. */
typedef struct nqm_hyper_pass {
    size_t n_sets, n_samples;         /* at most those of the creation */
    float *y[NQM_HYPER_N_LAYERS];     /* outputs: (n_sets n_samples, n_out) or (n_sets, n_out) */
    float *slope[NQM_HYPER_N_LAYERS]; /* of GELU there; NULL in the last */
    float *input;                     /* (n_sets n_samples, NQM_HYPER_FEATURES), filled by the caller */
    float *pooled;                    /* (n_sets, layer[NQM_HYPER_POOLED].n_in) mean, largest, log of the count */
    size_t *largest;                  /* (n_sets, n_out of the last sample layer) which sample it was */
    float *spare[2];                  /* gradients on their way back */
} nqm_hyper_pass;

/** Room for so many sets and samples, or fewer; free with nqm_hyper_pass_free() whatever the outcome. */
NQM_MUST_CHECK nqm_status nqm_hyper_pass_create(const nqm_hyper *hyper, size_t n_sets, size_t n_samples,
                                                nqm_hyper_pass *pass_ret, nqm_error *err);
void nqm_hyper_pass_free(nqm_hyper_pass *pass);

/** From pass->input to the weights written: (n_sets, n_out), lent by the pass. */
const float *nqm_hyper_forward(const nqm_hyper *hyper, nqm_hyper_pass *pass);
/** After a forward pass: `slope` is used up. d_out (n_sets, n_out) derivatives of a loss by what was written; `gradient`
 *  has the shape of the network and receives the derivatives by its numbers, not added. */
void nqm_hyper_backward(const nqm_hyper *hyper, nqm_hyper_pass *pass, const float *d_out, nqm_hyper *gradient);

/* ---- its samples ------------------------------------------------------------------------------------------------- */

/** Half-vector coordinates of a sample: theta_h = 90 degrees u^2, u, theta_d and phi_d uniform, both directions within
 *  80 degrees. hd: (3). */
void nqm_hyper_draw_dense(nqm_rng *rng, double *hd);
/** The same, both directions uniform by solid angle. */
void nqm_hyper_draw_uniform(nqm_rng *rng, double *hd);
/** Features of a place (NQM_HYPER_PLACE). */
void nqm_hyper_place(const double *hd, float *feature);
/** Features of a value rgb (3): feature (6). */
void nqm_hyper_value(const float *rgb, float *feature);
/** n dense places where `ref` has a value, and the values: hd, rgb (n, 3). NQM_ERR_INCOMPATIBLE when most have none. */
NQM_MUST_CHECK nqm_status nqm_hyper_sample(const nqm_brdf *ref, size_t n, nqm_rng *rng, double *hd, double *rgb,
                                           nqm_error *err);

/* ---- its training examples --------------------------------------------------------------------------------------- */

/** References at shared places: the first half dense, the second uniform. */
typedef struct nqm_hyper_data {
    size_t n_refs, n_places;
    float *place;  /* (n_places, NQM_HYPER_PLACE) */
    float *input;  /* (6, n_places), inputs of an NBRDF */
    float *weight; /* (n_places) its cosine weight */
    float *rgb;    /* (n_refs, n_places, 3); NaN: no value */
} nqm_hyper_data;

/** Sample each reference as it is and once more with another gloss; free with nqm_hyper_data_free() whatever the
 *  outcome. NQM_ERR_INCOMPATIBLE when a reference has values at too few places. */
NQM_MUST_CHECK nqm_status nqm_hyper_data_create(size_t n, const nqm_brdf *const *refs, size_t n_places, uint64_t seed,
                                                nqm_ticker *ticker, nqm_hyper_data *data_ret, nqm_error *err);
void nqm_hyper_data_free(nqm_hyper_data *data);

/** One training example: what the hypernetwork reads and where its NBRDF is judged. */
typedef struct nqm_hyper_example {
    size_t n_samples, n_queries;
    float *samples;               /* (n_samples, NQM_HYPER_FEATURES) */
    float *input, *weight, *goal; /* as in nqm_nbrdf_batch, of n_queries directions */
} nqm_hyper_example;

/** A reference drawn at random, or a mixture of two, with its colours changed at random. */
void nqm_hyper_draw_example(const nqm_hyper_data *data, nqm_rng *rng, const nqm_hyper_example *example);

/* ---- its file, and its use --------------------------------------------------------------------------------------- */

/** Write the network and what it was learned from. */
NQM_MUST_CHECK nqm_status nqm_hyper_write(const nqm_hyper *hyper, size_t n, const char *const *names,
                                          const nqm_learn_options *options, const char *path, nqm_error *err);
/** Read it from the bytes of a file; anything but a hypernetwork that writes NBRDFs gives NQM_ERR_MODEL. */
NQM_MUST_CHECK nqm_status nqm_hyper_read(const unsigned char *data, size_t n_bytes, const char *name,
                                         nqm_hyper *hyper_ret, nqm_error *err);
/** The NBRDF that `hyper` writes for n samples at hd with values rgb (n, 3): weights (NQM_NBRDF_WEIGHTS). */
NQM_MUST_CHECK nqm_status nqm_hyper_encode(const nqm_hyper *hyper, size_t n, const double *hd, const double *rgb,
                                           float *weights, nqm_error *err);

#endif
