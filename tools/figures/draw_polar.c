/* SPDX-License-Identifier: MIT
 *
 * Polar charts: the upper half plane about a surface, with circles at the ticks of the radius.
 */
#include "figures/draw.h"

#include <math.h>

typedef struct half_plane {
    const nqm_axis *radius;
    double x, y, length; /* of the foot, and of the longest radius */
} half_plane;

static bool place_in_half_plane(const void *user, double degrees, double value, double *across, double *down) {
    const half_plane *p = user;
    double r = p->length * fmax(nqm_axis_place(p->radius, value), 0), angle = degrees * 0.017453292519943295;
    *across = p->x + r * sin(angle);
    *down = p->y - r * cos(angle);
    return isfinite(r);
}

static void circle(cairo_t *cr, const half_plane *p, double share) {
    cairo_new_path(cr);
    cairo_arc(cr, p->x, p->y, share * p->length, 3.141592653589793, 0);
    cairo_stroke(cr);
}

static void draw_circles(cairo_t *cr, const half_plane *p) {
    nqm_tick_mark ticks[NQM_MAX_TICKS];
    size_t n = nqm_axis_ticks(p->radius, 4, ticks);
    for (size_t i = 0; i < n; ++i) {
        double share = nqm_axis_place(p->radius, ticks[i].value);
        if (!ticks[i].label[0])
            continue;
        nqm_draw_grey(cr, 0.85);
        circle(cr, p, share);
        nqm_draw_grey(cr, 0.2);
        nqm_label_draw(cr, p->x + share * p->length, p->y + 4 + NQM_SMALL_FONT, NQM_CENTRE, NQM_SMALL_FONT,
                       ticks[i].label);
    }
}

static void draw_spokes(cairo_t *cr, const half_plane *p) {
    static const char *const names[] = {"\xe2\x88\x92"
                                        "90\xc2\xb0",
                                        "\xe2\x88\x92"
                                        "60\xc2\xb0",
                                        "\xe2\x88\x92"
                                        "30\xc2\xb0",
                                        "0\xc2\xb0",
                                        "30\xc2\xb0",
                                        "60\xc2\xb0",
                                        "90\xc2\xb0"};
    for (int i = -3; i <= 3; ++i) {
        double angle = 0.5235987755982988 * i, across = sin(angle), up = cos(angle);
        nqm_draw_grey(cr, 0.85);
        cairo_move_to(cr, p->x, p->y);
        cairo_line_to(cr, p->x + p->length * across, p->y - p->length * up);
        cairo_stroke(cr);
        nqm_draw_grey(cr, 0.2);
        if (i > -3 && i < 3)
            nqm_label_draw(cr, p->x + (p->length + 12) * across, p->y - (p->length + 4) * up,
                           i < 0   ? NQM_RIGHT
                           : i > 0 ? NQM_LEFT
                                   : NQM_CENTRE,
                           NQM_SMALL_FONT, names[i + 3]);
    }
}

/* An arrow that comes in along the light. */
static void draw_light(cairo_t *cr, const half_plane *p, double degrees) {
    double angle = degrees * 0.017453292519943295, s = sin(angle), c = cos(angle), tip = 0.8 * p->length;
    nqm_draw_grey(cr, 0.35);
    cairo_set_line_width(cr, 1.5);
    cairo_move_to(cr, p->x + s * p->length, p->y - c * p->length);
    cairo_line_to(cr, p->x + s * tip, p->y - c * tip);
    cairo_stroke(cr);
    cairo_move_to(cr, p->x + s * tip, p->y - c * tip);
    cairo_line_to(cr, p->x + s * (tip + 10) + 4 * c, p->y - c * (tip + 10) + 4 * s);
    cairo_line_to(cr, p->x + s * (tip + 10) - 4 * c, p->y - c * (tip + 10) - 4 * s);
    cairo_close_path(cr);
    cairo_fill(cr);
}

void nqm_polar_draw(cairo_t *cr, nqm_box box, const nqm_chart *chart) {
    double top = (chart->title ? NQM_LINE_STEP + 2 : 4) + NQM_LINE_STEP, bottom = 2 * NQM_LINE_STEP + 8;
    half_plane p = {.radius = &chart->y, .x = box.x + box.width / 2};
    p.length = floor(fmax(fmin(box.width / 2 - 30, box.height - top - bottom), 20));
    p.y = floor(box.y + top + p.length + fmax(box.height - top - bottom - p.length, 0) / 2) + 0.5;
    cairo_set_line_width(cr, 1);
    draw_spokes(cr, &p);
    draw_circles(cr, &p);
    nqm_draw_grey(cr, 0.2);
    circle(cr, &p, 1);
    cairo_move_to(cr, p.x - p.length, p.y);
    cairo_line_to(cr, p.x + p.length, p.y);
    cairo_stroke(cr);
    draw_light(cr, &p, chart->light_deg);
    for (size_t i = 0; i < chart->n_series; ++i)
        nqm_series_draw(cr, &chart->series[i], place_in_half_plane, &p);
    nqm_draw_grey(cr, 0.2);
    if (chart->title)
        nqm_label_draw(cr, p.x, p.y - p.length - NQM_LINE_STEP - 7, NQM_CENTRE, NQM_FONT, chart->title);
    if (chart->y.label)
        nqm_label_draw(cr, p.x, p.y + 2 * NQM_LINE_STEP, NQM_CENTRE, NQM_FONT, chart->y.label);
}
