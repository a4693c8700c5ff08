/* SPDX-License-Identifier: MIT
 *
 * Horizontal bars in groups, with intervals; and tables.
 */
#include "figures/draw.h"

#include <math.h>

size_t nqm_bar_style(size_t group) {
    return (5 + NQM_STYLES - group % NQM_STYLES) % NQM_STYLES; /* sky blue, orange, purple, ... */
}

static double across(nqm_box box, const nqm_axis *axis, double value) {
    return box.x + box.width * fmin(fmax(nqm_axis_place(axis, value), 0), 1);
}

static void draw_interval(cairo_t *cr, double x0, double x1, double y) {
    nqm_draw_grey(cr, 0.1);
    cairo_set_line_width(cr, 1.2);
    nqm_line_draw(cr, x0, y, x1, y);
    nqm_line_draw(cr, x0, y - 3, x0, y + 3);
    nqm_line_draw(cr, x1, y - 3, x1, y + 3);
}

static void draw_bar(cairo_t *cr, nqm_box box, const nqm_axis *axis, const nqm_bar_row *row, size_t group,
                     nqm_box bar) {
    const double value = row->value[group], low = row->low[group], high = row->high[group];
    double zero = across(box, axis, 0), end = across(box, axis, value);
    double y = bar.y + bar.height / 2, right = fmax(zero, end);
    char text[24];
    nqm_draw_colour(cr, nqm_bar_style(group), 1);
    cairo_rectangle(cr, fmin(zero, end), bar.y, fabs(end - zero), bar.height);
    cairo_fill(cr);
    if (isfinite(low) && isfinite(high)) {
        draw_interval(cr, across(box, axis, low), across(box, axis, high), y);
        right = fmax(right, across(box, axis, high));
    }
    snprintf(text, sizeof text, "%s%.3f", value < 0 ? NQM_MINUS : "", fabs(value));
    nqm_draw_grey(cr, 0.1);
    nqm_label_draw(cr, right + 6, y + 0.36 * NQM_SMALL_FONT, NQM_LEFT, NQM_SMALL_FONT, text);
}

void nqm_bars_draw(cairo_t *cr, nqm_box outer, const nqm_bars *bars) {
    double widest = 0;
    for (size_t i = 0; i < bars->n; ++i)
        widest = fmax(widest, nqm_text_width(cr, bars->rows[i].name, NQM_FONT));
    widest = fmin(widest, outer.width / 3);
    const nqm_box with_names = {outer.x + widest + 8, outer.y, outer.width - widest - 8, outer.height};
    nqm_box box = nqm_frame_inner(cr, with_names, NULL, &bars->x, NULL);
    nqm_frame_draw(cr, box, NULL, &bars->x, NULL);
    double row = box.height / (double)bars->n, bar = 0.76 * row / NQM_BARS;
    size_t place[NQM_BARS], n_groups = 0; /* of a group among those that have bars */
    for (size_t k = 0; k < NQM_BARS; ++k) {
        place[k] = n_groups;
        n_groups += bars->group_names[k] != NULL;
    }
    const double margin = (row - bar * (double)n_groups) / 2;
    for (size_t i = 0; i < bars->n; ++i) {
        double top = box.y + row * (double)i;
        nqm_draw_grey(cr, 0);
        nqm_text_draw(cr, box.x - 8, top + row / 2 + 0.36 * NQM_FONT, NQM_RIGHT, NQM_FONT, widest, bars->rows[i].name);
        for (size_t k = 0; k < NQM_BARS; ++k)
            if (isfinite(bars->rows[i].value[k]))
                draw_bar(cr, box, &bars->x, &bars->rows[i], k,
                         (nqm_box){box.x, top + margin + bar * (double)place[k], 0, bar});
    }
}

static void rule(cairo_t *cr, nqm_box box, double y, double width) {
    nqm_draw_grey(cr, 0.2);
    cairo_set_line_width(cr, width);
    nqm_line_draw(cr, box.x, floor(y) + 0.5, box.x + box.width, floor(y) + 0.5);
}

void nqm_table_draw(cairo_t *cr, nqm_box box, const nqm_table *table) {
    double row = fmin(box.height / (double)table->n_rows, 30);
    rule(cr, box, box.y, 1.5);
    rule(cr, box, box.y + row, 1);
    rule(cr, box, box.y + row * (double)(table->n_rows - 1), 1);
    rule(cr, box, box.y + row * (double)table->n_rows, 1.5);
    for (size_t i = 0; i < table->n_rows; ++i) {
        double x = box.x;
        for (size_t k = 0; k < table->n_columns; ++k) {
            double width = table->widths[k] * box.width;
            bool right = table->right_aligned[k];
            nqm_draw_grey(cr, 0);
            nqm_text_draw(cr, right ? x + width - 10 : x + 10, box.y + row * ((double)i + 0.5) + 0.36 * NQM_FONT,
                          right ? NQM_RIGHT : NQM_LEFT, NQM_FONT, width - 12, table->cells[i * table->n_columns + k]);
            x += width;
        }
    }
}
