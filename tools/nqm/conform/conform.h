/* SPDX-License-Identifier: MIT
 *
 * conform.h - values of somebody's shader for `nqm conform` (values.c). On failure, these report the error and exit.
 */
#ifndef NQM_TOOL_CONFORM_H
#define NQM_TOOL_CONFORM_H

#include "nqm/tool.h"
#include <nqm/conform.h>

/** Values of all sets, (n_sets, n_directions, 3) float; free() it. path: a CSV with the columns r, g, b, or an array of NumPy. */
float *read_results(const nqm_conform_kit *kit, const char *path);
/** The same from a command of the shell, which gets the rows of the kit and prints such a CSV. */
float *run_command(const nqm_conform_kit *kit, const char *line);

#endif
