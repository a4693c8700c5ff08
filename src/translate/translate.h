/* SPDX-License-Identifier: MIT
 *
 * translate.h - the properties that two shading models share.
 */
#ifndef NQM_SRC_TRANSLATE_H
#define NQM_SRC_TRANSLATE_H

#include "schema/schema.h"
#include <nqm/translate.h>

/** The key of `to` that means the same as a key of `from`; to->n_keys: none. */
size_t nqm_translate_key(const nqm_schema *from, size_t key, const nqm_schema *to);
/** The values of a key for one that means the same: a number for all channels of a colour, the mean of a colour or of two widths for
 *  a number; in its unit and range. */
void nqm_translate_value(const nqm_schema_key *from, const double v[3], const nqm_schema_key *to, double out[3]);
/** Give `to`, which has its schema, the shared values; none is given: nothing is shared, or required keys are missing. */
void nqm_translate_values(const nqm_values *from, nqm_values *to);
/** Append the keys with other values than their defaults that have no counterpart in `to`, unless they are there, separated by
 *  ", ". Keys of layers that are off do not count. */
void nqm_translate_list_dropped(const nqm_values *from, const nqm_schema *to, char *text, size_t n_text);
/** Append a key. */
void nqm_translate_drop(const char *key, char *text, size_t n_text);

#endif
