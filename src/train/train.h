/* SPDX-License-Identifier: MIT
 *
 * train.h - augmentation of labelled pairs, and the parts of the training loop (paper, sections 3.1 and 3.2).
 */
#ifndef NQM_SRC_TRAIN_H
#define NQM_SRC_TRAIN_H

#include "base/options.h"
#include "data/data.h"
#include "model/model.h"
#include "net/trainer.h"
#include <jansson.h>
#include <nqm/train.h>

/* ---- options (recipes.c) ----------------------------------------------------------------------------------------- */

/** Name, description, range and value in each recipe of every training option. */
extern const nqm_option_table nqm_train_option_table;
/** Check the ranges of all options. The message of NQM_ERR_ARG names the option. */
NQM_MUST_CHECK nqm_status nqm_train_options_check(const nqm_train_options *options, nqm_error *err);
/** The options that affect the result, as JSON; free with json_decref(). NULL: out of memory. `epochs` is included only
 *  if the schedule depends on it; otherwise a training can be resumed with more epochs. */
json_t *nqm_train_options_json(const nqm_train_options *options);

/** Purposes of the random numbers of a training. Each has a separate random stream. */
enum {
    NQM_STREAM_INIT,    /* first weights */
    NQM_STREAM_SPLIT,   /* validation pairs or groups */
    NQM_STREAM_NOISE,   /* noisy copies */
    NQM_STREAM_SCALE,   /* scaled copies */
    NQM_STREAM_SHUFFLE, /* order of an epoch */
    NQM_STREAM_DROPOUT
};

/* ---- augmentation and splits (augment.c) ------------------------------------------------------------------------- */

enum { NQM_BALANCE_BINS = 7 };

/** One training or validation example: a pair without noise (copy 0), or its noisy copy number `copy` (from 1). */
typedef struct nqm_row {
    uint32_t pair, copy;
} nqm_row;

/** Class balancing (paper, section 3.1): the label range is divided into 7 bins of equal width, and every non-empty bin
 * is filled to the size of the largest one by cycling through its members. copies (n) receives the number of copies of
 * each example. Returns their sum. */
size_t nqm_balance(size_t n, const double *label, uint32_t *copies);

/** The examples of a training, without scaled copies: rows [0, n_train) are for training, the others for validation. */
typedef struct nqm_rows {
    size_t n_train, n_validation;
    nqm_row *row;         /* (n_train + n_validation), in each part sorted by pair and copy; owns both arrays */
    size_t n_noisy;       /* rows with copy > 0 */
    uint32_t *first_copy; /* (n_pairs) index of a pair's first noisy copy, in [0, n_noisy) */
} nqm_rows;

/** Balance and split according to the options; test pairs are not used. NQM_ERR_INCOMPATIBLE if a part is empty. */
NQM_MUST_CHECK nqm_status nqm_rows_create(const nqm_dataset *dataset, const nqm_train_options *options,
                                          nqm_rows *rows_ret, nqm_error *err);
void nqm_rows_free(nqm_rows *rows);

/** Make a noisy copy of a pair: add the same Gaussian noise to both BRDFs, then clamp to >= 0. All arrays: (n). */
void nqm_add_noise(size_t n, const float *ref, const float *test, double sigma, nqm_rng *rng, float *noisy_ref,
                   float *noisy_test);

/* ---- inputs and targets of the network (examples.c) -------------------------------------------------------------- */

/** The examples of a training, with data computed once: transformed samples, whitening, normalised targets. */
typedef struct nqm_examples {
    const nqm_dataset *dataset;
    const nqm_train_options *options;
    nqm_rows rows;
    size_t n_train;        /* training examples including the scaled copies, which follow the unscaled ones */
    float *ref_t, *test_t; /* (n_refs, n_directions, 3), (n_pairs, n_directions, 3); ref_t owns all arrays here */
    float *noisy_t;        /* (n_noisy, 2, n_directions, 3) reference and test of each noisy copy */
    nqm_features features;
    float *scalars; /* (n_train + rows.n_validation, NQM_SCALAR_COUNT) whitened; options->input.scalars 0: not used */
    nqm_scalar_whitening scalar_whitening;
    size_t n_outputs; /* 1, or 1 + NQM_LABEL_PARTS */
    nqm_output_range output[1 + NQM_LABEL_PARTS];
    nqm_label
        *estimate;  /* (n_pairs) labels estimated by transport, which the network corrects; NULL: it predicts labels */
    float *target;  /* (rows.n_train + rows.n_validation, n_outputs) normalised, in the order of `rows` */
    float *scratch; /* (max_batch, 2, n_directions, 3) */
    uint8_t *used_scratch;                  /* (max_batch, n_directions) */
    size_t max_batch, width, samples_width; /* widths of the input and of its prefix of samples */
} nqm_examples;

NQM_MUST_CHECK nqm_status nqm_examples_create(const nqm_dataset *dataset, const nqm_train_options *options,
                                              size_t max_batch, nqm_examples *examples_ret, nqm_error *err);
void nqm_examples_free(nqm_examples *examples);
/** Gather the inputs of n <= max_batch examples into a trainer, and their targets (n, n_outputs): of the training
 *  examples index[0..n), or, if that is NULL, of the validation examples [first, first + n). */
void nqm_examples_gather(const nqm_examples *examples, size_t n, const size_t *index, size_t first,
                         nqm_trainer *trainer, float *target);

/* ---- the state of a training, and its file (checkpoint.c) -------------------------------------------------------- */

/** Losses and learning rate of one finished epoch. */
typedef struct nqm_epoch {
    double train_loss, validation_loss, lr_first;
} nqm_epoch;

