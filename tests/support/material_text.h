/* SPDX-License-Identifier: MIT
 *
 * material_text.h - material files in memory. Rows of vectors/materials.txt need nothing of this.
 */
#ifndef NQM_TESTS_SUPPORT_MATERIAL_TEXT_H
#define NQM_TESTS_SUPPORT_MATERIAL_TEXT_H

#include "material/material.h"

/** The materials of a file with these bytes, or this text; the test fails when it is an error. */
nqm_materials *bytes_as_materials(const char *path, const void *data, size_t n);
nqm_materials *text_as_materials(const char *path, const char *text);
/** The bytes are an error at this byte (-1: any), with the words in its message. */
void refuse_bytes(const char *path, const void *data, size_t n, nqm_status status, int64_t byte, const char *words);

#endif
