/* SPDX-License-Identifier: MIT
 *
 * Charts: series of lines, steps and points in a Cartesian or a polar frame, and the legend.
 */
#include "figures/draw.h"
#include "math/math.h"

#include <math.h>
#include <string.h>

/* Position on paper of a point of a series; false: none. */
typedef bool (*place_fn)(const void *frame, double x, double y, double *across, double *down);

/* ---- series; each is one path, which keeps vector files small ---------------------------------------------------- */

static double mark_size(const nqm_series *s) {
    return s->size > 0 ? s->size : s->mark == NQM_MARK_POINTS ? 6 : 1.8;
}

/* Styles differ in shape as well as in colour. */
static void add_point(cairo_t *cr, size_t style, double x, double y, double size) {
    static const struct {
        int n_corners;
        double turn, grow;
    } shapes[NQM_STYLES] = {{0, 0, 1},        {4, NQM_PI / 4, 1.2}, {3, 0, 1.3},  {4, 0, 1.3},
                            {3, NQM_PI, 1.3}, {5, 0, 1.2},          {6, 0, 1.15}, {8, 0, 1.1}};
    const double radius = shapes[style].grow * size / 2;
    const int n = shapes[style].n_corners;
    cairo_move_to(cr, x, y);
    if (n == 0) { /* a disc: the round ends of a line without length */
        cairo_line_to(cr, x, y);
        return;
    }
    for (int i = 0; i < n; ++i) {
        double angle = shapes[style].turn + 2 * NQM_PI * i / n;
        (i ? cairo_line_to : cairo_move_to)(cr, x + radius * sin(angle), y - radius * cos(angle));
    }
    cairo_close_path(cr);
}

static void finish_points(cairo_t *cr, const nqm_series *s) {
    nqm_draw_colour(cr, s->style, 0.75);
    if (s->style % NQM_STYLES != 0) {
        cairo_fill(cr);
        return;
    }
    cairo_set_line_cap(cr, CAIRO_LINE_CAP_ROUND);
    cairo_set_line_width(cr, mark_size(s));
    cairo_stroke(cr);
}

static void finish_line(cairo_t *cr, const nqm_series *s) {
    static const struct {
        int n;
        double lengths[4];
    } dashes[NQM_DASHES] = {{0}, {2, {6, 4}}, {2, {2, 2.5}}, {4, {8, 3, 2, 3}}};
    nqm_draw_colour(cr, s->style, 1);
    cairo_set_line_join(cr, CAIRO_LINE_JOIN_ROUND);
    cairo_set_line_cap(cr, CAIRO_LINE_CAP_BUTT);
    cairo_set_line_width(cr, mark_size(s));
    cairo_set_dash(cr, dashes[s->dash].lengths, dashes[s->dash].n, 0);
    cairo_stroke(cr);
}

static void add_line(cairo_t *cr, const nqm_series *s, place_fn place, const void *frame) {
    bool has_begun = false;
    for (size_t i = 0; i < s->n; ++i) {
        double x, y, corner_x, corner_y;
        if (!place(frame, s->x[i], s->y[i], &x, &y)) {
            has_begun = false;
            continue;
        }
        if (has_begun && s->mark == NQM_MARK_STEPS && place(frame, s->x[i], s->y[i - 1], &corner_x, &corner_y))
            cairo_line_to(cr, corner_x, corner_y);
        (has_begun ? cairo_line_to : cairo_move_to)(cr, x, y);
        has_begun = true;
    }
}

static void draw_series(cairo_t *cr, const nqm_series *s, place_fn place, const void *frame) {
    if (s->mark == NQM_MARK_NONE)
        return;
    cairo_save(cr);
    cairo_new_path(cr);
    if (s->mark != NQM_MARK_POINTS) {
        add_line(cr, s, place, frame);
        finish_line(cr, s);
    } else {
        double x, y;
        for (size_t i = 0; i < s->n; ++i)
            if (place(frame, s->x[i], s->y[i], &x, &y))
                add_point(cr, s->style % NQM_STYLES, x, y, mark_size(s));
        finish_points(cr, s);
    }
    cairo_restore(cr);
}

/* ---- polar: the half plane above a surface, with circles at the ticks of the radius ------------------------------ */

typedef struct half_plane {
    const nqm_axis *radius;
    double x, y, length; /* centre; length of the longest radius */
} half_plane;

static bool place_in_half_plane(const void *frame, double degrees, double value, double *across, double *down) {
    const half_plane *p = frame;
    double r = p->length * fmax(nqm_axis_place(p->radius, value), 0), angle = degrees * NQM_PI / 180;
    *across = p->x + r * sin(angle);
    *down = p->y - r * cos(angle);
    return isfinite(r);
}

