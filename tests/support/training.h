/* SPDX-License-Identifier: MIT
 *
 * training.h - quick trainings on toy datasets.
 */
#ifndef NQM_TESTS_TRAINING_H
#define NQM_TESTS_TRAINING_H

#include "train/train.h"

/** A recipe with one hidden layer of `width` units, batches of 32 and a high learning rate. */
nqm_train_options small_recipe(const char *recipe, size_t width, size_t epochs);
/** Train a model; a failure fails the test. report: may be NULL. */
nqm_model *train_model(const nqm_dataset *dataset, const nqm_train_options *options, nqm_train_report *report);
/** Calibrate the model and save it to scratch_path("model"). */
nqm_status save_calibrated(const nqm_model *model, const nqm_dataset *d, int materials_are_new,
                           nqm_calibration *calibration, nqm_error *err);

#endif
