/* SPDX-License-Identifier: MIT
 *
 * presets_data.h - the CSV tables of presets/ as text, generated into the build folder by cmake/presets.cmake.
 */
#ifndef NQM_SRC_BRDF_PRESETS_DATA_H
#define NQM_SRC_BRDF_PRESETS_DATA_H

#include <stddef.h>

typedef struct nqm_preset_table {
    const char *name;  /**< file name without ending: "sgd", "low-cook-torrance-e1"; NULL ends the array */
    const char *model; /**< the model of the rows; their parameters are in the order of its schema */
    const char *doi;   /**< DOI of the publication of the parameters */
    const char *text;  /**< the CSV: '#' lines, a header, rows of a name and values; no quoting */
} nqm_preset_table;

extern const nqm_preset_table nqm_preset_tables[];

/** Every row as "TABLE:NAME", in the order of the tables. */
extern const char *const nqm_preset_names[];
extern const size_t nqm_preset_name_count;

#endif
