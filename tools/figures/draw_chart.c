/* SPDX-License-Identifier: MIT
 *
 * Charts in a frame, and the legend of a sheet.
 */
#include "figures/draw.h"

#include <math.h>
#include <string.h>

typedef struct plane {
    const nqm_chart *chart;
    nqm_box box;
} plane;

static bool place_in_plane(const void *user, double x, double y, double *across, double *down) {
    const plane *p = user;
    double u = nqm_axis_place(&p->chart->x, x), v = nqm_axis_place(&p->chart->y, y);
    *across = p->box.x + p->box.width * u;
    *down = p->box.y + p->box.height * (1 - v);
    return fabs(u) < 100 && fabs(v) < 100; /* what is far off the paper has no place */
}

static void clip_to(cairo_t *cr, nqm_box box, double margin) {
    cairo_rectangle(cr, box.x - margin, box.y - margin, box.width + 2 * margin, box.height + 2 * margin);
    cairo_clip(cr);
}

void nqm_chart_draw(cairo_t *cr, nqm_box outer, const nqm_chart *chart) {
    const plane p = {chart, nqm_frame_inner(cr, outer, chart->title, &chart->x, &chart->y)};
    nqm_frame_draw(cr, p.box, chart->title, &chart->x, &chart->y);
    for (size_t i = 0; i < chart->n_series; ++i) {
        const nqm_series *s = &chart->series[i];
        cairo_save(cr);
        clip_to(cr, p.box, s->mark == NQM_MARK_POINTS ? 4 : 0);
        nqm_series_draw(cr, s, place_in_plane, &p);
        cairo_restore(cr);
    }
}

/* ---- legend ------------------------------------------------------------------------------------------------------ */

enum { SAMPLE = 26, SPACE = 18 };

typedef struct legend {
    cairo_t *cr;
    nqm_box box;
    double x, y; /* where the next entry stands */
} legend;

static void add_entry(legend *l, const nqm_series *sample, const char *name) {
    double width = SAMPLE + 5 + nqm_label_width(l->cr, name, NQM_FONT) + SPACE;
    if (l->x > l->box.x && l->x + width - SPACE > l->box.x + l->box.width) {
        l->x = l->box.x;
        l->y += NQM_LINE_STEP;
    }
    nqm_series_sample(l->cr, sample, (nqm_box){l->x, l->y, SAMPLE, NQM_LINE_STEP});
    nqm_draw_grey(l->cr, 0);
    nqm_label_draw(l->cr, l->x + SAMPLE + 5, l->y + 13, NQM_LEFT, NQM_FONT, name);
    l->x += width;
}

static bool named_before(const nqm_sheet *sheet, const nqm_series *series) {
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
            if (chart->series[k].name && !named_before(sheet, &chart->series[k]))
                add_entry(&l, &chart->series[k], chart->series[k].name);
        for (size_t k = 0; bars && k < bars->n_groups; ++k)
            add_entry(&l, &(nqm_series){.style = nqm_bar_style(k), .size = 9}, bars->group_names[k]);
    }
    return l.x > box.x || l.y > box.y ? l.y - box.y + NQM_LINE_STEP + 4 : 0;
}
