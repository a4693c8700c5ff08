/* SPDX-License-Identifier: MIT
 *
 * material_text.h - material files given as text, and what is expected of them. Tests need the fixtures of temp_file.h.
 */
#ifndef NQM_TESTS_SUPPORT_MATERIAL_TEXT_H
#define NQM_TESTS_SUPPORT_MATERIAL_TEXT_H

#include <nqm/material.h>

/** The materials of the text; the test fails when it is an error. */
nqm_materials *open_text(const char *text);
/** The only material of the text has this spec. */
void expect_spec(const char *text, const char *spec);
/** The only material of the text is refused, with this in the reason. */
void expect_refusal(const char *text, const char *reason);
/** The text is an error with this in its message, and has a byte. */
void expect_error(const char *text, nqm_status status, const char *reason);
/** The BRDF written to a file with this extension (without dot) and read back has the same canonical spec. */
void expect_same(const char *argument, const char *extension);
/** Reading fails cleanly whichever allocation fails. */
void expect_survives_no_memory(const char *text);

#endif
