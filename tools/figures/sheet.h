/* SPDX-License-Identifier: MIT
 *
 * sheet.h - what a drawing holds, whatever draws it: axes with their ticks, series of points, maps, bars and tables, set
 * on a sheet with a title, a legend and a note. All strings and arrays are lent.
 *
 * Labels may hold subscripts and superscripts: "_{h}" and "^{-2}".
 */
#ifndef NQM_SRC_PLOT_SHEET_H
#define NQM_SRC_PLOT_SHEET_H

#include "figures/tone.h"

#include "figures/plot.h"

/* ---- axes -------------------------------------------------------------------------------------------------------- */

/** How values become places: as they are, their logarithm, or their square root (theta_h: as MERL tables do). */
typedef enum nqm_scale { NQM_LINEAR = 0, NQM_LOG, NQM_SQRT } nqm_scale;

typedef struct nqm_axis {
    const char *label;
    nqm_scale scale;
    double min, max; /* min < max; both above 0 for NQM_LOG, not below for NQM_SQRT */
    double step;     /* linear: distance of the ticks, 0: chosen */
    double room;     /* for the numbers of a vertical axis, so that frames below each other agree; 0: what they need */
} nqm_axis;

enum { NQM_MAX_TICKS = 128 };
typedef struct nqm_tick_mark {
    double value;
    char label[24]; /* "" for the small ones between */
} nqm_tick_mark;

/** An axis that holds nothing yet. */
nqm_axis nqm_axis_make(const char *label, nqm_scale scale);
/** Make the axis hold n more values; those that are not finite, or have no place on its scale, are passed over. */
void nqm_axis_hold(nqm_axis *axis, size_t n, const double *values);
/** Move the ends outwards to round numbers; an axis that holds nothing or one value gets a range around it. */
void nqm_axis_round(nqm_axis *axis, size_t n_most);
/** The ticks of an axis, rising, about n_most of them labelled; returns how many. */
size_t nqm_axis_ticks(const nqm_axis *axis, size_t n_most, nqm_tick_mark ticks[NQM_MAX_TICKS]);
/** Place of a value: 0 at min, 1 at max; outside of [0, 1] beyond; NaN where it has none. */
double nqm_axis_place(const nqm_axis *axis, double value);

/* ---- what stands on a sheet -------------------------------------------------------------------------------------- */

typedef enum nqm_mark { NQM_MARK_LINE = 0, NQM_MARK_STEPS, NQM_MARK_POINTS } nqm_mark;

typedef struct nqm_series {
    const char *name; /* in the legend, once for equal names; NULL: not there */
    nqm_mark mark;
    size_t style; /* which colour and shape, 0 to 7 */
    bool dashed;
    double size; /* width of the line, diameter of the points; 0: usual */
    size_t n;
    const double *x, *y; /* (n); a point that has no place interrupts a line */
} nqm_series;

/** Series in a frame; polar: x is an angle in degrees from the normal, y the radius. */
typedef struct nqm_chart {
    const char *title;
    nqm_axis x, y;
    bool polar;
    double light_deg; /* polar: where the light stands */
    size_t n_series;
    const nqm_series *series;
} nqm_chart;

/** A map: cells of equal size on the paper between the ends of the axes. */
typedef struct nqm_heat {
    nqm_axis x, y, value;
    size_t n_columns, n_rows;
    const double *values; /* (n_rows, n_columns), first row at y.min; NaN: nothing */
} nqm_heat;

/** Horizontal bars in groups. */
typedef struct nqm_bars {
    nqm_axis x;
    size_t n, n_groups;
    const char *const *names;         /* (n), top first */
    const char *const *group_names;   /* (n_groups) */
    const double *value, *low, *high; /* (n, n_groups); NaN: none */
} nqm_bars;

/** Lines of text in columns, the first line a heading, the last a sum. */
typedef struct nqm_table {
    size_t n_rows, n_columns;
    const char *const *cells;  /* (n_rows, n_columns) */
    const double *shares;      /* (n_columns) of the width; they sum to 1 */
    const bool *right_aligned; /* (n_columns) */
} nqm_table;

typedef struct nqm_sheet_panel { /* one of these, or none */
    const nqm_chart *chart;
    const nqm_heat *heat;
    const nqm_bars *bars;
    const nqm_table *table;
} nqm_sheet_panel;

typedef struct nqm_sheet {
    const char *title;             /* NULL or "": none */
    const char *note;              /* below, small; lines end with \n; NULL: none */
    double width, height;          /* CSS pixels */
    size_t n_rows, n_columns;      /* of panels; at least 1 */
    const double *row_shares;      /* (n_rows) of the height, summing to 1; NULL: equal */
    const nqm_sheet_panel *panels; /* (n_rows, n_columns) */
} nqm_sheet;

/** Draw to a file; `sheet` gives title and size where `options` (NULL: the defaults) do not. */
NQM_MUST_CHECK nqm_status nqm_sheet_write(const char *path, const nqm_sheet *sheet, const nqm_plot_options *options,
                                          nqm_error *err);

#endif
