/* SPDX-License-Identifier: MIT
 *
 * nqm/train.h - datasets of labelled pairs, training a model on them, and judging models and metrics against labels.
 */
#ifndef NQM_TRAIN_H
#define NQM_TRAIN_H

#include <nqm/metric.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Labelled pairs of sampled BRDFs. Immutable once loaded. */
typedef struct nqm_dataset nqm_dataset;

/** Which pairs of a dataset. A reference's material group belongs to one split only. */
typedef enum nqm_split { NQM_SPLIT_TRAIN = 0, NQM_SPLIT_VALIDATION, NQM_SPLIT_TEST, NQM_SPLIT_ALL } nqm_split;

/** Facts about a dataset; strings are lent by it. */
typedef struct nqm_dataset_info {
    size_t n_directions, n_refs, n_groups, n_pairs;
    size_t n_pairs_in[3]; /**< per split, before augmentation */
    const char *sha256;   /**< of the file; of the content for the authors' layout */
    const char *manifest; /**< JSON: how it was made; "" if unknown */
    const nqm_directions *directions;
} nqm_dataset_info;

/** Load nqm's own dataset file (safetensors; doc/files.md). */
NQM_API NQM_MUST_CHECK nqm_status nqm_dataset_load(const char *path, nqm_dataset **dataset_ret, nqm_error *err);

/**
 * Read the authors' layout: a CSV `material,model,level,DeltaE,JOD,class` (`class` is not used) and for each of its
 * rows, whose `material` is NAME, the files ROOT/ref/NAME.mat and ROOT/model/NAME.mat (MAT v5; r, g, b 500x1 and
 * random_locations 500x3 in degrees, the same in all files). NAME is a material and a running number, "brass_12": rows
 * that differ in the number only are one material group; a reference may also be stored once a material, as
 * ROOT/ref/brass.mat. Equal references are kept once. The kinds are the models: "sbrdf" at level 0, "sbrdf.2" at
 * level 2. Negative values count as 0; how many there were stands in the manifest.
 *
 * @param root        the folder
 * @param labels_csv  the CSV
 * @param split       the split that every row gets; NQM_SPLIT_ALL: training rows, split later by the options of
 * training
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_dataset_load_authors(const char *root, const char *labels_csv, nqm_split split,
                                                           nqm_dataset **dataset_ret, nqm_error *err);
/** Free a dataset; NULL is allowed. */
NQM_API void nqm_dataset_free(nqm_dataset *dataset);
/** Facts about `dataset`. */
NQM_API nqm_dataset_info nqm_dataset_get_info(const nqm_dataset *dataset);

/** The kinds of distortion in a dataset: how many, and the i-th ("ggx", "noise"); lent. */
NQM_API size_t nqm_dataset_kind_count(const nqm_dataset *dataset);
NQM_API const char *nqm_dataset_kind_name(const nqm_dataset *dataset, size_t i);
/** The family of the i-th kind; lent. Of corpora of this program: "encoding" (own fits), "published" (published
 *  parameters of the same material), "form" (other forms of the same material), "perturbation", "composed" (two
 *  perturbations, or one over an encoding). Of the authors' layout: "encoding". "" when the dataset does not say. */
NQM_API const char *nqm_dataset_kind_family(const nqm_dataset *dataset, size_t i);

enum { NQM_MATERIAL_CLASS_COUNT = 9 };
/** The i-th class of reference materials: "matte grey", "matte coloured", "satin grey", ..., "mirror-like coloured",
 *  "unclassified"; static storage. Satin, glossy, mirror-like: at theta_h below 3 degrees 3, 20, 200 times as bright (mean
 *  log luminance, theta_d below 60) as at 25 and more. Coloured: there, a channel of the mean f_r is more than exp(0.4)
 *  off the geometric mean of the three. Unclassified: no direction in one of these zones. */
NQM_API const char *nqm_material_class_name(size_t i);

/** One pair; strings are lent by the dataset. */
typedef struct nqm_dataset_pair {
    const char *ref, *group;    /**< the reference and its material group */
    const char *test, *kind;    /**< the test (a spec, or a name) and its kind of distortion */
    const char *family;         /**< of the kind: nqm_dataset_kind_family() */
    const char *material_class; /**< of the reference: a nqm_material_class_name() */
    nqm_split split;
    double delta_e, jod; /**< the label */
} nqm_dataset_pair;

/** Pair i in [0, n_pairs). */
NQM_API nqm_dataset_pair nqm_dataset_get_pair(const nqm_dataset *dataset, size_t i);

