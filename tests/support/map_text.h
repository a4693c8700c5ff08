/* SPDX-License-Identifier: MIT
 *
 * map_text.h - what is computed from image maps, as text: "maximum(luminance(image(r.png repeat)), 0.0001)".
 */
#ifndef NQM_TESTS_SUPPORT_MAP_TEXT_H
#define NQM_TESTS_SUPPORT_MAP_TEXT_H

#include "material/maps.h"

enum { MAP_TEXT = 1000 };
/** What a key, or "normal", is computed from; "": nothing. An image has its name, its colour space and how it continues along u and v; a
 *  channel its number. */
void describe_map(const nqm_textured *t, const char *key, char text[MAP_TEXT]);

#endif
