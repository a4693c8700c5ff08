/* SPDX-License-Identifier: MIT
 *
 * model.h - what a trained metric is, in plain data, and its file: network, directions, whitening, curve, interval, novelty,
 * golden scores and card. <nqm/model.h> is what users see of it.
 */
#ifndef NQM_SRC_MODEL_H
#define NQM_SRC_MODEL_H

#include "net/inference.h"
#include "net/net.h"
#include "sample/sample.h"
#include <nqm/model.h>
#include <nqm/percept.h>

enum { NQM_NOVELTY_BLOCK = 16, NQM_NOVELTY_MAX_GROWTH = 10 };

/** A trained metric. Immutable once it is made; blocks and strings are owned (nqm_alloc). */
struct nqm_model {
    /* Values: copied as bytes by nqm_model_copy(), hence first. */
    size_t n_directions;
    float mean[3], std[3]; /* whitening of log(cbrt(f_r) + 1) of each channel */
    nqm_layout layout;
    double difference_scale;
    /* Scalar features follow the samples in the input: (value - mean) / std, clamped, times scale. */
    float scalar_mean[NQM_SCALAR_COUNT], scalar_std[NQM_SCALAR_COUNT];
    double scalar_scale;
    nqm_target target;
    double target_mean, target_std; /* z-score of the training targets */
    double out_lo, out_hi;          /* range of the output's sigmoid, in normalised targets */
    nqm_curve curve;                /* for NQM_TARGET_LOG_DELTA_E */
    size_t n_interval;
    size_t n_novelty; /* blocks of training pairs for novelty.c; 0: none */
    /* From whitened scalar features (rows) to uncorrelated ones (columns). */
    float novelty_map[NQM_SCALAR_COUNT * NQM_SCALAR_COUNT];
    double novelty_unit;   /* the distance that is novelty 1; > 0 */
    double novelty_growth; /* novelty v widens an interval by exp(novelty_growth v); 0..NQM_NOVELTY_MAX_GROWTH */
    bool stores_half;      /* nqm_model_save() writes the hidden layers' weights in 16 bits; they are rounded to it */
    char sha256[65];       /* checksum of the file that it was read from; "" when it was not */
    /* Owned blocks. */
    nqm_params params;
    double *directions_deg; /* (n_directions, 3) theta_h, theta_d, phi_d */
    double *interval;       /* (n_interval, 3) predicted JOD, ends of its 95 % interval; all rise; NULL: none */
    float *novelty_points;  /* (n_novelty, NQM_SCALAR_COUNT, NQM_NOVELTY_BLOCK) of nqm_novelty_features() */
    char *scalar_names;     /* of the scalar features it takes, separated by commas; NULL: it takes none */
    char *id, *recipe, *card, *licence, *manifest_sha256;
    char *training;             /* JSON: options and report of the training */
    char *golden;               /* JSON: pairs of specs and the JOD that each had when the model was made; NULL: none */
    char *calibration;          /* JSON: what `interval` was made from and covers; NULL together with it */
    nqm_directions *directions; /* made of directions_deg */
    nqm_map *file;              /* of nqm_alloc(): the mapped file that `params` point into; NULL: none */
    unsigned char *memory;      /* of nqm_alloc(): bytes that they point into instead; NULL: none */
    /* Packed networks, made at their first use; NULL: not yet. */
    struct nqm_inference_net *_Atomic inference[NQM_PRECISION_COUNT];
};

/**
 * Parse the bytes of a model file (mapped or embedded). The bytes must outlive the model: where
 * they are aligned the parameters are used in place (`memory` and params.block are NULL then).
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
/** Why a table (n, 3) of finite values cannot be struct nqm_model.interval; NULL: it can. */
const char *nqm_interval_table_fault(size_t n, const double *table);
/** Look up a table: the interval around `jod`, which is finite. */
void nqm_interval_at(size_t n, const double *table, double jod, double *low_ret, double *high_ret);
/** The scale on which intervals are widened: log(JOD / (10 - JOD)), finite at both ends; and its inverse, 0..10. */
double nqm_interval_y(double jod);
double nqm_interval_jod(double y);
/** Widen the interval [*low, *high] around `jod` by the factor `times` (>= 1) on that scale. */
void nqm_interval_widen(double times, double jod, double *low, double *high);
/** A copy that owns everything it points to and has no packed networks yet. Its maker may change it. */
NQM_MUST_CHECK nqm_status nqm_model_copy(const nqm_model *model, nqm_model **copy_ret, nqm_error *err);
/** Round the hidden layers' weights of a model that owns its parameters (a copy) to 16 bits and have nqm_model_save() store
 *  them so. Its golden scores are then outdated. NQM_ERR_NUMERIC when a weight is too large for 16 bits. */
NQM_MUST_CHECK nqm_status nqm_model_round_to_half(nqm_model *model, nqm_error *err);
/** JOD for the network's raw output z; *delta_e_ret (NULL allowed) gets the Delta-E it stands for (NaN: none). */
double nqm_model_jod(const struct nqm_model *model, double z, double *delta_e_ret);

/** Give a model whose directions_deg are set its direction set; nqm_model_free() frees it. */
NQM_MUST_CHECK nqm_status nqm_model_attach_directions(nqm_model *model, nqm_error *err);

/** The names of all scalar features with commas, as a model file holds them; NULL when out of memory. nqm_free(). */
char *nqm_scalar_names(void);

/** How scalar features become inputs: (value - mean) / std, cut off at 5 deviations either way, times scale. Models of
 * unlike pairs stay within what they have seen. */
typedef struct nqm_scalar_whitening {
    const float *mean, *std; /* (NQM_SCALAR_COUNT) */
    double scale;
} nqm_scalar_whitening;
/** x (NQM_SCALAR_COUNT) receives the inputs; features that are NaN become 0. */
void nqm_scalars_whiten(const nqm_scalar_whitening *whitening, const double *scalars, float *x);

/** The 95 % interval around a predicted JOD, as nqm_score_result has it; NaN if the model has no calibration. It widens with
 *  `novelty`, of nqm_model_novelty(): NaN counts as 1, and models without that measure ignore it. */
void nqm_model_interval(const nqm_model *model, double jod, double novelty, double *low_ret, double *high_ret);
/** The novelty of a pair, as nqm_score_result has it; NaN if the model has no such measure. scalars: (NQM_SCALAR_COUNT) of
 *  nqm_scalars_compute(). */
double nqm_model_novelty(const nqm_model *model, const double *scalars);
/** What novelty is measured on: scalar features, whitened and mapped; y (NQM_SCALAR_COUNT). */
void nqm_novelty_features(const nqm_model *model, const double *scalars, float *y);

/** The packed network of a model, made at the first call for a precision; lent by the model. Any thread. */
NQM_MUST_CHECK nqm_status nqm_model_inference(const nqm_model *model, nqm_precision precision,
                                              const nqm_inference_net **net_ret, nqm_error *err);

#endif
