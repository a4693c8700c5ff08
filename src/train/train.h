/* SPDX-License-Identifier: MIT
 *
 * train.h - the augmentation of labelled pairs, and the pieces of the training
 * loop (paper, sections 3.1 and 3.2).
 */
#ifndef NQM_SRC_TRAIN_H
#define NQM_SRC_TRAIN_H

#include "data/data.h"
#include "model/model.h"
#include "train/recipes.h"
#include <jansson.h>

/* ---- options (recipes.c) ----------------------------------------------------------------------------------------- */

/** NQM_ERR_ARG names the option that is out of its range. */
NQM_MUST_CHECK nqm_status nqm_train_options_check(const nqm_train_options *options, nqm_error *err);
/** The options that decide the outcome, as JSON; json_decref(). NULL: out of memory. `epochs` only where the schedule depends on
 *  it: otherwise a training may be continued for more. */
json_t *nqm_train_options_json(const nqm_train_options *options);

/** What the random numbers of a training are for: each purpose has a stream of the seed of its own. */
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

/** One training or validation example: a pair as it is (copy 0), or its copy-th noisy copy. */
typedef struct nqm_row {
    uint32_t pair, copy;
} nqm_row;

/** Class balancing (paper, section 3.1): the label range is cut into 7 equal bins, and every bin that is not empty is
 * filled up to the fullest by cycling through its members. copies (n) receives how many copies each example gets.
 * Returns their sum. */
size_t nqm_balance(size_t n, const double *label, uint32_t *copies);

/** The examples of a training, without the scale copies: rows [0, n_train) are trained on, the rest validated. */
typedef struct nqm_rows {
    size_t n_train, n_validation;
    nqm_row *row;         /* (n_train + n_validation), by pair and copy inside each part */
    size_t n_noisy;       /* rows with copy > 0 */
    uint32_t *first_copy; /* (n_pairs) number of a pair's first noisy copy, in [0, n_noisy) */
} nqm_rows;

/** Balance and split as the options say; no test pair is touched. NQM_ERR_INCOMPATIBLE when a part stays empty. */
NQM_MUST_CHECK nqm_status nqm_rows_create(const nqm_dataset *dataset, const nqm_train_options *options,
                                          nqm_rows *rows_ret, nqm_error *err);
void nqm_rows_free(nqm_rows *rows);

/** The noisy copy of a pair: gaussian noise, the same for both members, then clamped at 0. All arrays: (n). */
void nqm_add_noise(size_t n, const float *ref, const float *test, double sigma, nqm_rng *rng, float *noisy_ref,
                   float *noisy_test);

/* ---- examples as numbers for the network (examples.c) ------------------------------------------------------------ */

/** The examples of a training with all that is computed once: transformed samples, whitening, normalised targets. */
typedef struct nqm_examples {
    const nqm_dataset *dataset;
    const nqm_train_options *options;
    nqm_rows rows;
    size_t n_train;        /* training examples with the scale copies, which stand behind the unscaled ones */
    float *ref_t, *test_t; /* (n_refs, n_directions, 3), (n_pairs, n_directions, 3) */
    float *noisy_t;        /* (n_noisy, 2, n_directions, 3) reference and test of each noisy copy */
    nqm_features features;
    float *scalars; /* (n_train + rows.n_validation, NQM_SCALAR_COUNT) as inputs; NULL: not asked for */
    float scalar_mean[NQM_SCALAR_COUNT], scalar_std[NQM_SCALAR_COUNT];
    double target_mean, target_std, out_lo, out_hi;
    float *target;                          /* (rows.n_train + rows.n_validation) normalised, in the order of rows */
    float *scratch;                         /* (max_batch, 2, n_directions, 3) */
    uint8_t *used_scratch;                  /* (max_batch, n_directions) */
    size_t max_batch, width, samples_width; /* the input; the part of it that comes from samples */
} nqm_examples;

NQM_MUST_CHECK nqm_status nqm_examples_create(const nqm_dataset *dataset, const nqm_train_options *options,
                                              size_t max_batch, nqm_examples *examples_ret, nqm_error *err);
void nqm_examples_free(nqm_examples *examples);
/** Where a batch goes. */
typedef struct nqm_batch_inputs {
    float *(*row)(void *user, size_t i); /* where row i (width) is to be filled in by the calling thread */
    /* Called by the thread that has filled in rows first and, where n is 2, first + 1; first is even. NULL: not. */
    void (*rows_done)(void *user, size_t first, size_t n);
    void *user;
    float *target; /* (n) */
} nqm_batch_inputs;

/** Inputs and targets of the training examples index[0..n), n <= max_batch. */
void nqm_examples_gather(const nqm_examples *examples, size_t n, const size_t *index, const nqm_batch_inputs *to);
/** The same for the validation examples [first, first + n). */
void nqm_examples_gather_validation(const nqm_examples *examples, size_t first, size_t n, const nqm_batch_inputs *to);

/** Transformed samples of row i of e->rows, or of its scaled copy, which is made in `scratch` (2, n_directions, 3). */
void nqm_examples_samples(const nqm_examples *examples, size_t i, bool scaled, float *scratch, const float **ref_t,
                          const float **test_t);
/** Fill `scalars` and their whitening (example_scalars.c). */
NQM_MUST_CHECK nqm_status nqm_examples_find_scalars(nqm_examples *examples, nqm_error *err);

/* ---- the state of a training, and its file (checkpoint.c) -------------------------------------------------------- */

/** Losses and rate of one finished epoch. */
typedef struct nqm_epoch {
    double train_loss, validation_loss, lr_first;
} nqm_epoch;

/** Everything that the next step depends on. */
typedef struct nqm_training {
    nqm_params params;
    nqm_adam adam;
    nqm_plateau plateau;
    double lr_first, lr_deeper;
    size_t epoch;       /* finished ones */
    nqm_epoch *history; /* (max_epochs) */
    size_t max_epochs;
} nqm_training;

/** Write the state, with the options and the dataset that it belongs to. */
NQM_MUST_CHECK nqm_status nqm_checkpoint_write(const nqm_training *training, const nqm_train_options *options,
                                               const char *dataset_sha256, nqm_error *err);
/** Read it back into a created training of the same shape. NQM_ERR_INCOMPATIBLE when options or dataset are others. */
NQM_MUST_CHECK nqm_status nqm_checkpoint_read(nqm_training *training, const nqm_train_options *options,
                                              const char *dataset_sha256, nqm_error *err);

/** The model card: what the model was trained and judged on, from facts; nqm_free(). NULL when out of memory. */
char *nqm_model_card(const nqm_dataset *dataset, const nqm_train_options *options, const nqm_train_report *report,
                     const struct nqm_model *model);

#endif
