/* SPDX-License-Identifier: MIT
 *
 * model.h - the data of a trained metric and its file: network, directions, whitening, curve, interval, novelty, golden
 * scores and card. <nqm/model.h> is the public interface.
 */
#ifndef NQM_SRC_MODEL_H
#define NQM_SRC_MODEL_H

#include "net/inference.h"
#include "net/net.h"
#include "percept/percept.h"
#include "sample/sample.h"
#include "sample/slopes.h"
#include <nqm/model.h>

enum { NQM_NOVELTY_BLOCK = 16, NQM_NOVELTY_MAX_GROWTH = 10 };
/** Features of a pair that predict the size of errors, besides its novelty; all are >= 0. See nqm_spread_features(). */
enum { NQM_SPREAD_DISAGREEMENT, NQM_SPREAD_PEAK, NQM_SPREAD_FEATURES };
/** Points at which the least half-width of intervals is known, evenly over the logits of JOD 0 to 10. */
enum { NQM_INTERVAL_KNOTS = 17 };

/** Conversion of scalar features to inputs: (value - mean) / std, clamped to [-5, 5], times scale. Clamping keeps the
 *  inputs of unusual pairs near the range of the training pairs. */
typedef struct nqm_scalar_whitening {
    size_t n;                                            /* inputs; each is one of the features of nqm_scalar */
    uint8_t feature[NQM_SCALAR_COUNT];                   /* (n) which */
    float mean[NQM_SCALAR_COUNT], std[NQM_SCALAR_COUNT]; /* (n) */
    double scale;
} nqm_scalar_whitening;

/** Conversion of the network's output z to the predicted quantity: mean + std (lo + (hi - lo) sigmoid(z)). */
typedef struct nqm_output_range {
    double mean, std; /* mean and deviation of the training targets */
    double lo, hi;    /* normalised target at sigmoid 0 and 1 */
} nqm_output_range;

/** Points of the pictures that the transport matrix of a dataset makes of samples; other matrices have any multiple of
 *  NQM_TRANSPORT_STEP up to NQM_TRANSPORT_MAX_POINTS. */
enum { NQM_TRANSPORT_POINTS = 256, NQM_TRANSPORT_STEP = 32, NQM_TRANSPORT_MAX_POINTS = 4096 };
/** Light transport of a scene: pictures of few points as linear functions of samples. Arrays are borrowed. */
typedef struct nqm_transport {
    size_t n_directions;
    const float *light; /* (n_directions, 3, points.n) cd/m2 per f_r of 1/sr; NULL: there is no matrix */
    nqm_picture_points points;
} nqm_transport;

/** Distances whose weighted sum is the similarity's (nqm_apart_distances()), and then the 95 % half-width of its logarithm. */
enum {
    NQM_APART_DELTA_E,
    NQM_APART_BRIGHTNESS,
    NQM_APART_COLOUR,
    NQM_APART_CONTRAST,
    NQM_APART_STRUCTURE,
    NQM_APART_BUILT_IN,
    NQM_APART
};

