/* SPDX-License-Identifier: MIT
 *
 * lettering.h - text on a cairo surface from the outlines of glyphs.h, without any of the machine's fonts.
 */
#ifndef NQM_SRC_PLOT_LETTERING_H
#define NQM_SRC_PLOT_LETTERING_H

#include <cairo.h>
#include <stdbool.h>

/** Width of a line of UTF-8 text at `size` (units of the surface an em). */
double nqm_text_width(const char *text, double size);

typedef enum nqm_align { NQM_LEFT, NQM_CENTRE, NQM_RIGHT } nqm_align;

/** Draw a line of text with its baseline at y, aligned at x. Where it is wider than `room` it is made smaller, down to
 *  two thirds, then cut, with dots. Characters without an outline are drawn as '?'. */
void nqm_text_draw(cairo_t *cr, double x, double y, nqm_align align, double size, double room, const char *text);

#endif
