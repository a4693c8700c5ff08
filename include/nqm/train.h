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
    size_t n_pairs_in[3];    /**< per split, before augmentation */
    const char *sha256;      /**< of the file; "" for the authors' layout */
    const char *manifest;    /**< JSON: how it was made; "" if unknown */
    const nqm_directions *directions;
} nqm_dataset_info;

/** Load nqm's own dataset file (safetensors; doc/files.md). */
NQM_API NQM_MUST_CHECK nqm_status nqm_dataset_load(const char *path, nqm_dataset **dataset_ret, nqm_error *err);

/**
 * Read the authors' layout: ROOT/ref/NAME.mat and ROOT/model/NAME.mat (MAT v5; r, g, b 500x1 and random_locations 500x3 in
 * degrees) and a CSV `material,model,level,DeltaE,JOD,class`. Noise-augmented rows of that CSV ("NAME_k" more than once a
 * pair) are read as they are.
 *
 * @param root        the folder
 * @param labels_csv  the CSV
 * @param split       the split that every row gets; NQM_SPLIT_ALL: training rows, split later by the options of training
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_dataset_load_authors(const char *root, const char *labels_csv, nqm_split split,
                                                           nqm_dataset **dataset_ret, nqm_error *err);
NQM_API void nqm_dataset_free(nqm_dataset *dataset);
NQM_API nqm_dataset_info nqm_dataset_get_info(const nqm_dataset *dataset);

/** How the labels become what the network learns. */
typedef enum nqm_target {
    NQM_TARGET_JOD = 0,    /**< JOD, z-scored; sigmoid over the range of the training labels (the paper) */
    NQM_TARGET_LOG_DELTA_E /**< log Delta-E ITP, z-scored; sigmoid over its range; mapped to JOD through the curve */
} nqm_target;

/** How a pair becomes the network's input, after t = log(cbrt(rho) + 1) and whitening. */
typedef enum nqm_layout {
    NQM_LAYOUT_REF_TEST = 0,    /**< reference half, then test half: 6 n numbers (the paper) */
    NQM_LAYOUT_REF_DIFF_ABSDIFF /**< reference, s (test - reference), s |test - reference|: 9 n numbers */
} nqm_layout;

typedef enum nqm_whitening { NQM_WHITEN_CHANNEL = 0, NQM_WHITEN_SCALAR } nqm_whitening;
typedef enum nqm_scale_copy {
    NQM_SCALE_PAIR_REFLECTANCE = 0, /**< one factor a pair, on f_r (the paper) */
    NQM_SCALE_ELEMENT_TRANSFORMED,  /**< one factor an element, after the transform (the notebook) */
    NQM_SCALE_NONE
} nqm_scale_copy;

/** Everything that distinguishes one training from another. */
typedef struct nqm_train_options {
    const char *recipe;          /**< the name the options came from; stored in the model */
    const char *id;              /**< model id; default the recipe's name */
    nqm_layout layout;           /**< paper: REF_TEST; nqm: REF_DIFF_ABSDIFF */
    double difference_scale;     /**< s of the layout; paper: unused; nqm: 3 */
    nqm_target target;
    nqm_whitening whitening;
    nqm_scale_copy scale_copy;   /**< second copy of the training set scaled by U[0.95, 1.05] */
    int split_by_pair;           /**< 1: validation pairs drawn over pairs (as the authors); 0: by the dataset's groups */
    double validation_fraction;  /**< when the dataset brings no validation split, or split_by_pair; default 0.2 */
    int balance;                 /**< 1: fill 7 equal label bins by noisy copies (sigma below); default 1 */
    double balance_sigma;        /**< 1/sr; default 0.01 */
    int freeze_first_layernorm;  /**< 1: as the notebook (it is in none of its optimiser groups) */
    double dropout;              /**< 0..0.9; default 0.2 */
    double lr_first, lr_deeper;  /**< Adam; default 1e-4 for the first linear layer, 1e-3 for the rest */
    double weight_decay;         /**< L2, added to the gradient; default 1e-4 */
    double plateau_factor;       /**< ReduceLROnPlateau; default 0.1 */
    size_t plateau_patience;     /**< epochs; default 5 */
    size_t batch;                /**< pairs; default 512 (nqm: 128) */
    size_t epochs;               /**< default 100 */
    uint64_t seed;               /**< default 1 */
    const char *checkpoint;      /**< file rewritten after each epoch; NULL: none */
    int resume;                  /**< 1: go on from `checkpoint`, to the same bits as an uninterrupted run */
    const char *card;            /**< Markdown for the model; NULL: made from the options and results */
    nqm_progress_fn progress;
    void *progress_user;
    /** Called after each epoch; NULL: not. Losses are mean log-cosh of normalised labels. */
    void (*epoch_done)(void *user, size_t epoch, double train_loss, double validation_loss, double lr_first);
    void *epoch_user;
} nqm_train_options;

