/* SPDX-License-Identifier: MIT
 *
 * nqm/metric.h - scores of pairs of BRDFs: JOD from a model, with its interval and warnings, and scalar metrics.
 *
 * JOD (just-objectionable differences) here run from 0 (nothing in common) to 10 (no visible difference); one JOD less
 * means that 75 % of people would notice that the quality is worse.
 */
#ifndef NQM_METRIC_H
#define NQM_METRIC_H

#include <nqm/model.h>
#include <nqm/percept.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- scalar metrics ---------------------------------------------------------------------------------------------- */

/** The scalar metrics: distances between the samples of two BRDFs, 0 for equal ones. Means run over directions and
 *  channels; c = cos(theta_i) cos(theta_o). The first eight are the paper's baselines (section 4). */
typedef enum nqm_metric {
    NQM_METRIC_RMSE = 0,  /**< root mean square difference of f_r, 1/sr */
    NQM_METRIC_MAE,       /**< mean absolute difference of f_r, 1/sr */
    NQM_METRIC_RMS_CRWE,  /**< root mean square difference of cbrt(c f_r) */
    NQM_METRIC_MA_CRWE,   /**< mean absolute difference of cbrt(c f_r) */
    NQM_METRIC_RMS_LOGE,  /**< root mean square difference of log(1 + f_r) */
    NQM_METRIC_MA_LOGE,   /**< mean absolute difference of log(1 + f_r) */
    NQM_METRIC_RMS_LOGWE, /**< root mean square difference of log(1 + c f_r) */
    NQM_METRIC_MA_LOGWE,  /**< mean absolute difference of log(1 + c f_r) */
    NQM_METRIC_LOG_DIFF,  /**< mean absolute difference of log(f_r + 0.003): not from the paper */
    NQM_METRIC_COUNT
} nqm_metric;

/** Facts about a scalar metric; strings have static storage. */
typedef struct nqm_metric_info {
    const char *name;        /**< "rmse", "mae", "rms_crwe", ..., "log_diff" */
    const char *description; /**< "root mean square difference of f", UTF-8; f: f_r in 1/sr, c: as above */
    const char *family;      /**< compared quantity; equal for its RMS and its mean absolute difference */
    int is_baseline;         /**< 1: one of the paper's baselines */
} nqm_metric_info;

/** Facts about `metric`, 0 <= metric < NQM_METRIC_COUNT. Any thread. */
NQM_API nqm_metric_info nqm_metric_get_info(nqm_metric metric);

/* ---- scores ------------------------------------------------------------------------------------------------------ */

/** Options of nqm_score() and nqm_scorer_create(). Take the defaults from nqm_score_options_default(). */
typedef struct nqm_score_options {
    nqm_invalid_policy invalid; /**< what happens where a BRDF has no value; default NQM_INVALID_DROP */
    double
        min_valid_fraction; /**< a pair gets NQM_ERR_INCOMPATIBLE, under every policy, when both BRDFs have a value at
                                     a smaller fraction of the directions; 0..1; default 0.9 */
    int metrics;            /**< 0: leave out the scalar metrics (they are NaN), which is faster; default 1 */
    size_t cache_bytes; /**< nqm_scorer_run_named() keeps the last used sampled BRDFs up to this size, and always those
                             of the current block of pairs; bytes; default 64 MiB (about 10,000 BRDFs) */
} nqm_score_options;

/** The defaults above. */
NQM_API nqm_score_options nqm_score_options_default(void);

/** The score of one pair. */
enum { NQM_REMARK_TEXT = 256 };