/** How the labels become what the network learns. */
typedef enum nqm_target {
    NQM_TARGET_JOD = 0,    /**< JOD, z-scored; sigmoid over the range of the training labels (the paper) */
    NQM_TARGET_LOG_DELTA_E /**< natural log of Delta-E ITP, z-scored; sigmoid over its range; mapped to JOD by the curve
                            */
} nqm_target;

/** How a pair becomes the network's input, after t = log(cbrt(rho) + 1) and whitening. */
typedef enum nqm_layout {
    NQM_LAYOUT_REF_TEST = 0,    /**< reference half, then test half: 6 n numbers (the paper) */
    NQM_LAYOUT_REF_DIFF_ABSDIFF /**< reference, s (test - reference), s |test - reference|: 9 n numbers */
} nqm_layout;

/** How the learning rates fall. */
typedef enum nqm_schedule {
    NQM_SCHEDULE_PLATEAU = 0, /**< by plateau_factor when the validation loss stagnates (the paper) */
    NQM_SCHEDULE_COSINE       /**< half a cosine from the full rates to 0 over all epochs, whatever the losses */
} nqm_schedule;

typedef enum nqm_whitening { NQM_WHITEN_CHANNEL = 0, NQM_WHITEN_SCALAR } nqm_whitening;
typedef enum nqm_scale_copy {
    NQM_SCALE_PAIR_REFLECTANCE = 0, /**< one factor a pair, on f_r (the paper) */
    NQM_SCALE_ELEMENT_TRANSFORMED,  /**< one factor an element, after the transform (the notebook) */
    NQM_SCALE_NONE
} nqm_scale_copy;

enum { NQM_TRAIN_MAX_HIDDEN = 7 };

/** Everything that distinguishes one training from another, from nqm_train_options_recipe(). Strings are lent. */
typedef struct nqm_train_options {
    const char *recipe;                  /**< the name the options came from; stored in the model */
    const char *id;                      /**< model id; default the recipe's name */
    const char *licence;                 /**< SPDX identifier for the model; NULL: not stated */
    nqm_layout layout;                   /**< paper: REF_TEST; nqm: REF_DIFF_ABSDIFF */
    double difference_scale;             /**< s of the layout; paper: unused; nqm: 3 */
    int scalars;                         /**< 1: scalar features (nqm_scalar) behind the samples; nqm: 1, else 0 */
    double scalar_scale;                 /**< times the whitened scalar features; default 1 (nqm: 8) */
    size_t n_hidden;                     /**< hidden layers; 1..NQM_TRAIN_MAX_HIDDEN; default 3 */
    size_t hidden[NQM_TRAIN_MAX_HIDDEN]; /**< their widths; 1..16384; default 1024, 716, 501 */
    nqm_target target;                   /**< paper, notebook: JOD; nqm: LOG_DELTA_E */
    double min_delta_e;      /**< NQM_TARGET_LOG_DELTA_E: smaller ones count as this, which still maps to JOD 10 within
                             1e-7, so that the log of a perfect copy is finite; > 0; default 0.05 */
    nqm_whitening whitening; /**< notebook: SCALAR, else CHANNEL; over the references of the training pairs */
    nqm_scale_copy scale_copy; /**< second copy of the training set scaled by U[0.95, 1.05] */
    int split_by_pair; /**< 1: validation pairs drawn over all pairs that are not test pairs (the paper: one material
                            can be on both sides); 0: by material group (notebook, nqm) */
    double validation_fraction; /**< of the pairs, or of the groups when the dataset brings no validation split; default
                                   0.2 */
    int balance;                /**< 1: fill 7 equal label bins up to the fullest by noisy copies, before the split */
    double balance_sigma;       /**< of the noise, 1/sr, the same draw for both members of a pair; default 0.01 */
    int freeze_first_layernorm; /**< 1: as the notebook (it is in none of its optimiser groups) */
    double dropout;             /**< 0..0.9; default 0.2 (nqm: 0.1) */
    double lr_first, lr_deeper; /**< Adam; default 1e-4 for the first linear layer, 1e-3 for the rest */
    double weight_decay;        /**< L2, added to the gradient; default 1e-4 (nqm: 1e-5) */
    nqm_schedule schedule;      /**< paper, notebook: PLATEAU; nqm: COSINE */
    double plateau_factor;      /**< ReduceLROnPlateau; default 0.1 */
    size_t plateau_patience;    /**< epochs; default 5 */
    size_t batch;               /**< pairs; default 512 (nqm: 128) */
    size_t epochs;              /**< default 100 (nqm: 40) */
    nqm_precision precision;    /**< of the factors of all products: NQM_PRECISION_F32 (default) or _BF16 */
    uint64_t seed;              /**< default 1 */
    const char *checkpoint;     /**< file rewritten after each epoch; NULL: none */
    int resume;       /**< 1: go on from `checkpoint`, to the same bits as an uninterrupted run. It must come from the
                           same dataset and options, except that `epochs` may be larger under NQM_SCHEDULE_PLATEAU. */
    const char *card; /**< Markdown that follows the facts in the model's card; NULL: none */
    nqm_progress_fn progress;
    void *progress_user;
    /** Called after each epoch, and first for every epoch that a resumed checkpoint holds; NULL: not. epoch counts from
     * 1; losses are the mean log-cosh of normalised labels over the pairs. */
    void (*epoch_done)(void *user, size_t epoch, double train_loss, double validation_loss, double lr_first);
    void *epoch_user;
} nqm_train_options;