/** A trained metric. Immutable after creation; it owns its blocks and strings (nqm_alloc). */
struct nqm_model {
    /* Plain values. They precede `params`, because nqm_model_copy() copies them with one memcpy. */
    nqm_features features; /* conversion of samples to inputs; mean and std are those of the training references */
    nqm_scalar_whitening scalars; /* the scalar features follow the samples in the input */
    nqm_target target;
    nqm_output_range output;
    nqm_output_range
        parts[NQM_LABEL_PARTS]; /* of the outputs after the first, if there are any: nqm_model_has_parts() */
    nqm_curve curve;            /* curve for NQM_TARGET_LOG_DELTA_E */
    size_t n_interval;
    size_t n_novelty; /* blocks of NQM_NOVELTY_BLOCK training pairs for novelty.c; 0: none */
    /* Linear map from whitened scalar features (rows) to uncorrelated ones (columns). */
    float novelty_map[NQM_SCALAR_COUNT * NQM_SCALAR_COUNT]; /* (scalars.n, scalars.n) */
    size_t n_transport, n_points;                           /* directions and points of `transport`; 0: none */
    size_t n_slopes, n_slope_points, n_slope_wo;            /* rows of `slopes` and points of it; 0: none */
    double novelty_unit;                                    /* distance that has novelty 1; > 0 */
    double novelty_growth; /* novelty v widens an interval by exp(novelty_growth v); 0..NQM_NOVELTY_MAX_GROWTH */
    double spread_growth[NQM_SPREAD_FEATURES]; /* the same of each feature of nqm_spread_features() */
    double interval_floor
        [NQM_INTERVAL_KNOTS];         /* least half-width of intervals on the logit scale, at nqm_interval_knot() */
    double similarity[NQM_APART + 1]; /* weights of the distances and half-width; all 0: the built-in distance alone */
    bool stores_half; /* nqm_model_save() writes the hidden layers' weights as float16; they are already rounded */
    char sha256[65];  /* checksum of its file; "" when it was not read from a file */
    /* Owned blocks. */
    nqm_params params;
    nqm_directions *directions;
    double *interval; /* (n_interval, 3) predicted JOD, both ends of its 95 % interval, columns ascending; NULL: none */
    float *transport; /* as `light` in nqm_transport; NULL: none */
    double *transport_points; /* (n_points, 3) as in nqm_picture_points; NULL: none */
    float *slopes;            /* with the next: of nqm_slope_light, of models for anisotropic BRDFs; NULL: none */
    double *slope_points, *slope_wo;
    float *novelty_points; /* (n_novelty, scalars.n, NQM_NOVELTY_BLOCK) of nqm_novelty_features() */
    char *scalar_names;    /* names of its scalar inputs, separated by commas; NULL: it has none */
    char *id, *recipe, *card, *licence, *manifest_sha256;
    char *training;        /* JSON: options and report of the training */
    char *golden;          /* JSON: pairs of specs and the JOD of each when the model was created; NULL: none */
    char *calibration;     /* JSON: data and coverage of `interval`; NULL if and only if that is NULL */
    nqm_map file;          /* the mapped file that contains the parameters; zeroed: none */
    unsigned char *memory; /* of nqm_alloc(): a buffer that contains the parameters instead; NULL: none */
    struct nqm_inference_net *_Atomic inference; /* the packed network, created at its first use; NULL before that */
};

/**
 * Parse the bytes of a model file (mapped or embedded). The bytes must outlive the model: if all tensors of the network
 * are aligned, the parameters are used in place (`memory` and params.block are then NULL).
 *
 * @param name     for messages
 * @param verify   false skips the checks that read every byte (checksum, search for non-finite parameters); for
 * embedded models, which the tests check
 * @return NQM_ERR_FORMAT: not safetensors; NQM_ERR_MODEL: not a model, wrong checksum, or a tensor missing, surplus,
 * misshapen or not finite, or a scalar feature that this version does not have
 */
NQM_MUST_CHECK nqm_status nqm_model_parse(const unsigned char *data, size_t n_bytes, const char *name, bool verify,
                                          struct nqm_model **model_ret, nqm_error *err);
/** The words of nqm_layout and of nqm_target, NULL-terminated. */
extern const char *const nqm_layout_words[], *const nqm_target_words[];
/** "log_rmse", ..., "ref_colour"; static storage; NULL for an i that is too large. */
const char *nqm_scalar_name(size_t i);
/** Why a table (n, 3) of finite values cannot be struct nqm_model.interval; NULL: it can. */
const char *nqm_interval_table_fault(size_t n, const double *table);
/** Interpolate the interval around `jod` (finite) in a table (n, 3). */
void nqm_interval_at(size_t n, const double *table, double jod, double *low_ret, double *high_ret);
/** Logit scale on which intervals are widened, log(JOD / (10 - JOD)), finite at 0 and 10; and its inverse, 0..10. */
double nqm_interval_y(double jod);
double nqm_interval_jod(double y);
/** Widen the interval [*low, *high] around `jod` by the factor `times` (>= 1) on that scale. */
void nqm_interval_widen(double times, double jod, double *low, double *high);
/** Features of the error of a predicted JOD, (NQM_SPREAD_FEATURES):
 *  ln(1 + |y(jod) - y(estimated JOD)| / 0.1), 0 for models without transport: where the network corrects more, it errs more;
 *  max(0, ref_peak - 8) / 10: peaks this narrow change within the samples' distances.
 *  y: nqm_interval_y(). jod: finite; log_estimate, ref_peak: scalar features. */
