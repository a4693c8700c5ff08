/* SPDX-License-Identifier: MIT
 *
 * json_where.h - byte positions in a JSON text, which jansson does not keep, for messages and for reading a text in
 * parts. The text must be valid JSON, except for nqm_json_outline().
 */
#ifndef NQM_SRC_IO_JSON_WHERE_H
#define NQM_SRC_IO_JSON_WHERE_H

#include <stddef.h>

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