/** The options of "paper", "notebook" or "nqm"; NQM_ERR_ARG for another name. */
NQM_API NQM_MUST_CHECK nqm_status nqm_train_options_recipe(const char *recipe, nqm_train_options *options_ret,
                                                           nqm_error *err);

enum { NQM_CALIBRATION_MIN_PAIRS = 100, NQM_CALIBRATION_MIN_MATERIALS = 10 };

/** What the intervals around a model's JOD were made from, and how many labels they held with each of these materials
 *  left out in turn. doc/evaluation.md explains the method. */
typedef struct nqm_calibration {
    size_t n_pairs, n_materials;
    double coverage;        /**< share of labels inside: mean over the materials */
    double coverage_pairs;  /**< over all pairs */
    double coverage_lowest; /**< of the worst material */
    double mean_width;      /**< JOD, of the final intervals over all pairs */
    double novelty_growth;  /**< a novelty of v widens the interval exp(novelty_growth v) times, on the scale of
                                 doc/evaluation.md; 0: it does not */
} nqm_calibration;

/** What a training did. */
typedef struct nqm_train_report {
    size_t n_train, n_validation;       /**< pairs, after augmentation */
    size_t n_steps, epochs;             /**< of the whole training, with those from the checkpoint */
    size_t epochs_resumed;              /**< epochs that came from the checkpoint */
    double train_loss, validation_loss; /**< of the last epoch */
    double validation_spearman;         /**< predicted JOD with labels, validation pairs without noisy copies */
    nqm_calibration
        calibration; /**< of the model's intervals, on the validation pairs; n_materials 0: it has none, since
                                      they were drawn over pairs or are too few (NQM_CALIBRATION_MIN_..) */
    double seconds;
} nqm_train_report;

/**
 * Train a model. The same dataset, options and seed give the same model, whatever the number of threads.
 *
 * @param report  NULL allowed
 * @return NQM_ERR_ARG (an option out of range), NQM_ERR_INCOMPATIBLE (too little to split, nothing to learn, a
 *         checkpoint of something else), NQM_ERR_NUMERIC (the loss stopped being finite), NQM_ERR_CANCELLED (the
 *         checkpoint is kept), NQM_ERR_IO, NQM_ERR_FORMAT (checkpoint), NQM_ERR_LIMIT, NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_train(const nqm_dataset *dataset, const nqm_train_options *options,
                                            nqm_model **model_ret, nqm_train_report *report, nqm_error *err);

/** Write a model file; it appears under its name only when complete. */
NQM_API NQM_MUST_CHECK nqm_status nqm_model_save(const nqm_model *model, const char *path, nqm_error *err);
/** The same with `markdown` behind the model's card: what was found out after training, such as results on a test
 *  set. */
NQM_API NQM_MUST_CHECK nqm_status nqm_model_save_annotated(const nqm_model *model, const char *markdown,
                                                           const char *path, nqm_error *err);
/**
 * The same with intervals around its JOD, calibrated on the validation pairs of `dataset`, in place of any it has; the
 * card says what was measured.
 *
 * @param dataset            the one that the model was trained on, unless materials_are_new
 * @param materials_are_new  1: the caller knows that the model was not trained on the validation materials of `dataset`
 * @param calibration        receives what was measured
 * @return NQM_ERR_INCOMPATIBLE: another dataset, a model trained on materials of both splits, too few pairs or materials,
 *         other directions; else as nqm_model_save()
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_model_save_calibrated(const nqm_model *model, const nqm_dataset *dataset,
                                                            int materials_are_new, const char *path,
                                                            nqm_calibration *calibration, nqm_error *err);

/* ---- judging ----------------------------------------------------------------------------------------------------- */

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

#ifdef __cplusplus
}
#endif
#endif
