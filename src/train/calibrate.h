/* SPDX-License-Identifier: MIT
 *
 * calibrate.h - calibrates intervals around predictions, from predictions and labels of materials that a model was not
 * trained on. doc/evaluation.md explains the method.
 */
#ifndef NQM_SRC_TRAIN_CALIBRATE_H
#define NQM_SRC_TRAIN_CALIBRATE_H

#include "train/train.h"

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
