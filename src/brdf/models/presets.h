/* SPDX-License-Identifier: MIT
 *
 * presets.h - published parameters of measured materials by name.
 */
#ifndef NQM_SRC_BRDF_PRESETS_H
#define NQM_SRC_BRDF_PRESETS_H

#include "brdf/core/spec.h"
#include "brdf/models/presets_data.h"

/** "sgd:nickel" for "nickel": a preset of this material, of the table sgd if it is there; NULL: none. */
const char *nqm_preset_named(const char *material);
/** "ward:nickel" for "ward-nickel", "ward_nickel", "ward.nickel" or "ward nickel"; NULL: the text is no such preset. */
const char *nqm_preset_without_colon(const char *text);
/** Offer the materials of all presets, without their tables. */
void nqm_preset_nearest(nqm_nearest *nearest);
/** A table of presets, or NULL. */
const nqm_preset_table *nqm_preset_table_find(const char *name, size_t n_name);
/** Values of a published material in a table of `schema`'s model; NQM_ERR_ARG suggests similar names. */
NQM_MUST_CHECK nqm_status nqm_preset_find(const nqm_preset_table *table, const nqm_spec_schema *schema,
                                          const char *material, nqm_spec_values *values, nqm_error *err);

#endif
