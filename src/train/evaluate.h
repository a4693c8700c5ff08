/* SPDX-License-Identifier: MIT
 *
 * evaluate.h - inside of an evaluation: the predictions for the pairs of a dataset.
 */
#ifndef NQM_SRC_TRAIN_EVALUATE_H
#define NQM_SRC_TRAIN_EVALUATE_H

#include "train/train.h"

struct nqm_evaluation {
    const nqm_dataset *dataset;
    size_t n_models, n_predictors;
    const nqm_model *const *models;
    nqm_split split;
    double *values;     /* (n_predictors, n_pairs of the dataset) NaN where not predicted */
    double *scalars;    /* (n_pairs of the dataset, NQM_SCALAR_COUNT) likewise */
    size_t *ref_class;  /* (n_refs) */
    const char **names; /* (n_predictors) */
};

static inline bool nqm_evaluation_in_split(const nqm_dataset *d, size_t pair, nqm_split split) {
    return split == NQM_SPLIT_ALL || nqm_dataset_pair_split(d, pair) == split;
}

#endif
