/* SPDX-License-Identifier: MIT
 *
 * net.h - the multi-layer perceptron of the paper (section 3.2): parameters, loss, learning-rate schedules. The sizes of the
 * layers are data; the paper's are 3000-1024-716-501-1. A network may have several outputs, each with its bounds. Training is in
 * net/trainer.h, scoring in net/inference.h, the gradient of scores by the inputs in net/input_gradient.h.
 *
 *   hidden layer l   y = dropout(GELU(LayerNorm(x W_l^T + b_l)))
 *   output layer     z = x W^T + b
 *   prediction       lo + (hi - lo) sigmoid(z)
 */
#ifndef NQM_SRC_NET_H
#define NQM_SRC_NET_H

#include "base/base.h"

enum { NQM_NET_MAX_LAYERS = 8, NQM_NET_MAX_OUTPUTS = 16 };

/** Sizes of an MLP; layer l maps sizes[l] values to sizes[l+1]. */
typedef struct nqm_net_shape {
    size_t n_layers; /**< 2..NQM_NET_MAX_LAYERS: the hidden layers and the output layer */
    size_t sizes[NQM_NET_MAX_LAYERS + 1];
} nqm_net_shape;

/** The parameters (or gradients, or Adam moments) of one layer: views into one block. */
typedef struct nqm_layer {
    float *w;             /**< (out, in) */
    const uint16_t *half; /* (out, in) binary16 in place of w, which is NULL then: models read from files; else NULL */
    float *b;             /**< (out) */
    float *gamma;         /**< (out) LayerNorm's factor; NULL in the output layer */
    float *beta;          /**< (out) LayerNorm's offset; NULL in the output layer */
} nqm_layer;

/** The parameters of a network: one block, in the order w b gamma beta of each layer. */
typedef struct nqm_params {
    nqm_net_shape shape;
    size_t n;     /**< floats in the block */
    float *block; /**< (n), 64-byte aligned */
    nqm_layer layer[NQM_NET_MAX_LAYERS];
} nqm_params;

/** NQM_ERR_ARG when a width (1..2^24) or the number of layers is out of range, or there are more than
 *  NQM_NET_MAX_OUTPUTS outputs. */
NQM_MUST_CHECK nqm_status nqm_net_shape_check(const nqm_net_shape *shape, nqm_error *err);

enum { NQM_MIN_PARALLEL = 1 << 17 }; /**< floats; for fewer, waking a thread costs more than it saves */

size_t nqm_params_count(const nqm_net_shape *shape);
/** All 0. NQM_ERR_ARG, NQM_ERR_NOMEM. */
NQM_MUST_CHECK nqm_status nqm_params_create(const nqm_net_shape *shape, nqm_params *params_ret, nqm_error *err);
void nqm_params_free(nqm_params *params);
/** He-uniform weights (limit sqrt(6 / in)), zero biases, gamma 1, beta 0, as in the paper's notebook. */
void nqm_params_init(nqm_params *params, uint64_t seed);

/** Inverted dropout: an element is 0 with probability p, else scaled by 1/(1-p). The masks come from a counter-based hash of
 *  (seed, step, layer, element), or are given (tests). */
typedef struct nqm_dropout {
    double p;                                 /**< 0: no dropout */
    uint64_t seed, step;                      /**< of the hash */
    const uint8_t *given[NQM_NET_MAX_LAYERS]; /**< (batch, out) 1 = keep; NULL: hash */
} nqm_dropout;

/** The range of an output's predictions, and its weight in the loss. */
typedef struct nqm_output_bounds {
    double lo, hi, weight;
} nqm_output_bounds;

/** Sum over the outputs of weight times the mean of log cosh(d), d = prediction - target, prediction = lo + (hi-lo) sigmoid(z),
 *  written stably as |d| + log1p(exp(-2|d|)) - log 2. z, target: (batch, n_outputs); dz, the same shape, receives
 *  d loss / d z; NULL allowed. */
double nqm_logcosh_loss(size_t batch, size_t n_outputs, const nqm_output_bounds *bounds, const float *z,
                        const float *target, float *dz);
double nqm_sigmoid(double z);

/** The state of Adam between steps, as a checkpoint stores it. net/trainer.h takes the steps. */
typedef struct nqm_adam {
    nqm_params m, v; /**< first and second moments of all parameters */
    uint64_t step;   /**< steps taken */
} nqm_adam;
NQM_MUST_CHECK nqm_status nqm_adam_create(const nqm_net_shape *shape, nqm_adam *adam_ret, nqm_error *err);
void nqm_adam_free(nqm_adam *adam);

/** ReduceLROnPlateau of PyTorch: mode min, relative threshold 1e-4, cooldown 0. */
typedef struct nqm_plateau {
    double factor;
    size_t patience;
    double best; /**< start with infinity */
    size_t bad_epochs;
} nqm_plateau;
/** The factor for the learning rates after an epoch with that validation loss: 1 or `factor`. */
double nqm_plateau_step(nqm_plateau *plateau, double loss);
/** lr times factor; lr unchanged when it would fall by 1e-8 or less, as in PyTorch. */
double nqm_plateau_rate(double lr, double factor);

/** Half a cosine (Loshchilov and Hutter 2017, arXiv:1608.03983, without restarts): the factor of the learning rates after
 *  `done` of `all` epochs, from 1 down to 0. */
double nqm_cosine_factor(size_t done, size_t all);

#endif
