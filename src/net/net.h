/* SPDX-License-Identifier: MIT
 *
 * net.h - the multi-layer perceptron of the paper (section 3.2): parameters, loss, schedule, and the model file that
 * carries it. Sizes are data; the paper's are 3000-1024-716-501-1. Training is in net/trainer.h, scoring in
 * net/inference.h.
 *
 * hidden layer l:  y = dropout(gelu(layernorm(x W_l^T + b_l))) ; output: z = x W^T + b ; prediction = lo + (hi-lo)
 * sigmoid(z)
 */
#ifndef NQM_SRC_NET_H
#define NQM_SRC_NET_H

#include "base/base.h"
#include "math/math.h"
#include <nqm/metric.h>

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

/* ---- model file -------------------------------------------------------------------------------------------------- */

enum { NQM_NOVELTY_BLOCK = 16, NQM_NOVELTY_MAX_GROWTH = 10 };

/** What a model is, in plain data. Strings are owned by the model (nqm_alloc). */
struct nqm_model {
    nqm_params params;
    size_t n_directions;
    double *directions_deg; /* (n_directions, 3) theta_h, theta_d, phi_d */
    float mean[3], std[3];  /* whitening of log(cbrt(rho)+1), per channel (all equal for scalar whitening) */
    int layout;             /* nqm_layout */
    double difference_scale;
    /* Scalar features behind the samples, each (value - mean) / std, cut off, times scale; scalar_names NULL: none. */
    char *scalar_names; /* with commas, as this library must name them too; metric/model.c checks it */
    float scalar_mean[NQM_SCALAR_COUNT], scalar_std[NQM_SCALAR_COUNT];
    double scalar_scale;
    int target;                     /* nqm_target */
    double target_mean, target_std; /* z-score of the training targets */
    double out_lo, out_hi;          /* range of the sigmoid, in normalised targets */
    nqm_jod_curve curve;            /* for NQM_TARGET_LOG_DELTA_E */
    char *id, *recipe, *card, *licence, *manifest_sha256;
    char *training; /* JSON: options and report of the training */
    char *golden;   /* JSON: pairs of specs and the JOD each had when the model was saved; NULL: none */
    size_t n_interval;
    double *interval;  /* (n_interval, 3) predicted JOD, ends of its 95 % interval; all rise; NULL: not calibrated */
    char *calibration; /* JSON: what `interval` was made from and covers; NULL together with it */
    /* Training pairs to tell how novel a pair is (metric/novelty.c); only together with scalar features and `interval`. */
    size_t n_novelty;      /* blocks of points; 0: none */
    float *novelty_points; /* (n_novelty, NQM_SCALAR_COUNT, NQM_NOVELTY_BLOCK) of nqm_novelty_features() */
    float novelty_map[NQM_SCALAR_COUNT *
                      NQM_SCALAR_COUNT]; /* from whitened scalar features (rows) to uncorrelated ones */
    double novelty_unit;                 /* the distance that counts as 1, > 0 */
    double novelty_growth; /* a novelty of v widens intervals exp(novelty_growth v) times; 0..NQM_NOVELTY_MAX_GROWTH */
    char sha256[65];       /* checksum of the file it came from or was saved to */
    void *directions;      /* nqm_directions made by the sample layer; see metric/model.c */
    void (*directions_free)(void *);
    nqm_map *file; /* of nqm_alloc(): the mapping that `params` point into, closed by nqm_model_destroy(); or NULL */
    struct nqm_inference_net *_Atomic inference[NQM_PRECISION_COUNT]; /* packed at first use; NULL: not yet */
};

/**
 * Parse a model file that lies in memory (a mapped file or an embedded one). The bytes must outlive the model: where
 * they are aligned for floats the parameters are used in place (params.block is NULL then).
 *
 * @param name     for messages
 * @param verify   false leaves out what reads every byte, the checksum and the search for non-finite parameters: for
 * the embedded models, which the tests check
 * @return NQM_ERR_FORMAT: not safetensors; NQM_ERR_MODEL: not a model, wrong checksum, or a tensor missing, surplus,
 * misshapen or not finite
 */
NQM_MUST_CHECK nqm_status nqm_model_parse(const unsigned char *data, size_t n_bytes, const char *name, bool verify,
                                          struct nqm_model **model_ret, nqm_error *err);
/** Number of scalar features in the model's input. */
static inline size_t nqm_model_n_scalars(const struct nqm_model *model) {
    return model->scalar_names ? NQM_SCALAR_COUNT : 0;
}
/** What is wrong with a table (n, 3) of finite numbers that is to be struct nqm_model.interval; NULL: nothing. */
const char *nqm_interval_table_fault(size_t n, const double *table);
/** Look up a table: the interval around `jod`, which is finite. */
void nqm_interval_at(size_t n, const double *table, double jod, double *low_ret, double *high_ret);
/** The scale on which intervals are widened: log(JOD / (10 - JOD)), softened at both ends, and back to 0..10. */
double nqm_interval_y(double jod);
double nqm_interval_jod(double y);
/** Move both ends away from `jod`, `times` (>= 1) as far on that scale. */
void nqm_interval_widen(double times, double jod, double *low, double *high);
/** Write a model file; sets model->sha256. */
NQM_MUST_CHECK nqm_status nqm_model_write(struct nqm_model *model, const char *path, nqm_error *err);
void nqm_model_destroy(struct nqm_model *model);
/** JOD for the network's raw output z; *delta_e_ret (NULL allowed) gets the Delta-E it stands for (NaN: none). */
double nqm_model_jod(const struct nqm_model *model, double z, double *delta_e_ret);

#endif