typedef struct nqm_score_result {
    nqm_status status;        /**< NQM_OK; otherwise the pair has no score and all floating-point members are NaN */
    double jod;               /**< predicted quality, jod_min..jod_max of the model */
    double delta_e;           /**< the Delta-E ITP that has this JOD; NaN if the model does not predict one */
    double jod_low, jod_high; /**< 95 % interval: contains the JOD of rendered images for 95 % of the pairs of materials
                                   that the model has not seen, with kinds of distortion that it has seen
                                   (doc/evaluation.md has measured coverage); NaN if the model has no calibration; 10 and
                                   10 when `identical` and the model has one */
    double novelty;  /**< distance of the pair's scalar features from the nearest training pair, >= 0; 1: that of
                                   the farthest 5 % of pairs of new materials with kinds of distortion that occur in
                                   training; the interval widens with it; NaN if the model has no such measure */
    nqm_label parts; /**< predicted parts of the label (doc/labels.md); NaN if the model does not predict them; 0 when
                                   `identical` */
    double similarity[3]; /**< how similar people find the materials when they see them apart, JOD, and both ends of
                               its 95 % interval over the materials of its fit (doc/people.md); symmetric; without
                               the network; NaN without a transport matrix */
    double
        anisotropy; /**< of the more anisotropic of both BRDFs (nqm_brdf_check_report); 0: both are isotropic. Above it,
                               the models "default" and "transport" take the score of "anisotropic", at 0.02 alone, and
                               below in part; other models whose directions have one azimuth give NQM_ERR_INCOMPATIBLE.
                               Not of samples */
    int identical;  /**< 1: both members are equal at every valid direction */
    double metrics[NQM_METRIC_COUNT]; /**< indexed by nqm_metric, within 1e-6 relative of
                                               nqm_metrics_compute(); NaN when the options leave them out */
    size_t n_valid;                   /**< directions at which both BRDFs have a value */
    size_t n_clamped[2]; /**< of reference and test: directions with a negative channel, which counts as 0 */
    size_t n_invalid[2]; /**< the same: directions without a value, before the policy */
    size_t n_unusual[2]; /**< the same: directions at which a channel exceeds the training references' mean by more than
                              6 standard deviations, on the network's scale */
    /* What may make the score wrong, of nqm_scorer_run() and nqm_scorer_run_named(): */
    char remark[2][NQM_REMARK_TEXT]; /**< of reference and test: nqm_brdf_info.remark, as far as it fits; "": none */
    double
        distance_deg[2]; /**< of a reference that is a list of measured directions, with or without a score: median and
                                 95 % of the angles between the model's directions and the nearest row; else 0 */
    double
        suspect_scale; /**< JOD below 9, and the test is about this factor (> 100 or < 1/100; or pi or 1/pi, at nearly all) times the
                                 reference at most directions: is a scale missing? 0: no such suspicion */
    double
        suspect_cosine; /**< the same with a cosine: 1: the test has it in addition, -1: it lacks it, 0: no suspicion */
} nqm_score_result;

/**
 * Score n_tests approximations of one reference: nqm_scorer_create(), nqm_scorer_run() and nqm_scorer_free() in one call.
 *
 * @param tests    (n_tests)
 * @param options  NULL: the defaults
 * @param results  (n_tests) receives one result per test
 * @return as nqm_scorer_create() and nqm_scorer_run()
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_score(const nqm_model *model, const nqm_brdf *ref, size_t n_tests,
                                            const nqm_brdf *const *tests, const nqm_score_options *options,
                                            nqm_score_result *results, nqm_error *err);

/**
 * The workspace of many scores with one model, in three ways: nqm_scorer_run() takes opened BRDFs, nqm_scorer_run_named()
 * paths and specs, nqm_scorer_run_samples() values that the caller sampled. The same pair gets the same result, to the bit,
 * whatever is scored with it or before it, on any number of threads.
 *
 * A scorer is used by one thread at a time; its calls work on all threads of OpenMP. The first call, and a call with more
 * pairs than any before, allocate memory for at most NQM_SCORE_BLOCK pairs. The contribution of the last reference to the
 * network's first layer is kept: further tests of it are faster.
 */
typedef struct nqm_scorer nqm_scorer;

enum { NQM_SCORE_BLOCK = 256 }; /**< pairs that are computed together; longer lists are cut into blocks of this size */

/**
 * Make a scorer.
 *
 * @param model    must outlive the scorer
 * @param options  NULL: the defaults
 * @return NQM_ERR_ARG (an option is out of range), NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_scorer_create(const nqm_model *model, const nqm_score_options *options,
                                                    nqm_scorer **scorer_ret, nqm_error *err);
/** Free a scorer; NULL is allowed. */
NQM_API void nqm_scorer_free(nqm_scorer *scorer);

/**
 * Score tests of one reference, which is sampled once.
 *
 * @param tests    (n_tests) any number
 * @param results  (n_tests) receives one result per test; a test that cannot be sampled or compared is a failure of its
 *                 own result
 * @return NQM_ERR_INCOMPATIBLE: the reference cannot be sampled; NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_scorer_run(nqm_scorer *scorer, const nqm_brdf *ref, size_t n_tests,
                                                 const nqm_brdf *const *tests, nqm_score_result *results,
                                                 nqm_error *err);

/** Two BRDFs by path or spec, as nqm_brdf_open() takes them; the strings are used during the call only. */
typedef struct nqm_named_pair {
    const char *ref, *test;
} nqm_named_pair;

