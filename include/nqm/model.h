/* SPDX-License-Identifier: MIT
 *
 * nqm/model.h - trained models: loading, saving, and facts about them.
 */
#ifndef NQM_MODEL_H
#define NQM_MODEL_H

#include <nqm/samples.h>

#ifdef __cplusplus
extern "C" {
#endif

/** The quantity that the network predicts. */
typedef enum nqm_target {
    NQM_TARGET_JOD = 0,    /**< JOD, z-scored; sigmoid over the range of the training labels (the paper) */
    NQM_TARGET_LOG_DELTA_E /**< natural log of Delta-E ITP, z-scored; sigmoid over its range; mapped to JOD by the curve
                            */
} nqm_target;

/** Zones of theta_h in the scalar features: 0-2, 2-5, 5-15, 15-35, 35-90 degrees. */
enum { NQM_SCALAR_ZONES = 5 };
/** Scalar features of a pair, which follow the samples in the input of models of the recipe "nqm". Differences are test
 *  minus reference; a "size" is the logarithm of a magnitude, which resolves small differences. doc/training.md has the
 *  formulas. */
typedef enum nqm_scalar {
    NQM_SCALAR_METRICS = 0, /**< log of the nine metrics up to NQM_METRIC_LOG_DIFF, in their order */
    NQM_SCALAR_RMS = 9,     /**< size: RMS difference of log(f_r + 0.003) */
    NQM_SCALAR_MAX,         /**< size: largest difference of log luminance */
    NQM_SCALAR_TAIL,        /**< size: its 4-norm */
    NQM_SCALAR_BULK,        /**< size: its 1/2-norm */
    NQM_SCALAR_BIAS,        /**< its mean, with sign */
    NQM_SCALAR_SHAPE,       /**< size: its standard deviation */
    NQM_SCALAR_ZONE_BIAS,   /**< log ratio of the luminance summed over each zone */
    NQM_SCALAR_ZONE_RMS = NQM_SCALAR_ZONE_BIAS + NQM_SCALAR_ZONES,    /**< size: RMS in each zone */
    NQM_SCALAR_GRAZING_BIAS = NQM_SCALAR_ZONE_RMS + NQM_SCALAR_ZONES, /**< mean where cos cos < 0.25 */
    NQM_SCALAR_GRAZING_RMS,                                           /**< size: RMS there */
    NQM_SCALAR_WIDTH,         /**< log ratio below 5 degrees minus that above: positive for sharper highlights */
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
    NQM_SCALAR_REF_PEAK,      /**< reference: log of the largest luminance, minus the mean log */
    NQM_SCALAR_REF_SPREAD,    /**< reference: standard deviation of log luminance */
    NQM_SCALAR_REF_COLOUR,    /**< reference: RMS of the opponents of log f_r */
    NQM_SCALAR_ESTIMATE, /**< the label estimated by light transport: log(Delta-E raised to 0.05); asinh of the shift of I, T,
                                   P and of 30 times contrast; log(structure raised to 0.05); 0 without a transport matrix */
    NQM_SCALAR_COUNT = NQM_SCALAR_ESTIMATE + 6
} nqm_scalar;

/** A trained network with everything it needs: directions, whitening, output range, card. */
typedef struct nqm_model nqm_model;

/** Facts about a model; its strings and arrays belong to the model. */
typedef struct nqm_model_info {
    const char *id;              /**< "default", "paper", or as given when trained */
    const char *recipe;          /**< "paper", "notebook", "nqm" */
    const char *sha256;          /**< 64 hex digits: the checksum of the model file */
    const char *card;            /**< the model card, Markdown: training data, evaluation, limits */
    const char *licence;         /**< SPDX */
    const char *manifest_sha256; /**< hash of the training dataset file; "" if unknown */
    size_t n_parameters;         /**< trained values (weights, biases, LayerNorm) */
    size_t n_layers;             /**< linear layers */
    const size_t *layer_sizes;   /**< (n_layers + 1) widths, input first */
    double jod_min, jod_max;     /**< the range that the output can take */
    const nqm_directions *directions;
    const char *
        calibration; /**< JSON: what the intervals were calibrated on and cover (doc/model-format.md); "": no intervals */
    /* The interval of a predicted JOD Q, with y(Q) = ln((Q + 0.001) / (10.001 - Q)): y(Q) - w d(Q) to y(Q) + w u(Q), where d and u
     * are from a table, and w = exp(g v + a ln(1 + |y(Q) - y(E)| / 0.1) + b max(0, P - 8) / 10), with the novelty v, the JOD E
     * estimated by light transport, the scalar feature P = ref_peak and the growths g, a, b >= 0. Both half-widths are at least
     * 1.96 standard errors of labels near Q. doc/evaluation.md says how all are fitted. */
} nqm_model_info;

/** A built-in model by name ("default"; libnqm-full also has "paper"), or a model file (safetensors; doc/model-format.md), whose
 *  names, shapes, finiteness and SHA-256 are checked. NQM_ERR_IO (also: neither a model nor a file), NQM_ERR_FORMAT (not safetensors),
 *  NQM_ERR_MODEL (checksum, tensors), NQM_ERR_NOMEM. */
NQM_API NQM_MUST_CHECK nqm_status nqm_model_load(const char *name_or_path, nqm_model **model_ret, nqm_error *err);
/** Write a model file, which appears under its name only when it is complete; a file of that name is replaced.
 *  NQM_ERR_IO, NQM_ERR_NOMEM. */
NQM_API NQM_MUST_CHECK nqm_status nqm_model_save(const nqm_model *model, const char *path, nqm_error *err);
/** The name of built-in model i, NULL after the last. */
NQM_API const char *nqm_model_builtin_name(size_t i);
/** Free a model; NULL is allowed. */
NQM_API void nqm_model_free(nqm_model *model);
/** Facts about `model`. */
NQM_API nqm_model_info nqm_model_get_info(const nqm_model *model);

#ifdef __cplusplus
}
#endif
#endif