/** The complete state on which the next step depends. */
typedef struct nqm_training {
    nqm_params params;
    nqm_adam adam;
    nqm_plateau plateau;
    double lr_first, lr_deeper;
    size_t epoch;       /* number of finished epochs */
    nqm_epoch *history; /* (max_epochs) */
    size_t max_epochs;
} nqm_training;

/** Write the state with its options and the hash of its dataset. */
NQM_MUST_CHECK nqm_status nqm_checkpoint_write(const nqm_training *training, const nqm_train_options *options,
                                               const char *dataset_sha256, nqm_error *err);
/** Read a state into a training of the same shape. NQM_ERR_INCOMPATIBLE if the options or the dataset differ. */
NQM_MUST_CHECK nqm_status nqm_checkpoint_read(nqm_training *training, const nqm_train_options *options,
                                              const char *dataset_sha256, nqm_error *err);

/** Generate the model card: training data, options and results. Free it with nqm_free(). NULL: out of memory. */
char *nqm_model_card(const nqm_dataset *dataset, const nqm_train_options *options, const nqm_train_report *report,
                     const struct nqm_model *model);

/** A copy of a model whose card ends with `markdown`: results on a test set, for example. NQM_ERR_NOMEM. */
NQM_MUST_CHECK nqm_status nqm_model_annotate(const nqm_model *model, const char *markdown, nqm_model **model_ret,
                                             nqm_error *err);

/* ---- intervals (calibrate.c, interval_fit.c, novelty_fit.c) ------------------------------------------------------ */

/* They are calibrated on predictions and labels of materials that a model was not trained on (doc/evaluation.md). */

enum { NQM_INTERVAL_ROWS = 129 };

/** Pairs to calibrate on. */
typedef struct nqm_residuals {
    size_t n, n_groups;
    double *predicted, *label; /* (n) JOD, finite; `predicted` owns the arrays that nqm_residuals_create() made */
    uint32_t *group;           /* (n) the material of each pair, below n_groups */
    double *novelty;           /* (n) >= 0; NULL: unknown */
    double *spread;            /* (n, NQM_SPREAD_FEATURES) of nqm_spread_features(); NULL: unknown */
    double *noise;             /* (n) standard error of y of the label (nqm_interval_y()); 0: unknown */
    size_t *pairs;             /* (n) indices in the dataset; nqm_interval_fit() does not need them */
} nqm_residuals;

/** No residuals yet, with room for max_n pairs of a dataset; free `predicted` with nqm_free(). */
NQM_MUST_CHECK nqm_status nqm_residuals_create(const nqm_dataset *dataset, size_t max_n, nqm_residuals *residuals_ret,
                                               nqm_error *err);
/** Append a pair of the dataset with its predicted JOD. */
void nqm_residuals_add(nqm_residuals *residuals, const nqm_dataset *dataset, size_t pair, double predicted);
/** True if there are at least NQM_CALIBRATION_MIN_PAIRS pairs and NQM_CALIBRATION_MIN_MATERIALS materials.
 *  *n_materials_ret (NULL allowed) receives the number of groups with pairs. */
bool nqm_residuals_suffice(const nqm_residuals *residuals, size_t *n_materials_ret);

/**
 * Fit the table of struct nqm_model.interval and the values of .novelty_growth and .spread_growth (stored in the report), and
 * measure the coverage of each material with the values fitted to the other materials.
 *
 * @param table  (NQM_INTERVAL_ROWS, 3)
 * @return NQM_ERR_INCOMPATIBLE: too few pairs or materials; NQM_ERR_NOMEM
 */
NQM_MUST_CHECK nqm_status nqm_interval_fit(const nqm_residuals *residuals, double *table, nqm_calibration *report,
                                           nqm_error *err);

/** least (NQM_INTERVAL_KNOTS) receives struct nqm_model.interval_floor: 1.96 times the root mean square of `noise` of pairs with
 *  predictions near the knot, and at least 0.001 JOD. */
void nqm_interval_find_floor(const nqm_residuals *residuals, double *least);

/**
 * Fit an interval and store it, with its JSON description, in a model that has none. Also computes the novelty and the
 * features of the pairs.
 *
 * @param trained_on  choose new novelty points among the training pairs of `dataset`; otherwise keep the model's points
 * @param residuals   pairs of `dataset`; receives their novelty and features
 */
NQM_MUST_CHECK nqm_status nqm_model_set_interval(struct nqm_model *model, const nqm_dataset *dataset, bool trained_on,
                                                 nqm_residuals *residuals, nqm_calibration *report, nqm_error *err);

/** Maximum number of novelty points of a model. */
enum { NQM_NOVELTY_MAX_POINTS = 2048 };
/**
 * Replace the points of struct nqm_model.novelty_points by training pairs of a dataset (at the model's directions)
 * that are far from each other. Sets novelty_unit to 1 and novelty_growth to 0. The model gets no points if it has no
 * scalar features, or if there are fewer training pairs than NQM_NOVELTY_BLOCK.
 */
NQM_MUST_CHECK nqm_status nqm_novelty_choose(struct nqm_model *model, const nqm_dataset *dataset, nqm_error *err);
/** Compute `spread` and the novelty of pairs of a dataset (`predicted` is set), and set the model's novelty_unit so
 *  that 5 % of them are above 1. The novelty becomes NULL if the model has no points, or if the unit would be 0; then
 *  the points are removed. Both become NULL if the model has no scalar features. */
NQM_MUST_CHECK nqm_status nqm_novelty_measure(struct nqm_model *model, const nqm_dataset *dataset,
                                              nqm_residuals *residuals, nqm_error *err);

/** A copy of `card` with a section that describes `calibration`; an older section is replaced. Free it with nqm_free().
 *  NULL: out of memory. */
char *nqm_card_with_interval(const char *card, const nqm_calibration *calibration, const char *dataset_sha256);

#endif
