/* SPDX-License-Identifier: MIT
 *
 * Series: lines, steps and points. All points of a series are one path, which keeps vector files small.
 */
#include "figures/draw.h"

#include <math.h>

static double size_of(const nqm_series *s) {
    return s->size > 0 ? s->size : s->mark == NQM_MARK_POINTS ? 6 : 1.8;
}

static void polygon(cairo_t *cr, double x, double y, double radius, int n_corners, double turn) {
    for (int i = 0; i < n_corners; ++i) {
        double angle = turn + 6.283185307179586 * i / n_corners;
        (i ? cairo_line_to : cairo_move_to)(cr, x + radius * sin(angle), y - radius * cos(angle));
    }
    cairo_close_path(cr);
}

/* The shapes differ as well as the colours. */
static void add_point(cairo_t *cr, size_t style, double x, double y, double size) {
    static const struct {
        int n_corners;
        double turn, grow;
    } shapes[NQM_STYLES] = {{0, 0, 1},
                            {4, 0.7853981633974483, 1.2},
                            {3, 0, 1.3},
                            {4, 0, 1.3},
                            {3, 3.141592653589793, 1.3},
                            {5, 0, 1.2},
                            {6, 0, 1.15},
                            {8, 0, 1.1}};
    if (shapes[style].n_corners == 0) { /* a dot: the round ends of a line without length */
        cairo_move_to(cr, x, y);
        cairo_line_to(cr, x, y);
    } else {
        polygon(cr, x, y, shapes[style].grow * size / 2, shapes[style].n_corners, shapes[style].turn);
    }
}

static void finish_points(cairo_t *cr, const nqm_series *s) {
    nqm_draw_colour(cr, s->style, 0.75);
    if (s->style % NQM_STYLES != 0) {
        cairo_fill(cr);
        return;
    }
    cairo_set_line_cap(cr, CAIRO_LINE_CAP_ROUND);
    cairo_set_line_width(cr, size_of(s));
    cairo_stroke(cr);
}

static void finish_line(cairo_t *cr, const nqm_series *s) {
    static const double dashes[] = {6, 4};
    nqm_draw_colour(cr, s->style, 1);
    cairo_set_line_join(cr, CAIRO_LINE_JOIN_ROUND);
    cairo_set_line_cap(cr, CAIRO_LINE_CAP_BUTT);
    cairo_set_line_width(cr, size_of(s));
    if (s->dashed)
        cairo_set_dash(cr, dashes, 2, 0);
    cairo_stroke(cr);
}

static void add_line(cairo_t *cr, const nqm_series *s, nqm_place_fn place, const void *user) {
    bool begun = false;
    for (size_t i = 0; i < s->n; ++i) {
        double x, y, corner_x, corner_y;
        if (!place(user, s->x[i], s->y[i], &x, &y)) {
            begun = false;
            continue;
        }
        if (begun && s->mark == NQM_MARK_STEPS && place(user, s->x[i], s->y[i - 1], &corner_x, &corner_y))
            cairo_line_to(cr, corner_x, corner_y);
        (begun ? cairo_line_to : cairo_move_to)(cr, x, y);
        begun = true;
    }
}

void nqm_series_draw(cairo_t *cr, const nqm_series *s, nqm_place_fn place, const void *user) {
    cairo_save(cr);
    cairo_new_path(cr);
    if (s->mark != NQM_MARK_POINTS) {
        add_line(cr, s, place, user);
        finish_line(cr, s);
    } else {
        double x, y;
        for (size_t i = 0; i < s->n; ++i)
            if (place(user, s->x[i], s->y[i], &x, &y))
                add_point(cr, s->style % NQM_STYLES, x, y, size_of(s));
        finish_points(cr, s);
    }
    cairo_restore(cr);
}

void nqm_series_sample(cairo_t *cr, const nqm_series *s, nqm_box box) {
    double middle = box.y + box.height / 2;
    cairo_save(cr);
    cairo_new_path(cr);
    if (s->mark == NQM_MARK_POINTS) {
        add_point(cr, s->style % NQM_STYLES, box.x + box.width / 2, middle, fmax(size_of(s), 6));
        finish_points(cr, s);
    } else {
        cairo_move_to(cr, box.x, middle);
        cairo_line_to(cr, box.x + box.width, middle);
        finish_line(cr, s);
    }
    cairo_restore(cr);
}
