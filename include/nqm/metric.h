/* SPDX-License-Identifier: MIT
 *
 * nqm/metric.h - models, and the score of a pair: JOD from the network, and the scalar BRDF-space metrics beside it.
 *
 * JOD (just-objectionable differences) here run from 0 (nothing alike) to 10 (no visible difference); one JOD less
 * means that 75 % of people would notice that the quality is worse.
 */
#ifndef NQM_METRIC_H
#define NQM_METRIC_H

#include <nqm/samples.h>

#ifdef __cplusplus
extern "C" {
#endif

/** A trained network with everything it needs: directions, whitening, output range, card. */
typedef struct nqm_model nqm_model;

/** Facts about a model; strings are lent by it. */
typedef struct nqm_model_info {
    const char *id;                             /**< "default", "paper", or as given when trained */
    const char *recipe;                         /**< "paper", "notebook", "nqm" */
    const char *sha256;                         /**< 64 hex digits: the checksum of the model file */
    const char *card;                           /**< the model card, Markdown: trained on, judged on, not good for */
    const char *licence;                        /**< SPDX */
    const char *manifest_sha256;                /**< hash of the training dataset file; "" if unknown */
    size_t n_parameters;                        /**< trained numbers (weights, biases, LayerNorm) */
    size_t n_layers;                            /**< linear layers */
    const size_t *layer_sizes;                  /**< (n_layers + 1) widths, input first */
    double jod_min, jod_max;                    /**< the range that the output can take */
    double whitening_mean[3], whitening_std[3]; /**< of log(cbrt(f_r) + 1), R G B */
    double target_mean, target_std;             /**< of the training targets: JOD, or log Delta-E ITP */
    const nqm_directions *directions;
    const char
        *calibration; /**< JSON: what the intervals were calibrated on and cover (doc/files.md); "": no intervals */
} nqm_model_info;

/** Load a model file (safetensors; doc/files.md). Checks names, shapes, finiteness and the SHA-256.
 *  NQM_ERR_IO, NQM_ERR_FORMAT (not safetensors), NQM_ERR_MODEL (checksum, tensors), NQM_ERR_NOMEM. */
NQM_API NQM_MUST_CHECK nqm_status nqm_model_load(const char *path, nqm_model **model_ret, nqm_error *err);
/** A built-in model by name ("default", "paper"); NQM_ERR_MODEL when there is none of that name. */
NQM_API NQM_MUST_CHECK nqm_status nqm_model_builtin(const char *name, nqm_model **model_ret, nqm_error *err);
/** Built-in models: how many, and the name of the i-th. */
NQM_API size_t nqm_model_builtin_count(void);
NQM_API const char *nqm_model_builtin_name(size_t i);
/** Free a model; NULL is allowed. */
NQM_API void nqm_model_free(nqm_model *model);
/** Facts about `model`. */
NQM_API nqm_model_info nqm_model_get_info(const nqm_model *model);
/** The 95 % interval around a predicted JOD, as nqm_score_result has it; NaN if the model file holds no calibration. It
 *  widens with `novelty`, of nqm_model_novelty(); NaN counts as 1, and models without that measure do not look at it. */
NQM_API void nqm_model_interval(const nqm_model *model, double jod, double novelty, double *low_ret, double *high_ret);
/**
 * How unlike the training pairs a pair is, as nqm_score_result has it; NaN if the model file has no such measure.
 *
 * @param scalars  (NQM_SCALAR_COUNT) of nqm_scalars_compute()
 */
NQM_API double nqm_model_novelty(const nqm_model *model, const double *scalars);

/** What the network's products are computed in. Everything else - sums, LayerNorm, GELU, the output - is float or double. */
typedef enum nqm_precision {
    NQM_PRECISION_F32 = 0, /**< float: the reference, and what JODs are quoted in */
    NQM_PRECISION_BF16,    /**< factors rounded to bfloat16 (8 bits), to nearest even */
    NQM_PRECISION_INT8, /**< weights in signed bytes with a scale for each output, activations in bytes with a scale for
                                each row; scoring only */
    NQM_PRECISION_COUNT
} nqm_precision;
/** "f32", "bf16", "int8"; static storage; NULL beyond. */
NQM_API const char *nqm_precision_name(nqm_precision precision);
/** The i-th way to compute ("avx512+bf16", "avx512", "avx2", "generic", "scalar") that this processor knows, best first;
 *  static storage; NULL beyond. "scalar" is plain loops, slow, and the definition of the results. */
NQM_API const char *nqm_kernels_name(size_t i);
/** Choose one of them for the whole process, for tests and benchmarks; NULL: back to the best. NQM_ERR_ARG when this
 *  processor does not know it. Not while another thread computes. */
NQM_API NQM_MUST_CHECK nqm_status nqm_kernels_select(const char *name, nqm_error *err);
/** The one in use. */
NQM_API const char *nqm_kernels_selected(void);

/** The scalar metrics, on the samples of both BRDFs: means over directions and channels;
 *  c = cos(theta_i) cos(theta_o). */
typedef enum nqm_metric {
    NQM_METRIC_RMSE = 0,  /**< root mean square difference of f_r */
    NQM_METRIC_MAE,       /**< mean absolute difference of f_r */
    NQM_METRIC_RMS_CRWE,  /**< RMS difference of cbrt(c f_r) */
    NQM_METRIC_MA_CRWE,   /**< mean absolute difference of the same */
    NQM_METRIC_RMS_LOGE,  /**< RMS difference of log(1 + f_r) */
    NQM_METRIC_MA_LOGE,   /**< mean absolute difference of the same */
    NQM_METRIC_RMS_LOGWE, /**< RMS difference of log(1 + c f_r) */
    NQM_METRIC_MA_LOGWE,  /**< mean absolute difference of the same */
    NQM_METRIC_LOG_DIFF,  /**< mean absolute difference of log(f_r + 0.003): not of the paper; the best simple one */
    NQM_METRIC_COUNT
} nqm_metric;
enum { NQM_METRIC_BASELINE_COUNT = 8 }; /**< the first eight are the paper's baselines */

/** "rmse", "mae", "rms_crwe", "ma_crwe", "rms_loge", "ma_loge", "rms_logwe", "ma_logwe", "log_diff"; static storage. */
NQM_API const char *nqm_metric_name(nqm_metric metric);

/** Options of nqm_score(). */
typedef struct nqm_score_options {
    nqm_invalid_policy invalid; /**< default NQM_INVALID_DROP */
    double min_valid_fraction;  /**< a pair with fewer directions at which both hold a value is refused, under every
                                     policy: NQM_ERR_INCOMPATIBLE in its result; 0..1; default 0.9 */
    nqm_precision precision; /**< default NQM_PRECISION_F32; doc/performance.md says what the others cost in accuracy */
} nqm_score_options;

/** The defaults above. */
NQM_API nqm_score_options nqm_score_options_default(void);

/** The score of one test. */
typedef struct nqm_score_result {
    nqm_status status;        /**< NQM_OK, or why this test has no score (all numbers are NaN then) */
    double jod;               /**< predicted quality, jod_min..jod_max of the model */
    double delta_e;           /**< the Delta-E ITP that the JOD stands for; NaN if the model does not predict one */
    double jod_low, jod_high; /**< the interval in which the JOD of rendered images lies for 95 % of pairs of materials
                                   that the model has not seen, with kinds of distortion that it has (doc/evaluation.md
                                   has the measured shares); NaN if the model file holds no calibration; 10 and 10 when
                                   `identical` */
    double novelty;           /**< how unlike the training pairs this one is: distance of the scalar features from the
                                   nearest; 1: as far as the farthest 5 % of pairs of new materials with kinds of distortion
                                   that occur in training; the interval widens with it; NaN if the model cannot tell */
    int identical;            /**< 1 when both are equal at every valid direction */
    double metrics[NQM_METRIC_COUNT];
    size_t n_valid;                       /**< directions at which both BRDFs hold a value */
    size_t n_clamped_ref, n_clamped_test; /**< directions with a negative channel, taken as 0 */
    size_t n_invalid_ref, n_invalid_test; /**< directions without a value, filled as the policy says */
    size_t n_unusual_ref, n_unusual_test; /**< directions at which it is brighter than the training references by more
                                               than 6 standard deviations of the transformed values: extrapolation */
} nqm_score_result;

/**
 * Score n_tests approximations against one reference. The reference is sampled once. A result does not depend on the tests
 * beside it.
 *
 * @param tests    (n_tests)
 * @param options  NULL: the defaults
 * @param results  (n_tests) receives a result each
 * @return the first failure that concerns the reference or the model; faults of single tests stand in their result
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_score(const nqm_model *model, const nqm_brdf *ref, size_t n_tests,
                                            const nqm_brdf *const *tests, const nqm_score_options *options,
                                            nqm_score_result *results, nqm_error *err);

/** The memory of nqm_score() for many calls, which then allocate nothing themselves (only the policy NQM_INVALID_NEAREST
 *  does, for BRDFs with holes). What the last reference adds to the network's first layer is kept: the next tests of the
 *  same one are quicker. Belongs to one thread at a time; works on all of them. */
typedef struct nqm_scorer nqm_scorer;

/**
 * @param model      lent; must outlive the scorer
 * @param options    NULL: the defaults
 * @param max_batch  tests that are scored together, >= 1; more than 512 are scored by 512
 * @return NQM_ERR_ARG, NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_scorer_create(const nqm_model *model, const nqm_score_options *options,
                                                    size_t max_batch, nqm_scorer **scorer_ret, nqm_error *err);
/** Free it; NULL is allowed. */
NQM_API void nqm_scorer_free(nqm_scorer *scorer);
/** As nqm_score(), with any number of tests. */
NQM_API NQM_MUST_CHECK nqm_status nqm_scorer_run(nqm_scorer *scorer, const nqm_brdf *ref, size_t n_tests,
                                                 const nqm_brdf *const *tests, nqm_score_result *results,
                                                 nqm_error *err);

/**
 * JOD of n_pairs of pairs that are sampled already, at the model's own directions.
 *
 * @param ref, test  (n_pairs, n_directions, 3) f_r in 1/sr, >= 0
 * @param jod        (n_pairs) receives the prediction
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_model_predict(const nqm_model *model, size_t n_pairs, const float *ref,
                                                    const float *test, double *jod, nqm_error *err);

/**
 * The scalar metrics of one sampled pair.
 *
 * @param ref, test  (n, 3) f_r at `directions`
 * @param used       (n) nonzero where the direction counts; NULL: all
 * @param metrics    (NQM_METRIC_COUNT) receives them; NaN when no direction counts
 */
NQM_API void nqm_metrics_compute(const nqm_directions *directions, const float *ref, const float *test,
                                 const uint8_t *used, double *metrics);

/** Zones of theta_h in the scalar features: 0-2, 2-5, 5-15, 15-35, 35-90 degrees. */
enum { NQM_SCALAR_ZONES = 5 };
/** Scalar features of a pair, which stand beside the samples in the input of models of the recipe "nqm". Differences
 *  are test less reference; sizes are logarithms, so that faint differences are told apart. doc/training.md has the
 *  formulas. */
typedef enum nqm_scalar {
    NQM_SCALAR_METRICS = 0,            /**< log of the nine metrics, in their order */
    NQM_SCALAR_RMS = NQM_METRIC_COUNT, /**< size: RMS difference of log(f_r + 0.003) */
    NQM_SCALAR_MAX,                    /**< size: largest difference of log luminance */
    NQM_SCALAR_TAIL,                   /**< size: its 4-norm */
    NQM_SCALAR_BULK,                   /**< size: its 1/2-norm */
    NQM_SCALAR_BIAS,                   /**< its mean, with sign */
    NQM_SCALAR_SHAPE,                  /**< size: its standard deviation */
    NQM_SCALAR_ZONE_BIAS,              /**< log ratio of the luminance summed over each zone */
    NQM_SCALAR_ZONE_RMS = NQM_SCALAR_ZONE_BIAS + NQM_SCALAR_ZONES,    /**< size: RMS in each zone */
    NQM_SCALAR_GRAZING_BIAS = NQM_SCALAR_ZONE_RMS + NQM_SCALAR_ZONES, /**< mean where cos cos < 0.25 */
    NQM_SCALAR_GRAZING_RMS,                                           /**< size: RMS there */
    NQM_SCALAR_WIDTH,         /**< log ratio below 5 degrees less that above: sharper highlights are positive */
    NQM_SCALAR_CHROMA,        /**< size: RMS of the differences of the opponents of log f_r */
    NQM_SCALAR_CHROMA_RG,     /**< mean difference of log R - log G */
    NQM_SCALAR_CHROMA_B,      /**< mean difference of log B - (log R + log G) / 2 */
    NQM_SCALAR_ENERGY,        /**< log ratio of the cosine-weighted sums of luminance */
    NQM_SCALAR_ENERGY_CHROMA, /**< size: how the opponents of these sums differ */
    NQM_SCALAR_PEAK,          /**< log ratio of the largest luminance */
    NQM_SCALAR_SMOOTH,        /**< size: RMS over zones of (theta_h, theta_d) of the log ratio of their sums */
    NQM_SCALAR_SMOOTH_CHROMA, /**< size: the same of the opponents */
    NQM_SCALAR_REF_LEVEL,     /**< reference: mean log luminance */
    NQM_SCALAR_REF_ENERGY,    /**< reference: log of the cosine-weighted mean luminance */
    NQM_SCALAR_REF_PEAK,      /**< reference: log of the largest luminance, less the mean log */
    NQM_SCALAR_REF_SPREAD,    /**< reference: standard deviation of log luminance */
    NQM_SCALAR_REF_COLOUR,    /**< reference: RMS of the opponents of log f_r */
    NQM_SCALAR_COUNT
} nqm_scalar;

/** "log_rmse", ..., "ref_colour"; static storage; NULL for an i that is too large. */
NQM_API const char *nqm_scalar_name(size_t i);

/**
 * The scalar features of one sampled pair; arguments as in nqm_metrics_compute(). Finite for finite f_r >= 0.
 *
 * @param scalars  (NQM_SCALAR_COUNT) receives them; NaN when no direction counts
 */
NQM_API void nqm_scalars_compute(const nqm_directions *directions, const float *ref, const float *test,
                                 const uint8_t *used, double *scalars);

/** Check kernels, coordinates, curve and the built-in models against stored golden values (about a second).
 *  `report` (NULL allowed) gets one line for each check. Returns NQM_ERR_NUMERIC when one fails. */
NQM_API NQM_MUST_CHECK nqm_status nqm_selftest(void (*report)(void *user, const char *name, int passed), void *user,
                                               nqm_error *err);

#ifdef __cplusplus
}
#endif
#endif
