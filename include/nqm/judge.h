/* SPDX-License-Identifier: MIT
 *
 * nqm/judge.h - how well models and metrics agree with labels and with the answers of people.
 */
#ifndef NQM_JUDGE_H
#define NQM_JUDGE_H

#include <nqm/data.h>
#include <nqm/metric.h>

#ifdef __cplusplus
extern "C" {
#endif

/** How well one predictor agrees with the labels. Correlations are signed so that higher is better. Intervals are NaN
 *  for fewer than 2 materials. */
typedef struct nqm_agreement {
    const char *name;                  /**< the model's id, else nqm_metric_name(); lent */
    size_t n, n_materials;             /**< pairs and material groups that counted */
    double spearman, spearman_ci95[2]; /**< over all pairs */
    double spearman_mean_by_material, spearman_mean_by_material_ci95[2]; /**< mean over groups with >= 3 pairs */
    double pearson, kendall;                                             /**< Kendall's tau-b */
    double mae, rmse, r2; /**< of predicted JOD; NaN for metrics, which have no JOD, and for labels that are none */
    double pearson_ci95[2], kendall_ci95[2], mae_ci95[2], rmse_ci95[2], r2_ci95[2];
    size_t n_ordered;            /**< pairs of tests of one material whose labels differ by more than order_margin */
    double order, order_ci95[2]; /**< share of them that is predicted in the order of the labels; ties count half */
    int best_of_family; /**< 1: the metric has the higher `spearman` of its family (RMSE and MAE, CRWE, LogE, LogWE) */
    int best_baseline;  /**< 1: the highest `spearman` of the paper's eight baselines */
} nqm_agreement;

/** Which pairs to judge on. Take the defaults from nqm_eval_options_default(). */
typedef struct nqm_eval_options {
    nqm_split split;            /**< default NQM_SPLIT_ALL */
    const char *kind;           /**< only this kind of distortion; NULL: all */
    const char *family;         /**< only kinds of this family; NULL: all */
    const char *material_class; /**< only references of this class; NULL: all */
    double jod_from, jod_to;    /**< only labels in [from, to); default 0 and infinity */
    double order_margin;        /**< of nqm_agreement.order, in the unit of the labels; >= 0; default 0.25 */
    size_t n_bootstrap;         /**< resamples of material groups for the 95 % intervals; 0: none (NaN); default 1000 */
    uint64_t seed;              /**< of the resampling; default 1 */
    nqm_precision precision;    /**< that models predict in; default NQM_PRECISION_F32 */
    nqm_progress_fn progress;
    void *progress_user;
} nqm_eval_options;

/** The defaults above. */
NQM_API nqm_eval_options nqm_eval_options_default(void);

/**
 * What models and the nine scalar metrics predict for the pairs of a dataset: made once, judged on as many selections
 * as wanted. Predictors are numbered: the models in their order, then the metrics in the order of nqm_metric.
 */
typedef struct nqm_evaluation nqm_evaluation;

/**
 * Predict all pairs of options->split (the other fields choose among them later).
 *
 * @param dataset, models  lent: they must outlive the evaluation
 * @param options          NULL: the defaults
 * @return NQM_ERR_INCOMPATIBLE when the directions of a model and the dataset differ or no pair is left;
 * NQM_ERR_NUMERIC; NQM_ERR_CANCELLED; NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_evaluation_create(const nqm_dataset *dataset, size_t n_models,
                                                        const nqm_model *const *models, const nqm_eval_options *options,
                                                        nqm_evaluation **evaluation_ret, nqm_error *err);
/** Free an evaluation; NULL is allowed. */
NQM_API void nqm_evaluation_free(nqm_evaluation *evaluation);
/** Number of predictors: n_models + NQM_METRIC_COUNT. */
NQM_API size_t nqm_evaluation_count(const nqm_evaluation *evaluation);
/** Name of predictor i: the model's id or the metric's name; lent. */
NQM_API const char *nqm_evaluation_name(const nqm_evaluation *evaluation, size_t i);
/** (n_pairs of the dataset) what predictor i says: JOD of a model, distance of a metric; NaN for pairs not predicted;
 * lent. */
NQM_API const double *nqm_evaluation_values(const nqm_evaluation *evaluation, size_t i);
/** (NQM_SCALAR_COUNT) the scalar features of a pair; NaN for pairs not predicted; lent. */
NQM_API const double *nqm_evaluation_scalars(const nqm_evaluation *evaluation, size_t pair);

/**
 * Judge every predictor on the pairs that `options` selects. The intervals are percentiles over resamples of the
 * material groups, drawn with replacement, the same resamples for all predictors.
 *
 * @param options  NULL: the defaults
 * @param results  (nqm_evaluation_count()) receives them
 * @return NQM_ERR_INCOMPATIBLE when no pair is left; NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_evaluation_judge(const nqm_evaluation *evaluation,
                                                       const nqm_eval_options *options, nqm_agreement *results,
                                                       nqm_error *err);

/** A difference between two predictors: of the pairs as they are, and over the resamples. */
typedef struct nqm_difference {
    double value, ci95[2];
    double share_below_0; /**< of the resamples: how surely the first is not better; NaN without resamples */
} nqm_difference;

/** Which of two predictors agrees better with the labels. */
typedef struct nqm_contrast {
    size_t first, second;                                      /**< in: predictors by number */
    nqm_difference spearman, spearman_mean_by_material, order; /**< the first less the second */
} nqm_contrast;

/**
 * Compare predictors with each other on the pairs that `options` selects: a paired bootstrap, on the very resamples of
 * the materials from which nqm_evaluation_judge() takes its intervals.
 *
 * @param contrasts  (n_contrasts) `first` and `second` are read, the rest is filled
 * @return as nqm_evaluation_judge(); NQM_ERR_ARG for a number that no predictor has
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_evaluation_contrast(const nqm_evaluation *evaluation,
                                                          const nqm_eval_options *options, size_t n_contrasts,
                                                          nqm_contrast *contrasts, nqm_error *err);

/** Ranges of predicted JOD in which coverage is counted: below 4, 4-8, 8-9.5, 9.5-9.9, 9.9 and more. */
enum { NQM_COVERAGE_RANGES = 5 };
/** Their lower ends: 0 (all that is lower, too), 4, 8, 9.5, 9.9. */
NQM_API double nqm_coverage_range_from(size_t i);

/** How many labels a model's 95 % intervals hold. Shares and widths are NaN where there is no pair, intervals of shares
 *  for fewer than 2 materials. */
typedef struct nqm_coverage {
    size_t n, n_materials;
    double inside, inside_ci95[2];           /**< share of the labels, over all pairs */
    double by_material, by_material_ci95[2]; /**< mean over materials */
    double lowest;                           /**< of the material with the lowest share */
    const char *lowest_material;             /**< its name; lent by the dataset */
    double below, above;                     /**< shares of labels below and above their interval */
    double mean_width;                       /**< JOD */
    size_t range_n[NQM_COVERAGE_RANGES];     /**< pairs by predicted JOD */
    double range_inside[NQM_COVERAGE_RANGES], range_width[NQM_COVERAGE_RANGES];
} nqm_coverage;

/**
 * Count on the pairs that `options` selects, with the resamples of nqm_evaluation_judge().
 *
 * @param model    number of a predictor that is a model with intervals (nqm_model_info.calibration)
 * @param options  NULL: the defaults
 * @return NQM_ERR_ARG: no such model; NQM_ERR_INCOMPATIBLE: no pair is left, or labels are no JOD; NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_evaluation_coverage(const nqm_evaluation *evaluation,
                                                          const nqm_eval_options *options, size_t model,
                                                          nqm_coverage *coverage_ret, nqm_error *err);

/** Both steps for one model: results (1 + NQM_METRIC_COUNT). */
NQM_API NQM_MUST_CHECK nqm_status nqm_evaluate(const nqm_model *model, const nqm_dataset *dataset,
                                               const nqm_eval_options *options, nqm_agreement *results, nqm_error *err);

/* ---- choices of people ----------------------------------------------------------------------------------------------- */

/** How well one predictor meets the choices. */
typedef struct nqm_choice_agreement {
    const char *name;                    /**< as in nqm_agreement */
    double agreement, agreement_ci95[2]; /**< share of the choices for the test that it finds better; ties count half */
    double majority; /**< share of the triplets in which it sides with most people (ties half), without drawn ones */
    int best_of_family, best_baseline; /**< as in nqm_agreement, by `agreement` */
} nqm_choice_agreement;

/**
 * Judge every predictor of an evaluation of nqm_human_dataset() on the choices, with intervals as those of
 * nqm_evaluation_judge() (n_bootstrap and seed of `options`; NULL: the defaults).
 *
 * @param results      (nqm_evaluation_count())
 * @return NQM_ERR_ARG for scores or another dataset; NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_human_judge_choices(const nqm_human *human, const nqm_evaluation *evaluation,
                                                          const nqm_eval_options *options,
                                                          nqm_choice_agreement *results, nqm_error *err);
/** `agreement` of predictor `first` less that of `second`, on the same resamples. */
NQM_API NQM_MUST_CHECK nqm_status nqm_human_contrast_choices(const nqm_human *human, const nqm_evaluation *evaluation,
                                                             const nqm_eval_options *options, size_t first,
                                                             size_t second, nqm_difference *difference_ret,
                                                             nqm_error *err);

#ifdef __cplusplus
}
#endif
#endif
