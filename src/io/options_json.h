/* SPDX-License-Identifier: MIT
 *
 * options_json.h - converts an options struct that has a table (base/options.h) to JSON, and JSON to text.
 */
#ifndef NQM_SRC_IO_OPTIONS_JSON_H
#define NQM_SRC_IO_OPTIONS_JSON_H

#include "base/options.h"
#include <jansson.h>

/** The stored options in the order of the table: numbers, booleans, strings, arrays; a uint64_t is a string, because
 *  jansson's integers are signed and have 64 bits. json_decref(); NULL: out of memory. */
json_t *nqm_options_json(const nqm_option_table *table, const void *options);
/** Compact text of a value, whose reference is released, with n_digits (1..17) digits of its numbers; nqm_free(). NULL: out
 *  of memory, or json is NULL. */
char *nqm_json_text(json_t *json, size_t n_digits);

#endif
