/* SPDX-License-Identifier: MIT
 *
 * models_table.h - the embedded model files: "default" in libnqm, "default" and "paper" in libnqm-full and the
 * tool. cmake/models.cmake generates the table; a row without a name ends it.
 */
#ifndef NQM_SRC_MODELS_TABLE_H
#define NQM_SRC_MODELS_TABLE_H

#include "base/embedded.h"

extern const nqm_embedded_file nqm_embedded_models[];

#endif