/**
 * Score pairs of BRDFs that are opened and sampled when they are first needed, and kept in a cache (nqm_score_options
 * cache_bytes) for later pairs and calls.
 *
 * @param pairs    (n_pairs) any number; pairs of the same reference in a block are faster
 * @param results  (n_pairs) receives one result per pair; a BRDF that cannot be opened or sampled is a failure of its
 *                 pairs
 * @param errors   (n_pairs) receives the reason of each result's status; NULL allowed
 * @return NQM_ERR_NOMEM: results of the blocks before it are complete
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_scorer_run_named(nqm_scorer *scorer, size_t n_pairs, const nqm_named_pair *pairs,
                                                       nqm_score_result *results, nqm_error *errors, nqm_error *err);

/** Two BRDFs that the caller sampled at the model's directions (nqm_model_get_info(), nqm_directions_get_info()), used
 *  during the call only. Pairs with the same `ref` pointer share its computations. */
typedef struct nqm_sample_pair {
    const float *ref, *test; /**< (n_directions, 3) f_r in 1/sr, finite and >= 0; 0 will do where `used` is 0 */
    const uint8_t *used;     /**< (n_directions) 0: leave the direction out of everything; NULL: all are used */
} nqm_sample_pair;

/**
 * Score pairs that the caller sampled. Counts of clamped and invalid directions are 0: they are not known here.
 *
 * @param pairs    (n_pairs) any number
 * @param results  (n_pairs) receives one result per pair; NQM_ERR_INCOMPATIBLE when too few directions are used
 * @return NQM_ERR_ARG: a value is NaN, infinite or negative; the message names pair, member and direction, and no result is
 *         written; NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_scorer_run_samples(nqm_scorer *scorer, size_t n_pairs,
                                                         const nqm_sample_pair *pairs, nqm_score_result *results,
                                                         nqm_error *err);

/* ---- gradients --------------------------------------------------------------------------------------------------- */

/** What nqm_score_grad() differentiates. */
typedef enum nqm_score_quantity {
    NQM_SCORE_JOD = 0, /**< nqm_score_result.jod */
    NQM_SCORE_DELTA_E  /**< nqm_score_result.delta_e: unlike the JOD of very different BRDFs, it is not flat, so that
                            optimisers prefer it */
} nqm_score_quantity;

/**
 * Scores of sampled pairs and their gradients by the samples of the test, through the network, the scalar features and
 * the estimate by light transport. They are computed in float: components are within 1e-5 of
 * the largest component of a pair's gradient, and values agree with those of nqm_scorer_run_samples() within 0.001 JOD.
 *
 * Where a function has no derivative, the gradient is that of one side, always finite: 0 at equal samples whose
 * magnitude counts, for unused directions, for scalar features and pixels that are clamped; of several equal maxima the
 * first counts; roots of an f_r below 1e-6 1/sr have the derivative at 1e-6; scalar features that are roots of
 * differences have slopes that fall to 0 linearly where log luminances differ by less than 0.003 and root mean squares
 * are below 0.005, so that samples which differ by rounding only have no part; scalar features of luminances from 1e15
 * on have none. Models that predict Delta-E give equal pairs a gradient of 0, and pairs that hardly differ that of the
 * bound on their score, which is 0 except at the sample with the largest ratio.
 *
 * @param pairs      (n_pairs) any number
 * @param values     (n_pairs) receives the scores
 * @param gradients  (n_pairs, n_directions, 3) receives d value / d f_r of the test, in units of the score times sr
 * @return NQM_ERR_ARG: a value is NaN, infinite or negative (see nqm_scorer_run_samples()), or the model predicts no Delta-E;
 *         NQM_ERR_INCOMPATIBLE: too few directions of a pair are used; NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_score_grad(nqm_scorer *scorer, nqm_score_quantity of, size_t n_pairs,
                                                 const nqm_sample_pair *pairs, double *values, float *gradients,
                                                 nqm_error *err);

/* ---- preference and self-test ------------------------------------------------------------------------------------ */

/**
 * The fraction of people who prefer a picture of quality `jod` to one of quality `other_jod` in a direct comparison:
 * Phi(0.6745 (jod - other_jod)) with the standard normal distribution function Phi, 0.5 for equal qualities. This is the
 * definition of the JOD scale (Thurstone's model, case V, with one JOD at 75 %: Perez-Ortiz and Mantiuk 2017,
 * arXiv:1712.03686, section 2). Any thread.
 */
NQM_API double nqm_jod_preference(double jod, double other_jod);

/**
 * Check kernels, coordinates, the JOD curve and the built-in models against stored values; takes about a second.
 *
 * @param report  called after each check with its name and 1 or 0; NULL allowed
 * @return NQM_ERR_NUMERIC: a check failed; the message names the first
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_selftest(void (*report)(void *user, const char *name, int passed), void *user,
                                               nqm_error *err);

#ifdef __cplusplus
}
#endif
#endif
