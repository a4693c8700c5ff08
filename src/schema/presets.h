/* SPDX-License-Identifier: MIT
 *
 * presets.h - published parameters of measured materials by name.
 */
#ifndef NQM_SRC_BRDF_PRESETS_H
#define NQM_SRC_BRDF_PRESETS_H

#include "schema/schema.h"

/** A table of presets/, embedded by cmake/presets.cmake. */
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

/** "sgd:nickel" for "nickel": a preset of this material, of the table sgd if it is there; NULL: none. */
const char *nqm_preset_named(const char *material);
/** "ward:nickel" for "ward-nickel", "ward_nickel", "ward.nickel" or "ward nickel"; NULL: the text is no such preset. */
const char *nqm_preset_without_colon(const char *text);
/** Offer the materials of all presets, without their tables. */
void nqm_preset_nearest(nqm_nearest *nearest);
/** A table of presets, or NULL. */
const nqm_preset_table *nqm_preset_table_find(const char *name, size_t n_name);
/** Values of a published material in a table of `schema`'s model; NQM_ERR_ARG suggests similar names. */
NQM_MUST_CHECK nqm_status nqm_preset_find(const nqm_preset_table *table, const nqm_schema *schema, const char *material,
                                          nqm_values *values, nqm_error *err);

#endif
