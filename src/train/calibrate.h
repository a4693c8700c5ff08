/* SPDX-License-Identifier: MIT
 *
 * calibrate.h - from predictions and labels of materials that a model has not seen to an interval around each prediction.
 * doc/evaluation.md explains the method.
 */
#ifndef NQM_SRC_TRAIN_CALIBRATE_H
#define NQM_SRC_TRAIN_CALIBRATE_H

#include "train/train.h"

enum { NQM_INTERVAL_ROWS = 129 };

/** Pairs to calibrate on. */
typedef struct nqm_residuals {
    size_t n, n_groups;
    const double *predicted, *label; /* (n) JOD, finite */
    const uint32_t *group;           /* (n) the material of each pair, below n_groups */
    const double *novelty;           /* (n) >= 0; NULL: not known */
} nqm_residuals;

/** Whether there are enough pairs and materials (NQM_CALIBRATION_MIN_PAIRS, _MATERIALS). *n_materials_ret (NULL allowed):
 *  groups that hold pairs. */
bool nqm_residuals_suffice(const nqm_residuals *residuals, size_t *n_materials_ret);

/**
 * Fit the table of struct nqm_model.interval and .novelty_growth, which is in the report, and measure the coverage with each
 * material left out in turn.
 *
 * @param table  (NQM_INTERVAL_ROWS, 3)
 * @return NQM_ERR_INCOMPATIBLE: too few pairs or materials; NQM_ERR_NOMEM
 */
NQM_MUST_CHECK nqm_status nqm_interval_fit(const nqm_residuals *residuals, double *table, nqm_calibration *report,
                                           nqm_error *err);

/**
 * Fit, and give the model its interval and its JSON; it has none yet. The novelty of the pairs is found here: the model's
 * points are those it has, if `trained_on` is false, or are chosen among the training pairs of the dataset.
 *
 * @param pairs  (residuals->n) pairs of `dataset` that the residuals are of
 */
NQM_MUST_CHECK nqm_status nqm_model_set_interval(struct nqm_model *model, const nqm_dataset *dataset, bool trained_on,
                                                 const nqm_residuals *residuals, const size_t *pairs,
                                                 nqm_calibration *report, nqm_error *err);

/** Points of a model's measure of novelty at most. */
enum { NQM_NOVELTY_MAX_POINTS = 2048 };
/**
 * Choose the points of struct nqm_model.novelty_points among the training pairs of a dataset, at the model's directions, in
 * place of those it has: far apart from each other. The unit of distance becomes 1, the growth 0. Models without scalar
 * features, and those with fewer training pairs than a block of points, get none.
 */
NQM_MUST_CHECK nqm_status nqm_novelty_choose(struct nqm_model *model, const nqm_dataset *dataset, nqm_error *err);
/** Find the novelty (n) of pairs (n) of a dataset and make it the model's unit that 5 % of them are beyond 1. Without points
 *  *known_ret is false, and if the unit would be 0 the points are taken away, too. */
NQM_MUST_CHECK nqm_status nqm_novelty_measure(struct nqm_model *model, const nqm_dataset *dataset, size_t n,
                                              const size_t *pairs, double *novelty, bool *known_ret, nqm_error *err);

/** `card` with the section on the interval that `calibration` tells of, in the place of an older one; nqm_free(). NULL:
 *  out of memory. */
char *nqm_card_with_interval(const char *card, const nqm_calibration *calibration, const char *dataset_sha256);

#endif
