/* SPDX-License-Identifier: MIT
 *
 * Heat maps in the colours of viridis, with a colour scale at the right.
 */
#include "figures/draw.h"

#include <math.h>
#include <string.h>

static void viridis_bytes(double t, unsigned char bytes[3]) {
    double rgb[3];
    nqm_viridis(t, rgb);
    for (size_t k = 0; k < 3; ++k)
        bytes[k] = nqm_srgb_byte(rgb[k]);
}

/* The map as an image with FINE x FINE pixels per cell, so that no viewer blurs the cells; NaN is transparent. */
enum { FINE = 8 };

static void fill_picture(cairo_surface_t *picture, const nqm_heat *heat) {
    unsigned char *data = cairo_image_surface_get_data(picture);
    size_t stride = (size_t)cairo_image_surface_get_stride(picture);
    for (size_t i = 0; i < FINE * heat->n_rows * FINE * heat->n_columns; ++i) {
        size_t x = i % (FINE * heat->n_columns), y = i / (FINE * heat->n_columns);
        size_t row = heat->n_rows - 1 - y / FINE;
        double t = nqm_axis_place(&heat->value, heat->values[row * heat->n_columns + x / FINE]);
        unsigned char c[3];
        viridis_bytes(isnan(t) ? 0 : t, c);
        uint32_t pixel =
            isnan(t) ? 0 : UINT32_C(0xff000000) | (uint32_t)c[0] << 16 | (uint32_t)c[1] << 8 | (uint32_t)c[2];
        memcpy(data + y * stride + 4 * x, &pixel, sizeof pixel);
    }
}

static void draw_cells(cairo_t *cr, nqm_box box, const nqm_heat *heat) {
    int width = (int)(FINE * heat->n_columns), height = (int)(FINE * heat->n_rows);
    cairo_surface_t *picture = cairo_image_surface_create(CAIRO_FORMAT_ARGB32, width, height);
    if (cairo_surface_status(picture) == CAIRO_STATUS_SUCCESS) {
        cairo_surface_flush(picture);
        fill_picture(picture, heat);
        cairo_surface_mark_dirty(picture);
    }
    cairo_save(cr);
    cairo_translate(cr, box.x, box.y);
    cairo_scale(cr, box.width / width, box.height / height);
    cairo_set_source_surface(cr, picture, 0, 0); /* takes over the error of a failed surface */
    cairo_pattern_set_filter(cairo_get_source(cr), CAIRO_FILTER_NEAREST);
    cairo_paint(cr);
    cairo_restore(cr);
    cairo_surface_destroy(picture);
}

void nqm_colour_bar_draw(cairo_t *cr, nqm_box bar, const nqm_axis *axis) {
    enum { N_STEPS = 128 };
    double ramp[N_STEPS];
    for (int i = 0; i < N_STEPS; ++i)
        ramp[i] = axis->min + (axis->max - axis->min) * (i + 0.5) / N_STEPS;
    draw_cells(cr, bar, &(nqm_heat){.value = *axis, .n_columns = 1, .n_rows = N_STEPS, .values = ramp});
}

static void draw_scale(cairo_t *cr, nqm_box bar, const nqm_axis *axis) {
    nqm_colour_bar_draw(cr, bar, axis);
    nqm_tick_mark ticks[NQM_MAX_TICKS];
    size_t n = nqm_axis_ticks(axis, nqm_ticks_down(bar.height), ticks);
    double widest = 0;
    nqm_draw_grey(cr, 0.2);
    for (size_t i = 0; i < n; ++i) {
        double y = bar.y + bar.height * (1 - nqm_axis_place(axis, ticks[i].value));
        nqm_line_draw(cr, bar.x + bar.width, y, bar.x + bar.width + 4, y);
        nqm_label_draw(cr, bar.x + bar.width + 7, y + 0.36 * NQM_SMALL_FONT, NQM_LEFT, NQM_SMALL_FONT, ticks[i].label);
        widest = fmax(widest, nqm_label_width(cr, ticks[i].label, NQM_SMALL_FONT));
    }
    cairo_rectangle(cr, bar.x, bar.y, bar.width, bar.height);
    cairo_stroke(cr);
    nqm_label_draw_upwards(cr, bar.x + bar.width + 7 + widest + 6 + NQM_FONT, bar.y + bar.height / 2, axis->label);
}

void nqm_heat_draw(cairo_t *cr, nqm_box outer, const nqm_heat *heat) {
    enum { SCALE_ROOM = 90, SCALE_WIDTH = 16 };
    outer.width -= SCALE_ROOM;
    nqm_box box = nqm_frame_inner(cr, outer, NULL, &heat->x, &heat->y);
    nqm_frame_draw(cr, box, NULL, &heat->x, &heat->y);
    draw_cells(cr, box, heat);
    nqm_draw_grey(cr, 0.2);
    cairo_rectangle(cr, box.x, box.y, box.width, box.height);
    cairo_stroke(cr);
    draw_scale(cr, (nqm_box){box.x + box.width + 16, box.y, SCALE_WIDTH, box.height}, &heat->value);
}