static void half_circle(cairo_t *cr, const half_plane *p, double radius) {
    cairo_new_path(cr);
    cairo_arc(cr, p->x, p->y, radius, NQM_PI, 0);
    cairo_stroke(cr);
}

static void draw_circles(cairo_t *cr, const half_plane *p) {
    nqm_tick_mark ticks[NQM_MAX_TICKS];
    const double gap = 4;
    double room = INFINITY; /* width for labels, which begin at the outermost */
    for (size_t i = nqm_axis_ticks(p->radius, 4, ticks); i-- > 0;) {
        double radius = p->length * nqm_axis_place(p->radius, ticks[i].value);
        if (!ticks[i].label[0])
            continue;
        nqm_draw_grey(cr, 0.85);
        half_circle(cr, p, radius);
        const double half = nqm_label_width(cr, ticks[i].label, NQM_SMALL_FONT) / 2;
        if (radius + half > room)
            continue;
        room = radius - half - gap;
        nqm_draw_grey(cr, 0.2);
        nqm_label_draw(cr, p->x + radius, p->y + 4 + NQM_SMALL_FONT, NQM_CENTRE, NQM_SMALL_FONT, ticks[i].label);
    }
}

static void draw_spokes(cairo_t *cr, const half_plane *p) {
    static const char *const labels[] = {NQM_MINUS "60" NQM_DEG, NQM_MINUS "30" NQM_DEG, "0" NQM_DEG, "30" NQM_DEG,
                                         "60" NQM_DEG};
    for (int i = -2; i <= 2; ++i) {
        double s = sin(NQM_PI / 6 * i), c = cos(NQM_PI / 6 * i);
        nqm_draw_grey(cr, 0.85);
        nqm_line_draw(cr, p->x, p->y, p->x + p->length * s, p->y - p->length * c);
        nqm_draw_grey(cr, 0.2);
        nqm_label_draw(cr, p->x + (p->length + 12) * s, p->y - (p->length + 4) * c,
                       i < 0   ? NQM_RIGHT
                       : i > 0 ? NQM_LEFT
                               : NQM_CENTRE,
                       NQM_SMALL_FONT, labels[i + 2]);
    }
}

/* An arrow along the light. */
static void draw_light(cairo_t *cr, const half_plane *p, double degrees) {
    double angle = degrees * NQM_PI / 180, s = sin(angle), c = cos(angle), tip = 0.8 * p->length;
    nqm_draw_grey(cr, 0.35);
    cairo_set_line_width(cr, 1.5);
    nqm_line_draw(cr, p->x + s * p->length, p->y - c * p->length, p->x + s * tip, p->y - c * tip);
    cairo_move_to(cr, p->x + s * tip, p->y - c * tip);
    cairo_line_to(cr, p->x + s * (tip + 10) + 4 * c, p->y - c * (tip + 10) + 4 * s);
    cairo_line_to(cr, p->x + s * (tip + 10) - 4 * c, p->y - c * (tip + 10) - 4 * s);
    cairo_close_path(cr);
    cairo_fill(cr);
}

static void draw_polar(cairo_t *cr, nqm_box box, const nqm_chart *chart) {
    double top = (chart->title ? NQM_LINE_STEP + 2 : 4) + NQM_LINE_STEP, bottom = 2 * NQM_LINE_STEP + 8;
    half_plane p = {.radius = &chart->y, .x = box.x + box.width / 2};
    p.length = floor(fmax(fmin(box.width / 2 - 30, box.height - top - bottom), 20));
    p.y = floor(box.y + top + p.length + fmax(box.height - top - bottom - p.length, 0) / 2) + 0.5;
    cairo_set_line_width(cr, 1);
    draw_spokes(cr, &p);
    draw_circles(cr, &p);
    nqm_draw_grey(cr, 0.2);
    half_circle(cr, &p, p.length);
    nqm_line_draw(cr, p.x - p.length, p.y, p.x + p.length, p.y);
    draw_light(cr, &p, chart->light_deg);
    for (size_t i = 0; i < chart->n_series; ++i)
        draw_series(cr, &chart->series[i], place_in_half_plane, &p);
    nqm_draw_grey(cr, 0.2);
    if (chart->title)
        nqm_label_draw(cr, p.x, p.y - p.length - NQM_LINE_STEP - 7, NQM_CENTRE, NQM_FONT, chart->title);
    if (chart->y.label)
        nqm_label_draw(cr, p.x, p.y + 2 * NQM_LINE_STEP, NQM_CENTRE, NQM_FONT, chart->y.label);
}