void nqm_spread_features(const nqm_model *model, double jod, double log_estimate, double ref_peak, double *features);
/** Whether its intervals depend on such features, or have a least width; false for files of earlier versions. */
bool nqm_model_has_spread(const nqm_model *model);
/** The logit of knot k of struct nqm_model.interval_floor. */
double nqm_interval_knot(size_t k);
/** The logarithm of the factor by which such features widen an interval, >= 0. */
double nqm_model_spread(const nqm_model *model, const double *features);
/** Make a deep copy without packed networks. The caller may change it before sharing it. */
NQM_MUST_CHECK nqm_status nqm_model_copy(const nqm_model *model, nqm_model **copy_ret, nqm_error *err);
/** Round the hidden layers' weights of a model that owns its parameters (a copy) to float16, the format in which
 *  nqm_model_save() then stores them. The golden scores must be recomputed. NQM_ERR_NUMERIC: a weight is too
 *  large. */
NQM_MUST_CHECK nqm_status nqm_model_round_to_half(nqm_model *model, nqm_error *err);
/** Whether the model has a network. Without one, its predictions are the estimates of its transport matrix: as if all outputs z
 *  were 0, with ranges that have no correction there. */
static inline bool nqm_model_has_network(const struct nqm_model *model) {
    return model->params.shape.n_layers > 0;
}
/** Whether the model predicts the parts of a label: by one output each, after that of its target. */
static inline bool nqm_model_has_parts(const struct nqm_model *model) {
    return !nqm_model_has_network(model) || model->params.shape.sizes[model->params.shape.n_layers] > 1;
}
/** Number of outputs z. */
static inline size_t nqm_model_n_outputs(const struct nqm_model *model) {
    return nqm_model_has_parts(model) ? 1 + NQM_LABEL_PARTS : 1;
}
/** The quantities that outputs are trained to predict instead of the parts, so that small differences count and large ones
 *  do not dominate: asinh of shift and of 30 times contrast, logarithm of structure (raised to min_structure > 0). */
void nqm_parts_to_targets(const double parts[NQM_LABEL_PARTS], double min_structure, double targets[NQM_LABEL_PARTS]);
/** Why the arrays of a transport matrix cannot be used; NULL: they can, or both are NULL. verify: false does not read
 *  `light`. */
const char *nqm_transport_fault(const nqm_transport *transport, bool verify);
/** The same of `points` alone. */
const char *nqm_transport_points_fault(const nqm_picture_points *points);
/** The transport matrix of a model; `light` is NULL if it has none. */
static inline nqm_transport nqm_model_transport(const struct nqm_model *model) {
    return (nqm_transport){model->n_transport, model->transport, {model->n_points, model->transport_points}};
}
static inline nqm_slope_light nqm_model_slope_light(const struct nqm_model *model) {
    return (nqm_slope_light){model->slopes, model->slope_wo, {model->n_slope_points, model->slope_points}};
}
/** Make a model without a network, which the caller completes: its light, by slopes or a transport matrix at the directions
 *  nqm_node_grid_directions(), is 0. It has no golden scores. NQM_ERR_NOMEM. */
NQM_MUST_CHECK nqm_status nqm_model_of_light(const char *id, bool by_slopes, size_t n_points, nqm_model **model_ret,
                                             nqm_error *err);
