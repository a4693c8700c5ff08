/* SPDX-License-Identifier: MIT
 *
 * info.h - what `nqm info` does with models. Both return an exit code.
 */
#ifndef NQM_TOOL_INFO_H
#define NQM_TOOL_INFO_H

#include "nqm/tool.h"

/** Print a table of the built-in models, or as JSON all that json_model() has. */
int list_models(bool json);
/** Write a copy of a model whose card ends with a text; `half` also rounds the weights of its hidden layers to 16 bits. */
int annotate_model(const char *name, const char *notes_path, bool half, const char *output);

#endif
