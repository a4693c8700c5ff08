/* SPDX-License-Identifier: MIT
 *
 * nqm/train.h - training a model on labelled pairs, and its file.
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

#ifdef __cplusplus
}
#endif
#endif
