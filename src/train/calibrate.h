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
} nqm_residuals;

/** Whether there are enough pairs and materials (NQM_CALIBRATION_MIN_PAIRS, _MATERIALS). *n_materials_ret (NULL allowed):
 *  groups that hold pairs. */
bool nqm_residuals_suffice(const nqm_residuals *residuals, size_t *n_materials_ret);

/**
 * Fit the table of struct nqm_model.interval, and measure its coverage with each material left out in turn.
 *
 * @param table  (NQM_INTERVAL_ROWS, 3)
 * @return NQM_ERR_INCOMPATIBLE: too few pairs or materials; NQM_ERR_NOMEM
 */
NQM_MUST_CHECK nqm_status nqm_interval_fit(const nqm_residuals *residuals, double *table, nqm_calibration *report,
                                           nqm_error *err);

/** Fit, and give the model its interval and its JSON. dataset_sha256: where the pairs come from. */
NQM_MUST_CHECK nqm_status nqm_model_set_interval(struct nqm_model *model, const nqm_residuals *residuals,
                                                 const char *dataset_sha256, nqm_calibration *report, nqm_error *err);

/** `card` with the section on the interval that `calibration` tells of, in the place of an older one; nqm_free(). NULL:
 *  out of memory. */
char *nqm_card_with_interval(const char *card, const nqm_calibration *calibration, const char *dataset_sha256);

#endif