/** Give a model that is not shared yet a copy of a transport matrix. NQM_ERR_NOMEM. */
NQM_MUST_CHECK nqm_status nqm_model_set_transport(nqm_model *model, const nqm_transport *transport, nqm_error *err);
/** What the outputs of models with a transport matrix are added to: log(Delta-E) and the targets of the parts of the estimated
 *  label, with Delta-E and structure raised to 0.05. NULL, of models without a matrix: 0. */
void nqm_estimate_targets(const nqm_label *estimate, double targets[1 + NQM_LABEL_PARTS]);
/** The parts of a label for the raw outputs z (n_outputs) of a model with parts; delta_e is the first output's. */
nqm_label nqm_model_label(const struct nqm_model *model, const float *z, const nqm_label *estimate);
/** JOD for the network's raw output z; *delta_e_ret (NULL allowed) receives the predicted Delta-E (NaN: none). */
double nqm_model_jod(const struct nqm_model *model, double z, const nqm_label *estimate, double *delta_e_ret);

/** The derivatives of that JOD, or of the Delta-E, by z and by the estimate's Delta-E; 0 where Delta-E is raised to the least. */
void nqm_model_slopes(const struct nqm_model *model, double z, const nqm_label *estimate, bool of_jod, double *by_z,
                      double *by_delta_e);
/** Add the gradient of sum_k weights_k targets_k (1 + NQM_LABEL_PARTS), over nqm_estimate_targets(), by the estimate. */
void nqm_estimate_gradient(const nqm_label *estimate, const double *weights, nqm_label *gradient);

/** The names of all scalar features, separated by commas, as stored in model files; NULL when out of memory. Free with
 *  nqm_free(). */
char *nqm_scalar_names(void);

/** Set n and feature of a whitening from names like these; NULL: all features in their order. NQM_ERR_MODEL names a feature that
 *  there is not, or that occurs twice. */
NQM_MUST_CHECK nqm_status nqm_scalars_select(const char *names, nqm_scalar_whitening *whitening, nqm_error *err);

/** x (n of the whitening) receives the inputs from all scalars (NQM_SCALAR_COUNT); features that are NaN become 0. */
void nqm_scalars_whiten(const nqm_scalar_whitening *whitening, const double *scalars, float *x);
/** The gradient (NQM_SCALAR_COUNT) of sum dx x by the scalar features; 0 for NaN and outside the range of the inputs. */
void nqm_scalars_whiten_back(const nqm_scalar_whitening *whitening, const double *scalars, const float *dx,
                             double *gradient);

/** The 95 % interval around a predicted JOD (see nqm_score_result); NaN if the model has no calibration. It widens with
 *  `novelty`, from nqm_model_novelty(); NaN counts as 1, and models without novelty data ignore it; and by the factor
 *  exp(`spread`), from nqm_model_spread(); its half-widths are at least interval_floor. */
void nqm_model_interval(const nqm_model *model, double jod, double novelty, double spread, double *low_ret,
                        double *high_ret);
/** The novelty of a pair (see nqm_score_result); NaN if the model has no novelty data. scalars: (NQM_SCALAR_COUNT) from
 *  nqm_scalars_compute(). */
double nqm_model_novelty(const nqm_model *model, const double *scalars);
/** The features in which novelty is a distance: scalar features, whitened and mapped. y: (scalars.n). */
void nqm_novelty_features(const nqm_model *model, const double *scalars, float *y);

/** The packed network of a model, created by the first call; owned by the model. Any thread. */
NQM_MUST_CHECK nqm_status nqm_model_inference(const nqm_model *model, const nqm_inference_net **net_ret,
                                              nqm_error *err);

/** A built-in model by name: "default"; libnqm-full also has "paper". NQM_ERR_MODEL when no built-in model has the name. */
NQM_MUST_CHECK nqm_status nqm_model_builtin(const char *name, nqm_model **model_ret, nqm_error *err);

#endif