/* ---- Cartesian --------------------------------------------------------------------------------------------------- */

typedef struct plane {
    const nqm_chart *chart;
    nqm_box box;
} plane;

static bool place_in_plane(const void *frame, double x, double y, double *across, double *down) {
    const plane *p = frame;
    double u = nqm_axis_place(&p->chart->x, x), v = nqm_axis_place(&p->chart->y, y);
    *across = p->box.x + p->box.width * u;
    *down = p->box.y + p->box.height * (1 - v);
    return fabs(u) < 100 && fabs(v) < 100; /* cairo's coordinates overflow far outside of the paper */
}

void nqm_chart_draw(cairo_t *cr, nqm_box outer, const nqm_chart *chart) {
    if (chart->polar) {
        draw_polar(cr, outer, chart);
        return;
    }
    const plane p = {chart, nqm_frame_inner(cr, outer, chart->title, &chart->x, &chart->y)};
    nqm_frame_draw(cr, p.box, chart->title, &chart->x, &chart->y);
    for (size_t i = 0; i < chart->n_series; ++i) {
        const nqm_series *s = &chart->series[i];
        double margin = s->mark == NQM_MARK_POINTS ? 4 : 0;
        cairo_save(cr);
        cairo_rectangle(cr, p.box.x - margin, p.box.y - margin, p.box.width + 2 * margin, p.box.height + 2 * margin);
        cairo_clip(cr);
        draw_series(cr, s, place_in_plane, &p);
        cairo_restore(cr);
    }
}

/* ---- legend ------------------------------------------------------------------------------------------------------ */

enum { SAMPLE = 26, SPACE = 18 };

typedef struct legend {
    cairo_t *cr;
    nqm_box box;
    double x, y; /* top left of the next entry */
} legend;

static void draw_sample(cairo_t *cr, const nqm_series *s, nqm_box box) {
    double middle = box.y + box.height / 2;
    cairo_save(cr);
    cairo_new_path(cr);
    if (s->mark == NQM_MARK_POINTS) {
        add_point(cr, s->style % NQM_STYLES, box.x + box.width / 2, middle, fmax(mark_size(s), 6));
        finish_points(cr, s);
    } else {
        cairo_move_to(cr, box.x, middle);
        cairo_line_to(cr, box.x + box.width, middle);
        finish_line(cr, s);
    }
    cairo_restore(cr);
}

static void add_entry(legend *l, const nqm_series *sample, const char *name) {
    const bool has_sample = sample->mark != NQM_MARK_NONE;
    const double indent = has_sample ? SAMPLE + 5 : 0;
    double width = indent + nqm_label_width(l->cr, name, NQM_FONT) + SPACE;
    if (l->x > l->box.x && l->x + width - SPACE > l->box.x + l->box.width) {
        l->x = l->box.x;
        l->y += NQM_LINE_STEP;
    }
    if (has_sample)
        draw_sample(l->cr, sample, (nqm_box){l->x, l->y, SAMPLE, NQM_LINE_STEP});
    nqm_draw_grey(l->cr, 0);
    nqm_label_draw(l->cr, l->x + indent, l->y + 13, NQM_LEFT, NQM_FONT, name);
    l->x += width;
}

/* Whether a series before this one has the same name. */
static bool has_entry(const nqm_sheet *sheet, const nqm_series *series) {
    for (size_t i = 0; i < sheet->n_rows * sheet->n_columns; ++i) {
        const nqm_chart *chart = sheet->panels[i].chart;
        for (size_t k = 0; chart && k < chart->n_series; ++k) {
            if (&chart->series[k] == series)
                return false;
            if (chart->series[k].name && strcmp(chart->series[k].name, series->name) == 0)
                return true;
        }
    }
    return false;
}

double nqm_legend_draw(cairo_t *cr, nqm_box box, const nqm_sheet *sheet) {
    legend l = {cr, box, box.x, box.y};
    for (size_t i = 0; i < sheet->n_rows * sheet->n_columns; ++i) {
        const nqm_chart *chart = sheet->panels[i].chart;
        const nqm_bars *bars = sheet->panels[i].bars;
        for (size_t k = 0; chart && k < chart->n_series; ++k)
            if (chart->series[k].name && !has_entry(sheet, &chart->series[k]))
                add_entry(&l, &chart->series[k], chart->series[k].name);
        for (size_t k = 0; bars && k < NQM_BARS; ++k)
            if (bars->group_names[k])
                add_entry(&l, &(nqm_series){.style = nqm_bar_style(k), .size = 9}, bars->group_names[k]);
    }
    return l.x > box.x || l.y > box.y ? l.y - box.y + NQM_LINE_STEP + 4 : 0;
}
