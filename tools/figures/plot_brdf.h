/* SPDX-License-Identifier: MIT
 *
 * plot_brdf.h - what the drawings of BRDFs share.
 */
#ifndef NQM_SRC_PLOT_BRDF_H
#define NQM_SRC_PLOT_BRDF_H

#include "figures/sheet.h"

/** A short name for the legend: of a path the file without folder and ending, of a spec the whole, at most 60 bytes. */
void nqm_plot_brdf_name(const nqm_brdf *brdf, char name[64]);

#endif
