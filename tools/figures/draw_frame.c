/* SPDX-License-Identifier: MIT
 *
 * The frame of a chart or heat map: grid, ticks, labels and title.
 */
#include "figures/draw.h"

#include <math.h>

enum { TICK = 4, GAP = 4 };

static size_t ticks_across(double width) {
    return (size_t)fmax(floor(width / 65), 2);
}

size_t nqm_ticks_down(double height) {
    return (size_t)fmax(floor(height / 38), 2);
}

static double widest_label(cairo_t *cr, const nqm_axis *axis, double height) {
    nqm_tick_mark ticks[NQM_MAX_TICKS];
    size_t n = nqm_axis_ticks(axis, nqm_ticks_down(height), ticks);
    double widest = axis->label_width;
    for (size_t i = 0; i < n; ++i)
        widest = fmax(widest, nqm_label_width(cr, ticks[i].label, NQM_SMALL_FONT));
    return ceil(widest);
}

nqm_box nqm_frame_inner(cairo_t *cr, nqm_box outer, const char *title, const nqm_axis *x, const nqm_axis *y) {
    double top = title ? NQM_LINE_STEP + 2 : 8, right = 14;
    double bottom = x ? TICK + GAP + NQM_SMALL_FONT + NQM_LINE_STEP + GAP : 4;
    double left = 4;
    if (y)
        left = TICK + GAP + widest_label(cr, y, outer.height - top - bottom) + (y->label ? NQM_LINE_STEP + GAP : GAP);
    return (nqm_box){floor(outer.x + left) + 0.5, floor(outer.y + top) + 0.5, floor(outer.width - left - right),
                     floor(outer.height - top - bottom)};
}

void nqm_line_draw(cairo_t *cr, double x0, double y0, double x1, double y1) {
    cairo_move_to(cr, x0, y0);
    cairo_line_to(cr, x1, y1);
    cairo_stroke(cr);
}

static void draw_x_ticks(cairo_t *cr, nqm_box box, const nqm_axis *axis) {
    nqm_tick_mark ticks[NQM_MAX_TICKS];
    size_t n = nqm_axis_ticks(axis, ticks_across(box.width), ticks);
    double free_x = -(double)INFINITY;
    for (size_t i = 0; i < n; ++i) {
        double x = floor(box.x + box.width * nqm_axis_place(axis, ticks[i].value)) + 0.5, bottom = box.y + box.height;
        bool has_label = ticks[i].label[0] != 0;
        nqm_draw_grey(cr, has_label ? 0.88 : 0.94);
        nqm_line_draw(cr, x, box.y, x, bottom);
        nqm_draw_grey(cr, 0.2);
        nqm_line_draw(cr, x, bottom, x, bottom + (has_label ? TICK : TICK / 2));
        double half = nqm_label_width(cr, ticks[i].label, NQM_SMALL_FONT) / 2;
        if (!has_label || x - half < free_x)
            continue; /* numbers must not overlap */
        free_x = x + half + GAP;
        nqm_label_draw(cr, x, bottom + TICK + GAP + NQM_SMALL_FONT - 1, NQM_CENTRE, NQM_SMALL_FONT, ticks[i].label);
    }
    if (axis->label)
        nqm_label_draw(cr, box.x + box.width / 2, box.y + box.height + TICK + GAP + NQM_SMALL_FONT + NQM_LINE_STEP - 1,
                       NQM_CENTRE, NQM_FONT, axis->label);
}

static void draw_y_ticks(cairo_t *cr, nqm_box box, const nqm_axis *axis) {
    nqm_tick_mark ticks[NQM_MAX_TICKS];
    size_t n = nqm_axis_ticks(axis, nqm_ticks_down(box.height), ticks);
    for (size_t i = 0; i < n; ++i) {
        double y = floor(box.y + box.height * (1 - nqm_axis_place(axis, ticks[i].value))) + 0.5;
        bool has_label = ticks[i].label[0] != 0;
        nqm_draw_grey(cr, has_label ? 0.88 : 0.94);
        nqm_line_draw(cr, box.x, y, box.x + box.width, y);
        nqm_draw_grey(cr, 0.2);
        nqm_line_draw(cr, box.x - (has_label ? TICK : TICK / 2), y, box.x, y);
        nqm_label_draw(cr, box.x - TICK - GAP, y + 0.36 * NQM_SMALL_FONT, NQM_RIGHT, NQM_SMALL_FONT, ticks[i].label);
    }
    if (axis->label)
        nqm_label_draw_upwards(cr, box.x - TICK - 3 * GAP - widest_label(cr, axis, box.height), box.y + box.height / 2,
                               axis->label);
}

void nqm_frame_draw(cairo_t *cr, nqm_box inner, const char *title, const nqm_axis *x, const nqm_axis *y) {
    cairo_set_line_width(cr, 1);
    if (x)
        draw_x_ticks(cr, inner, x);
    if (y)
        draw_y_ticks(cr, inner, y);
    nqm_draw_grey(cr, 0.2);
    cairo_rectangle(cr, inner.x, inner.y, inner.width, inner.height);
    cairo_stroke(cr);
    if (title)
        nqm_label_draw(cr, inner.x + inner.width / 2, inner.y - 7, NQM_CENTRE, NQM_FONT, title);
}
