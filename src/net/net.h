/* SPDX-License-Identifier: MIT
 *
 * net.h - the multi-layer perceptron of the paper (section 3.2): parameters, loss and schedule. Sizes are data; the paper's are 3000-1024-716-501-1. Training is in net/trainer.h, scoring in
 * net/inference.h.
 *
 * hidden layer l:  y = dropout(gelu(layernorm(x W_l^T + b_l))) ; output: z = x W^T + b ; prediction = lo + (hi-lo)
 * sigmoid(z)
 */
#ifndef NQM_SRC_NET_H
#define NQM_SRC_NET_H

#include "base/base.h"

enum { NQM_NET_MAX_LAYERS = 8 };

/** Sizes of an MLP; layer l maps sizes[l] to sizes[l+1]; all but the last have LayerNorm, GELU and dropout. */
typedef struct nqm_net_shape {
    size_t n_layers; /**< 2..NQM_NET_MAX_LAYERS: the hidden ones and the output */
    size_t sizes[NQM_NET_MAX_LAYERS + 1];
} nqm_net_shape;

/** The parameters (or gradients, or Adam moments) of one layer: views into one block. */
typedef struct nqm_layer {
    float *w;     /* (out, in) */
    float *b;     /* (out) */
    float *gamma; /* (out), NULL in the last layer */
    float *beta;  /* (out), NULL in the last layer */
} nqm_layer;

/** One block of numbers and named views into it, in the order w b gamma beta of each layer. */
typedef struct nqm_params {
    nqm_net_shape shape;
    size_t n;     /* numbers in the block */
    float *block; /* (n), 64-byte aligned */
    nqm_layer layer[NQM_NET_MAX_LAYERS];
} nqm_params;

/** NQM_ERR_ARG when a width or the number of layers is out of range, or the last width is not 1. */
NQM_MUST_CHECK nqm_status nqm_net_shape_check(const nqm_net_shape *shape, nqm_error *err);

enum { NQM_MIN_PARALLEL = 16384 }; /* numbers; for fewer, waking a thread costs more than it saves */

size_t nqm_params_count(const nqm_net_shape *shape);
NQM_MUST_CHECK nqm_status nqm_params_create(const nqm_net_shape *shape, nqm_params *params_ret, nqm_error *err);
void nqm_params_free(nqm_params *params);
/** He-uniform weights (limit sqrt(6 / in)), zero biases, gamma 1, beta 0 (paper's notebook). */
void nqm_params_init(nqm_params *params, uint64_t seed);

/** How dropout masks are made: by a counter-based hash of (seed, step, layer, element), or given (tests), or not at
 * all. */
typedef struct nqm_dropout {
    double p;                                 /* probability of 0; kept values are scaled by 1/(1-p); 0: off */
    uint64_t seed, step;                      /* for the hash */
    const uint8_t *given[NQM_NET_MAX_LAYERS]; /* (batch, out) 1 = keep, or NULL: hash */
} nqm_dropout;

/** Mean log-cosh of (prediction - target), prediction = lo + (hi-lo) sigmoid(z); dz receives d loss/d z (NULL allowed).
 *  log cosh written stably: |d| + log1p(exp(-2|d|)) - log 2. */
double nqm_logcosh_loss(size_t batch, const float *z, const float *target, double lo, double hi, float *dz);
double nqm_sigmoid(double z);

/** The state of Adam between steps: moments in the form of the parameters. net/trainer.h takes the steps. */
typedef struct nqm_adam {
    nqm_params m, v;
    uint64_t step;
} nqm_adam;
NQM_MUST_CHECK nqm_status nqm_adam_create(const nqm_net_shape *shape, nqm_adam *adam_ret, nqm_error *err);
void nqm_adam_free(nqm_adam *adam);
/** ReduceLROnPlateau of PyTorch: mode min, relative threshold 1e-4, cooldown 0. */
typedef struct nqm_plateau {
    double factor;
    size_t patience;
    double best; /* start with infinity */
    size_t bad_epochs;
} nqm_plateau;
/** The factor to multiply the rates with after an epoch (1 or `factor`). */
double nqm_plateau_step(nqm_plateau *plateau, double loss);
/** A learning rate times that factor; unchanged when the step would be 1e-8 or less, as PyTorch does. */
double nqm_plateau_rate(double lr, double factor);

/** Half a cosine (Loshchilov and Hutter 2017, arXiv:1608.03983, without restarts): the factor of the rates when `done` of
 *  `all` epochs are finished, from 1 towards 0. */
double nqm_cosine_factor(size_t done, size_t all);

#endif
