/* SPDX-License-Identifier: MIT
 *
 * sheet.h - the content of a drawing, independent of how it is drawn: axes with ticks, series of points, heat maps, bars and
 * tables in a grid of panels, with a title, a legend and a note. All strings and arrays are borrowed.
 *
 * Labels may contain subscripts and superscripts: "_{h}" and "^{-2}".
 */
#ifndef NQM_FIGURES_SHEET_H
#define NQM_FIGURES_SHEET_H

#include "figures/plot.h"

/* Greek letters and the degree sign for labels. */
#define NQM_THETA "\xce\xb8"
#define NQM_PHI   "\xcf\x86"
#define NQM_DEG   "\xc2\xb0"
#define NQM_MINUS "\xe2\x88\x92"

/* ---- axes (axis.c) ----------------------------------------------------------------------------------------------- */

/** Position on an axis as a function of the value. NQM_SQRT is for theta_h, as in MERL tables. */
typedef enum nqm_scale { NQM_LINEAR = 0, NQM_LOG, NQM_SQRT } nqm_scale;

typedef struct nqm_axis {
    const char *label;
    nqm_scale scale;
    double min, max;    /* min < max; above 0 for NQM_LOG, not below 0 for NQM_SQRT */
    double step;        /* linear: distance of the ticks; 0: automatic */
    double label_width; /* least width for the numbers of a vertical axis, so that stacked frames align; pixels */
} nqm_axis;

enum { NQM_MAX_TICKS = 128 };
typedef struct nqm_tick_mark {
    double value;
    char label[24]; /* "" for minor ticks */
} nqm_tick_mark;

/** An axis with an empty range. */
nqm_axis nqm_axis_make(const char *label, nqm_scale scale);
/** Extend the range to n values; those that have no position on the scale are skipped: also NaN, and magnitudes above 1e300. */
void nqm_axis_include(nqm_axis *axis, size_t n, const double *values);
/** Move the ends outwards to round numbers, for about n_most ticks; an empty range, or one of a single value, is widened. */
void nqm_axis_round(nqm_axis *axis, size_t n_most);
/** Move the ends outwards, where necessary, so that markers at the outermost values do not touch the frame. Linear and logarithmic
 *  axes; low > high: there are no values. */
void nqm_axis_pad(nqm_axis *axis, double low, double high);
/** The ticks in ascending order, about n_most of them with labels; returns their number. */
size_t nqm_axis_ticks(const nqm_axis *axis, size_t n_most, nqm_tick_mark ticks[NQM_MAX_TICKS]);
/** Position of a value: 0 at min, 1 at max, also outside of [0, 1]; NaN where it has none. */
double nqm_axis_place(const nqm_axis *axis, double value);
/** 1, 2 or 5 times a power of ten: the smallest step that divides [0, length] into at most n_most parts. */
double nqm_tick_step(double length, size_t n_most);

/* ---- content of a sheet ------------------------------------------------------------------------------------------ */

/** NQM_MARK_NONE: a name in the legend without a sample; nothing is drawn. */
typedef enum nqm_mark { NQM_MARK_LINE = 0, NQM_MARK_STEPS, NQM_MARK_POINTS, NQM_MARK_NONE } nqm_mark;

enum { NQM_DASHES = 4 };

typedef struct nqm_series {
    const char *name; /* legend entry, once for equal names; NULL: none */
    nqm_mark mark;
    size_t style; /* colour and shape, 0 to 7 */
    size_t dash;  /* 0: solid; 1 to 3: dashes, dots, both */
    double size;  /* width of the line, diameter of the points, pixels; 0: default */
    size_t n;
    const double *x, *y; /* (n); a point without a position interrupts a line */
} nqm_series;

/** Series in a frame; polar: x is an angle in degrees from the normal, y the radius. */
typedef struct nqm_chart {
    const char *title;
    nqm_axis x, y;
    bool polar;
    double light_deg; /* polar: angle of the light */
    size_t n_series;
    const nqm_series *series;
} nqm_chart;

/** A heat map; its cells have equal size on paper. */
typedef struct nqm_heat {
    nqm_axis x, y, value;
    size_t n_columns, n_rows;
    const double *values; /* (n_rows, n_columns), first row at y.min; NaN: no value */
} nqm_heat;

enum { NQM_BARS = 2, NQM_CELL = 48 };

/** Bars under each other, with intervals; NaN: none. */
typedef struct nqm_bar_row {
    const char *name;
    double value[NQM_BARS], low[NQM_BARS], high[NQM_BARS];
} nqm_bar_row;

/** Rows of horizontal bars. */
typedef struct nqm_bars {
    nqm_axis x;
    size_t n;
    const nqm_bar_row *rows;        /* (n), from the top */
    const char *const *group_names; /* (NQM_BARS) of the bars of each row; NULL: no row has this bar */
} nqm_bars;

/** Text in rows and columns; the first row is the heading, the last one the totals. */
typedef struct nqm_table {
    size_t n_rows, n_columns;
    char (*cells)[NQM_CELL];   /* (n_rows, n_columns) */
    const double *widths;      /* (n_columns), fractions of the width; their sum is 1 */
    const bool *right_aligned; /* (n_columns) */
} nqm_table;

typedef struct nqm_sheet_panel { /* at most one of these */
    const nqm_chart *chart;
    const nqm_heat *heat;
    const nqm_bars *bars;
    const nqm_table *table;
} nqm_sheet_panel;

typedef struct nqm_sheet {
    const char *title;             /* NULL or "": none */
    const char *note;              /* small, at the bottom; lines end in \n; NULL: none */
    double width, height;          /* CSS pixels */
    size_t n_rows, n_columns;      /* numbers of panels; at least 1 */
    const double *row_heights;     /* (n_rows), fractions of the height; their sum is 1; NULL: equal */
    const nqm_sheet_panel *panels; /* (n_rows, n_columns) */
} nqm_sheet;

/** Draw to a file; `options` (NULL: the defaults) override title and size of the sheet. */
NQM_MUST_CHECK nqm_status nqm_sheet_write(const char *path, const nqm_sheet *sheet, const nqm_plot_options *options,
                                          nqm_error *err);

#endif
