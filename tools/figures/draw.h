/* SPDX-License-Identifier: MIT
 *
 * draw.h - the parts of a sheet (sheet.h) on a cairo surface. Lengths are CSS pixels, y points down.
 */
#ifndef NQM_FIGURES_DRAW_H
#define NQM_FIGURES_DRAW_H

#include "figures/sheet.h"

#include <cairo.h>

enum { NQM_FONT = 13, NQM_SMALL_FONT = 11, NQM_TITLE_FONT = 15, NQM_LINE_STEP = 18, NQM_STYLES = 8 };

typedef struct nqm_box {
    double x, y, width, height;
} nqm_box;

/* ---- text and colours (lettering.c) ------------------------------------------------------------------------------ */

/** Draw with the colour of a style, or with a grey (0 black, 1 white). */
void nqm_draw_colour(cairo_t *cr, size_t style, double alpha);
void nqm_draw_grey(cairo_t *cr, double level);

typedef enum nqm_align { NQM_LEFT, NQM_CENTRE, NQM_RIGHT } nqm_align;

/** Width of a line of UTF-8 text, of which the first 252 bytes are drawn; `size` is the size of the font in pixels. */
double nqm_text_width(cairo_t *cr, const char *text, double size);
/** Draw a line of text with its baseline at y, aligned at x. Text wider than `room` gets a smaller font, down to two thirds,
 *  and is then cut and ends in dots. Bytes that are not UTF-8 are drawn as '?'. */
void nqm_text_draw(cairo_t *cr, double x, double y, nqm_align align, double size, double room, const char *text);
/** The same for labels with subscripts and superscripts, in the room that they need. */
double nqm_label_width(cairo_t *cr, const char *text, double size);
void nqm_label_draw(cairo_t *cr, double x, double y, nqm_align align, double size, const char *text);
/** A label from bottom to top, centred at (x, y). */
void nqm_label_draw_upwards(cairo_t *cr, double x, double y, const char *text);

/* ---- frames (draw_frame.c) --------------------------------------------------------------------------------------- */

void nqm_line_draw(cairo_t *cr, double x0, double y0, double x1, double y1);
/** The plot area of a box without ticks, labels and title; x or y NULL: no such axis. */
nqm_box nqm_frame_inner(cairo_t *cr, nqm_box outer, const char *title, const nqm_axis *x, const nqm_axis *y);
/** Grid, frame, ticks, labels and title around the plot area. */
void nqm_frame_draw(cairo_t *cr, nqm_box inner, const char *title, const nqm_axis *x, const nqm_axis *y);
/** How many labelled ticks fit into a height. */
size_t nqm_ticks_down(double height);

/* ---- panels ------------------------------------------------------------------------------------------------------ */

void nqm_chart_draw(cairo_t *cr, nqm_box box, const nqm_chart *chart);
void nqm_heat_draw(cairo_t *cr, nqm_box box, const nqm_heat *heat);
/** The colours of an axis from bottom to top. */
void nqm_colour_bar_draw(cairo_t *cr, nqm_box bar, const nqm_axis *axis);
void nqm_bars_draw(cairo_t *cr, nqm_box box, const nqm_bars *bars);
/** The style of a group of bars: light colours, on which intervals are visible. */
size_t nqm_bar_style(size_t group);
void nqm_table_draw(cairo_t *cr, nqm_box box, const nqm_table *table);
/** The legend of all panels, in lines from the top of the box; returns their height. */
double nqm_legend_draw(cairo_t *cr, nqm_box box, const nqm_sheet *sheet);

/** Write an image surface as PNG. */
NQM_MUST_CHECK nqm_status nqm_surface_write_png(const char *path, cairo_surface_t *surface, nqm_error *err);

#endif
