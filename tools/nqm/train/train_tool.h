/* SPDX-License-Identifier: MIT
 *
 * train_tool.h - the training that `nqm train` and `nqm reproduce` share.
 */
#ifndef NQM_TOOL_TRAIN_H
#define NQM_TOOL_TRAIN_H

#include "nqm/tool.h"

/** Train with progress on the terminal, write the losses of each epoch to `log` (CSV; NULL: none) and the model to
 *  `path`, and load the written file (*model_ret; NULL if `path` is "-"). Reports errors; returns an exit code.
 *  options->run.epoch_done and .progress are replaced. */
int train_and_save(const char *verb, const nqm_dataset *dataset, const nqm_train_options *options, const char *path,
                   const char *log, nqm_model **model_ret, nqm_train_report *report_ret);

#endif
