/* SPDX-License-Identifier: MIT
 *
 * presets_data.h - the CSV tables of presets/ as text, generated into the build folder by cmake/presets.cmake.
 */
#ifndef NQM_SRC_BRDF_PRESETS_DATA_H
#define NQM_SRC_BRDF_PRESETS_DATA_H

typedef struct nqm_preset_table {
    const char *model; /**< file name without ending = model name: "sgd", "ward"; NULL ends the array */
    const char *text;  /**< the CSV */
} nqm_preset_table;

extern const nqm_preset_table nqm_preset_tables[];

#endif
