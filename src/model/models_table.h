/* SPDX-License-Identifier: MIT
 *
 * models_table.h - the model files embedded into the library ("default", "paper"), generated into the build folder by
 * cmake/models.cmake.
 */
#ifndef NQM_SRC_NET_MODELS_TABLE_H
#define NQM_SRC_NET_MODELS_TABLE_H

#include "base/embedded.h"

extern const nqm_embedded_file nqm_embedded_models[];

#endif