/** The options of "paper", "notebook" or "nqm"; NQM_ERR_ARG for another name. */
NQM_API NQM_MUST_CHECK nqm_status nqm_train_options_recipe(const char *recipe, nqm_train_options *options_ret,
                                                           nqm_error *err);

/** What a training did. */
typedef struct nqm_train_report {
    size_t n_train, n_validation; /**< pairs, after augmentation */
    size_t n_steps, epochs;
    double train_loss, validation_loss; /**< of the last epoch */
    double validation_spearman;
    double seconds;
} nqm_train_report;

/**
 * Train a model. The same dataset, options and seed give the same model, whatever the number of threads.
 *
 * @return NQM_ERR_NUMERIC when the loss stops being finite, NQM_ERR_CANCELLED (the checkpoint is kept), NQM_ERR_NOMEM, ...
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_train(const nqm_dataset *dataset, const nqm_train_options *options,
                                            nqm_model **model_ret, nqm_train_report *report, nqm_error *err);

/** Write a model file; it appears under its name only when complete. */
NQM_API NQM_MUST_CHECK nqm_status nqm_model_save(const nqm_model *model, const char *path, nqm_error *err);

/** How well one predictor agrees with the labels. Correlations are signed so that higher is better. */
typedef struct nqm_agreement {
    const char *name;             /**< "jod" for the model, else nqm_metric_name() */
    size_t n, n_materials;        /**< pairs and material groups that counted */
    double spearman, spearman_ci95[2];
    double spearman_mean_by_material, spearman_mean_by_material_ci95[2]; /**< mean over groups with >= 3 pairs */
    double pearson, kendall;
    double mae, rmse, r2;         /**< of predicted JOD; NaN for metrics, which have no JOD */
} nqm_agreement;

/** Which pairs to judge on. */
typedef struct nqm_eval_options {
    nqm_split split;              /**< default NQM_SPLIT_ALL */
    const char *kind;             /**< only this kind of distortion; NULL: all */
    double jod_from, jod_to;      /**< only labels in [from, to); default 0 and infinity */
    size_t n_bootstrap;           /**< resamples of material groups for the 95 % intervals; 0: none (NaN); default 1000 */
    uint64_t seed;                /**< default 1 */
} nqm_eval_options;

NQM_API nqm_eval_options nqm_eval_options_default(void);

/**
 * Judge a model and the nine scalar metrics on a dataset.
 *
 * @param results  (1 + NQM_METRIC_COUNT) receives the model first, then the metrics in the order of nqm_metric
 * @return NQM_ERR_INCOMPATIBLE when the directions of model and dataset differ or no pair is left
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_evaluate(const nqm_model *model, const nqm_dataset *dataset,
                                               const nqm_eval_options *options, nqm_agreement *results, nqm_error *err);

/** The kinds of distortion in a dataset: how many, and the i-th ("ggx", "noise"); lent. */
NQM_API size_t nqm_dataset_kind_count(const nqm_dataset *dataset);
NQM_API const char *nqm_dataset_kind_name(const nqm_dataset *dataset, size_t i);

#ifdef __cplusplus
}
#endif
#endif
