/* SPDX-License-Identifier: MIT
 *
 * recipes.h - the table of nqm_train_options: the one place that names, explains and bounds a training option and gives its
 * value in each recipe.
 */
#ifndef NQM_SRC_TRAIN_RECIPES_H
#define NQM_SRC_TRAIN_RECIPES_H

#include "base/options.h"
#include <nqm/train.h>

extern const nqm_option_table nqm_train_option_table;

#endif
