/* SPDX-License-Identifier: MIT
 *
 * recipes.h - the table of nqm_train_options: name, description, range and value in each recipe of every training
 * option.
 */
#ifndef NQM_SRC_TRAIN_RECIPES_H
#define NQM_SRC_TRAIN_RECIPES_H

#include "base/options.h"
#include <nqm/train.h>

extern const nqm_option_table nqm_train_option_table;

#endif
