/* SPDX-License-Identifier: MIT
 *
 * nqm/metric.h - the score of a pair: JOD from the network, and the scalar BRDF-space metrics beside it; scores of many
 * pairs that are named by files, specs and presets.
 *
 * JOD (just-objectionable differences) here run from 0 (nothing alike) to 10 (no visible difference); one JOD less
 * means that 75 % of people would notice that the quality is worse.
 */
#ifndef NQM_METRIC_H
#define NQM_METRIC_H

#include <nqm/model.h>

#ifdef __cplusplus
extern "C" {
#endif

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

/**
 * The scalar features of one sampled pair; arguments as in nqm_metrics_compute(). Finite for finite f_r >= 0.
 *
 * @param scalars  (NQM_SCALAR_COUNT) receives them; NaN when no direction counts
 */
NQM_API void nqm_scalars_compute(const nqm_directions *directions, const float *ref, const float *test,
                                 const uint8_t *used, double *scalars);

/** Two BRDFs, as nqm_brdf_open() takes them. */
typedef struct nqm_named_pair {
    const char *ref, *test;
} nqm_named_pair;

/* ---- scores ------------------------------------------------------------------------------------------------------ */

/** Options of nqm_batch_create(). */
typedef struct nqm_batch_options {
    nqm_score_options score; /**< default nqm_score_options_default() */
    int metrics;             /**< 0: leave the scalar metrics out (NaN), which is quicker; default 1 */
    size_t cache_bytes;      /**< sampled BRDFs are kept up to this much memory, those used last longest; the BRDFs of
                                  one block of pairs are kept whatever this says; default 64 MiB (10,000 BRDFs) */
} nqm_batch_options;

/** The defaults above. */
NQM_API nqm_batch_options nqm_batch_options_default(void);

/** A model with the BRDFs that were sampled last. Belongs to one thread at a time; works on all of them. */
typedef struct nqm_batch nqm_batch;

enum { NQM_BATCH_BLOCK = 256 }; /**< pairs that are scored together */

/** `model` is lent and must outlive the batch. options NULL: the defaults. NQM_ERR_ARG, NQM_ERR_NOMEM. */
NQM_API NQM_MUST_CHECK nqm_status nqm_batch_create(const nqm_model *model, const nqm_batch_options *options,
                                                   nqm_batch **batch_ret, nqm_error *err);
/** Free it; NULL is allowed. */
NQM_API void nqm_batch_free(nqm_batch *batch);

/**
 * Score pairs, in blocks of NQM_BATCH_BLOCK. A result depends on its pair and on nothing else. Pairs of one reference in
 * a block are quicker.
 *
 * @param pairs    (n_pairs)
 * @param results  (n_pairs) receives a result each; status is not NQM_OK where the pair has no score
 * @param errors   (n_pairs) receives why; NULL allowed
 * @return faults that concern all pairs: NQM_ERR_NOMEM. A BRDF that cannot be opened or sampled is a fault of its pairs.
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_batch_score(nqm_batch *batch, size_t n_pairs, const nqm_named_pair *pairs,
                                                  nqm_score_result *results, nqm_error *errors, nqm_error *err);

/** How many BRDFs were opened so far, with those that failed; each counts again when it had been dropped meanwhile. */
NQM_API size_t nqm_batch_n_opened(const nqm_batch *batch);

/**
 * The share of people who prefer the better of two to the worse, as the JOD scale is made (Thurstone's model, case V,
 * with one JOD at 75 %: Perez-Ortiz and Mantiuk 2017, arXiv:1712.03686, section 2): Phi(0.6745 (jod - other_jod)), with
 * Phi the normal distribution function. 0.5 for equal scores; below it when `other_jod` is larger.
 */
NQM_API double nqm_jod_preference(double jod, double other_jod);

/** Check kernels, coordinates, curve and the built-in models against stored golden values (about a second).
 *  `report` (NULL allowed) gets one line for each check. Returns NQM_ERR_NUMERIC when one fails. */
NQM_API NQM_MUST_CHECK nqm_status nqm_selftest(void (*report)(void *user, const char *name, int passed), void *user,
                                               nqm_error *err);

#ifdef __cplusplus
}
#endif
#endif
