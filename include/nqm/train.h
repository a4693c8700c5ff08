/* SPDX-License-Identifier: MIT
 *
 * nqm/train.h - training a model on labelled pairs; calibrating and annotating a trained one.
 */
#ifndef NQM_TRAIN_H
#define NQM_TRAIN_H

#include <nqm/data.h>
#include <nqm/metric.h>

#ifdef __cplusplus
extern "C" {
#endif

/** How the learning rates fall. */
typedef enum nqm_schedule {
    NQM_SCHEDULE_PLATEAU = 0, /**< times plateau_factor when the validation loss stagnates (the paper) */
    NQM_SCHEDULE_COSINE       /**< half a cosine from the full rates to 0 over all epochs */
} nqm_schedule;

/** Mean and standard deviation of the transformed samples, over the references of the training pairs. */
typedef enum nqm_whitening {
    NQM_WHITEN_CHANNEL = 0, /**< mean and deviation of each colour channel (the paper) */
    NQM_WHITEN_SCALAR       /**< one for all channels (the notebook) */
} nqm_whitening;

/** The second copy of the training set, scaled by U[0.95, 1.05]. */
typedef enum nqm_scale_copy {
    NQM_SCALE_PAIR_REFLECTANCE = 0, /**< one factor per pair, on f_r (the paper) */
    NQM_SCALE_ELEMENT_TRANSFORMED,  /**< one factor per element, after the transform (the notebook) */
    NQM_SCALE_NONE                  /**< no second copy */
} nqm_scale_copy;

enum { NQM_TRAIN_MAX_HIDDEN = 7 };

/* The groups of nqm_train_options. Ranges and the values of each recipe: src/train/recipes.c and `nqm train --help`. */

/** What the network sees of a pair. */
typedef struct nqm_train_input {
    nqm_layout layout;       /**< paper, notebook: REF_TEST; nqm: REF_DIFF_ABSDIFF */
    double difference_scale; /**< factor of the differences in REF_DIFF_ABSDIFF */
    int scalars;             /**< 1: the scalar features (nqm_scalar) follow the samples */
    double scalar_scale;     /**< factor of the whitened scalar features */
    int transport; /**< 1: the network corrects the label that the dataset's transport matrix, if any, estimates */
    nqm_whitening whitening;
} nqm_train_input;

/** What the network predicts. */
typedef struct nqm_train_labels {
    nqm_target target;  /**< paper, notebook: JOD; nqm: LOG_DELTA_E */
    double min_delta_e; /**< NQM_TARGET_LOG_DELTA_E: smaller labels are raised to this value, so that the logarithm of a
                             perfect copy is finite; the curve maps 0.05 to JOD 10 within 1e-7 */
    double parts_weight; /**< weight of each part of the label in the loss, if the dataset has parts; 0: not predicted;
                              paper, notebook: 0; nqm: 0.2 */
} nqm_train_labels;

/** The multi-layer perceptron. */
typedef struct nqm_train_network {
    size_t n_hidden;                     /**< hidden layers, 1..NQM_TRAIN_MAX_HIDDEN */
    size_t hidden[NQM_TRAIN_MAX_HIDDEN]; /**< their widths, 1..16384 */
    double dropout;                      /**< probability, 0..0.9 */
    int freeze_first_layernorm;          /**< 1: as in the notebook, where it is in no optimiser group */
} nqm_train_network;

/** How validation pairs are chosen. Test pairs are never used. */
typedef struct nqm_train_split {
    int by_pair; /**< 1: validation pairs drawn over all pairs, so that a material can be on both sides (the paper); 0: whole
                      materials, those of the dataset's validation split where it has one (notebook, nqm) */
    double validation_fraction; /**< fraction of the pairs or of the material groups, 0.001..0.9 */
} nqm_train_split;

/** Examples made from other examples. */
typedef struct nqm_train_augmentation {
    int balance;          /**< 1: fill 7 equal label bins up to the fullest with noisy copies, before the split */
    double balance_sigma; /**< standard deviation of that noise, 1/sr; the same draw for both members of a pair */
    nqm_scale_copy scale_copy;
    int swap; /**< 1: the second copy exchanges reference and test, so that any BRDF is a reference */
} nqm_train_augmentation;

/** Adam on the log-cosh loss. */
typedef struct nqm_train_optimiser {
    double lr_first, lr_deeper; /**< learning rates of the first linear layer and of all other parameters */
    double weight_decay;        /**< L2, added to the gradient */
    nqm_schedule schedule;
    double plateau_factor;   /**< NQM_SCHEDULE_PLATEAU: factor of the rates */
    size_t plateau_patience; /**< NQM_SCHEDULE_PLATEAU: epochs without a better validation loss before that */
    size_t batch;            /**< pairs per step */
    size_t epochs;
    nqm_precision precision; /**< precision of the factors of all matrix products: NQM_PRECISION_F32 or _BF16 */
    uint64_t seed;           /**< seed of weights, split, augmentation, order and dropout */
} nqm_train_optimiser;

/** The run itself: none of it changes the model. */
typedef struct nqm_train_run {
    const char *checkpoint; /**< file rewritten after each epoch; NULL: none */
    int resume; /**< 1: continue from `checkpoint`, to the same bits as an uninterrupted run. It must be of the same
                                 dataset and options; only `epochs` may be larger under NQM_SCHEDULE_PLATEAU */
    nqm_progress_fn progress; /**< NULL: none */
    void *progress_user;
    /** Called after each epoch, and first for every epoch of a resumed checkpoint; NULL: none. epoch counts from
     *  1; losses are the mean log-cosh of normalised labels over the examples. */
    void (*epoch_done)(void *user, size_t epoch, double train_loss, double validation_loss, double lr_first);
    void *epoch_user;
} nqm_train_run;

/** Everything that distinguishes one training from another; from nqm_train_options_recipe(). Strings belong to the caller. */
typedef struct nqm_train_options {
    const char *recipe;  /**< the recipe that the options started from; stored in the model */
    const char *id;      /**< model id; default the recipe's name */
    const char *licence; /**< SPDX identifier of the model; NULL: not stated */
    const char *card;    /**< Markdown that is appended to the model's card; NULL: none */
    nqm_train_input input;
    nqm_train_labels labels;
    nqm_train_network network;
    nqm_train_split split;
    nqm_train_augmentation augmentation;
    nqm_train_optimiser optimiser;
    nqm_train_run run;
} nqm_train_options;

/** The options of "paper", "notebook" or "nqm"; NQM_ERR_ARG for another name. */
NQM_API NQM_MUST_CHECK nqm_status nqm_train_options_recipe(const char *recipe, nqm_train_options *options_ret,
                                                           nqm_error *err);

enum { NQM_CALIBRATION_MIN_PAIRS = 100, NQM_CALIBRATION_MIN_MATERIALS = 10 };

/** What the 95 % intervals of a model were calibrated on, and how many labels they held with each of these materials
 *  left out in turn. doc/evaluation.md explains the method. */
typedef struct nqm_calibration {
    size_t n_pairs, n_materials;
    double coverage;        /**< fraction of the labels inside: mean over the materials */
    double coverage_pairs;  /**< over all pairs */
    double coverage_lowest; /**< coverage of the material where it is lowest */
    double mean_width;      /**< JOD, of the final intervals over all pairs */
    double novelty_growth;  /**< a novelty of v multiplies the width by exp(novelty_growth v), on the scale of
                                 doc/evaluation.md; 0: the width does not depend on it */
    double disagreement_growth,
        peak_growth; /**< likewise of ln(1 + |y - y'| / 0.1), where y' is that of the estimate by
                                 light transport, and of max(0, ref_peak - 8) / 10, a scalar feature of the reference */
} nqm_calibration;

/** What a training did. */
typedef struct nqm_train_report {
    size_t n_train, n_validation;       /**< examples, after augmentation */
    size_t n_steps, epochs;             /**< steps and epochs of the whole training, with those before the checkpoint */
    size_t epochs_resumed;              /**< epochs that came from the checkpoint */
    double train_loss, validation_loss; /**< losses of the last epoch: mean log-cosh of normalised labels */
    double
        validation_spearman; /**< correlation of predicted JOD and label, over validation pairs without noisy copies */
    nqm_calibration
        calibration; /**< of the model's intervals, on the validation pairs; n_materials 0: no intervals, since
                                             the pairs were drawn over all pairs or are too few (NQM_CALIBRATION_MIN_...) */
    double seconds;
} nqm_train_report;

/**
 * Train a model. The same dataset, options and seed give the same model, whatever the number of threads. It has intervals
 * where the validation materials allow, and golden scores. Save it with nqm_model_save(), free it with nqm_model_free().
 *
 * @param report  NULL allowed
 * @return NQM_ERR_ARG (an option out of range), NQM_ERR_INCOMPATIBLE (too little to split, nothing to learn, a
 *         checkpoint of something else), NQM_ERR_NUMERIC (the loss stopped being finite), NQM_ERR_CANCELLED (the
 *         checkpoint is kept), NQM_ERR_IO, NQM_ERR_FORMAT (checkpoint), NQM_ERR_LIMIT, NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_train(const nqm_dataset *dataset, const nqm_train_options *options,
                                            nqm_model **model_ret, nqm_train_report *report, nqm_error *err);

/**
 * A copy of a model with intervals around its JOD, calibrated on the validation pairs of `dataset`; they replace those that
 * the model has. The card of the copy says what was measured.
 *
 * @param dataset            the one that the model was trained on, unless materials_are_new
 * @param materials_are_new  1: the caller knows that the model was not trained on the validation materials of `dataset`
 * @param calibration        receives what was measured
 * @return NQM_ERR_INCOMPATIBLE (another dataset, a model trained on materials of both splits, too few pairs or materials,
 *         other directions), NQM_ERR_NUMERIC, NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_model_calibrate(const nqm_model *model, const nqm_dataset *dataset,
                                                      int materials_are_new, nqm_model **model_ret,
                                                      nqm_calibration *calibration, nqm_error *err);

#ifdef __cplusplus
}
#endif
#endif
