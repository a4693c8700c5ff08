/* SPDX-License-Identifier: MIT
 *
 * options_json.h - an options struct with a table (base/options.h) as JSON.
 */
#ifndef NQM_SRC_IO_OPTIONS_JSON_H
#define NQM_SRC_IO_OPTIONS_JSON_H

#include "base/options.h"
#include <jansson.h>

/** The stored options in the order of the table: numbers, booleans, words, arrays; a uint64_t is a string, since a JSON
 *  integer of jansson has 63 bits. json_decref(); NULL: out of memory. */
json_t *nqm_options_json(const nqm_option_table *table, const void *options);

#endif
