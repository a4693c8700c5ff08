/* SPDX-License-Identifier: MIT
 *
 * map_text.h - what is computed for textured materials, as text. Tests need the fixtures of temp_file.h.
 */
#ifndef NQM_TESTS_SUPPORT_MAP_TEXT_H
#define NQM_TESTS_SUPPORT_MAP_TEXT_H

#include "material/maps.h"

/** The material i of the text is textured, has no BRDF for a reason that contains `reason`, and the key (or "normal")
 *  has this value: "multiply(image(a.png srgb_texture repeat), 2)". */
void expect_map(const char *text, size_t i, const char *reason, const char *key, const char *value);
/** The only image of the only material of the text is at (x, y) from its upper left corner where the surface has (u, v), v
 *  downwards. */
void expect_position(const char *text, double u, double v, double x, double y);

#endif
