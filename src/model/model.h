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

/** What a model is, in plain data. Strings are owned by the model (nqm_alloc). */
struct nqm_model {
    nqm_params params;
    size_t n_directions;
    double *directions_deg; /* (n_directions, 3) theta_h, theta_d, phi_d */
    float mean[3], std[3];  /* whitening of log(cbrt(rho)+1), per channel (all equal for scalar whitening) */
    nqm_layout layout;
    double difference_scale;
    /* Scalar features behind the samples, each (value - mean) / std, cut off, times scale; scalar_names NULL: none. */
    char *scalar_names; /* with commas, as this library must name them too; model.c checks it */
    float scalar_mean[NQM_SCALAR_COUNT], scalar_std[NQM_SCALAR_COUNT];
    double scalar_scale;
    nqm_target target;
    double target_mean, target_std; /* z-score of the training targets */
    double out_lo, out_hi;          /* range of the sigmoid, in normalised targets */
    nqm_curve curve;                /* for NQM_TARGET_LOG_DELTA_E */
    char *id, *recipe, *card, *licence, *manifest_sha256;
    char *training; /* JSON: options and report of the training */
    char *golden;   /* JSON: pairs of specs and the JOD each had when the model was saved; NULL: none */
    size_t n_interval;
    double *interval;  /* (n_interval, 3) predicted JOD, ends of its 95 % interval; all rise; NULL: not calibrated */
    char *calibration; /* JSON: what `interval` was made from and covers; NULL together with it */
    /* Training pairs to tell how novel a pair is (novelty.c); only together with scalar features and `interval`. */
    size_t n_novelty;      /* blocks of points; 0: none */
    float *novelty_points; /* (n_novelty, NQM_SCALAR_COUNT, NQM_NOVELTY_BLOCK) of nqm_novelty_features() */
    float novelty_map[NQM_SCALAR_COUNT *
                      NQM_SCALAR_COUNT]; /* from whitened scalar features (rows) to uncorrelated ones */
    double novelty_unit;                 /* the distance that counts as 1, > 0 */
    double novelty_growth; /* a novelty of v widens intervals exp(novelty_growth v) times; 0..NQM_NOVELTY_MAX_GROWTH */
    char sha256[65];       /* checksum of the file it came from or was saved to */
    nqm_directions *directions; /* made of directions_deg */
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

/** Give a model whose directions_deg are set its direction set; nqm_model_destroy() frees it with the model. */
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

/** What novelty is measured on: scalar features, whitened and mapped; y (NQM_SCALAR_COUNT). */
void nqm_novelty_features(const nqm_model *model, const double *scalars, float *y);

/** The packed network of a model, made at the first call for a precision; lent by the model. Any thread. */
NQM_MUST_CHECK nqm_status nqm_model_inference(const nqm_model *model, nqm_precision precision,
                                              const nqm_inference_net **net_ret, nqm_error *err);

#endif
