/* SPDX-License-Identifier: MIT
 *
 * options_json.h - converts an options struct that has a table (base/options.h) to JSON, JSON to text, and text to JSON.
 */
#ifndef NQM_SRC_IO_OPTIONS_JSON_H
#define NQM_SRC_IO_OPTIONS_JSON_H

#include "base/options.h"
#include <jansson.h>

/** The stored options in the order of the table: numbers, booleans, strings, arrays; a uint64_t is a string, because
 *  jansson's integers are signed and have 64 bits. json_decref(); NULL: out of memory. */
json_t *nqm_json_from_options(const nqm_option_table *table, const void *options);
/** Compact text of a value, whose reference is released, with n_digits (1..17) digits of its numbers; nqm_free(). NULL: out
 *  of memory, or json is NULL. */
char *nqm_json_text(json_t *json, size_t n_digits);
/** From here on this thread sees failed allocations of jansson, whose writers leave out what they have no memory for. */
void nqm_json_watch(void);
/** Whether one failed since nqm_json_watch() or the last nqm_json_load() of this thread: what was made in between is incomplete. */
bool nqm_json_has_failed(void);
/** Where a JSON text is. */
typedef struct nqm_json_place {
    const char *name;
    size_t n_file, byte;
} nqm_json_place;
/** json_loadb(), which alone would take a failed allocation for a damaged text, or leave out a character.
 *  NQM_ERR_FORMAT: the caller knows where the text is, and `why` (NULL allowed) says what is wrong; NQM_ERR_NOMEM.
 *  json_decref(); NULL on failure. */
NQM_MUST_CHECK nqm_status nqm_json_load(const char *text, size_t n_bytes, size_t flags, json_t **json_ret,
                                        json_error_t *why, nqm_error *err);
/** The same for a text at a byte of the file `name`, which has n_file bytes, after nqm_json_check(); messages say where
 *  it is wrong. */
NQM_MUST_CHECK nqm_status nqm_json_read(const char *text, size_t n_bytes, size_t flags, const nqm_json_place *at,
                                        json_t **json_ret, nqm_error *err);
/** The same for a text that may be missing: *json_ret is NULL for NULL and for what is no JSON. NQM_ERR_NOMEM. */
NQM_MUST_CHECK nqm_status nqm_json_parse(const char *text, json_t **json_ret, nqm_error *err);

#endif
