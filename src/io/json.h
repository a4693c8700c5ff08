/* SPDX-License-Identifier: MIT
 *
 * json.h - JSON by jansson: texts whose tree fits in memory; options structs that have a table (base/options.h); and positions in a
 * text, which jansson does not keep.
 */
#ifndef NQM_SRC_IO_JSON_H
#define NQM_SRC_IO_JSON_H

#include "base/options.h"
#include <jansson.h>

/** Fail with NQM_ERR_LIMIT if the tree of the text, read by jansson, would take more than NQM_JSON_ROOM bytes and eight
 *  times n_file, the size of the file with the text. To be called before the text is parsed. name, byte: of the file,
 *  and the text's place in it, for messages. */
NQM_MUST_CHECK nqm_status nqm_json_check(const char *text, size_t n_bytes, size_t n_file, const char *name, size_t byte,
                                         nqm_error *err);
enum { NQM_JSON_ROOM = 512 << 10 };
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

/* ---- positions: the text is valid JSON, except for nqm_json_outline() --------------------------------------------- */

/** A JSON text. */
typedef struct nqm_json_source {
    const char *text;
    size_t n;
} nqm_json_source;

/** The position of the value that is the whole text. */
size_t nqm_json_begin(const nqm_json_source *json);
/** The position of the first element of the array at `at`, or of the element after the one at `at`; SIZE_MAX: none. */
size_t nqm_json_first(const nqm_json_source *json, size_t at);
size_t nqm_json_next(const nqm_json_source *json, size_t at);
/** The end of the value at `at`. */
size_t nqm_json_end(const nqm_json_source *json, size_t at);
/** Copy the text to outline (n bytes), where each array and object inside a member of the root is 0 and blanks: the
 *  same positions, but a small tree. */
void nqm_json_outline(const nqm_json_source *json, char *outline);
/** Follow a path of member names with dots ("extensions.KHR_materials_ior"), as far as it goes. */
size_t nqm_json_path(const nqm_json_source *json, size_t at, const char *path);

#endif
