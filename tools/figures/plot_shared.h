/* SPDX-License-Identifier: MIT
 *
 * plot_shared.h - shared by the plots: a sheet of one panel, and columns of a CSV as series of points.
 */
#ifndef NQM_FIGURES_PLOT_SHARED_H
#define NQM_FIGURES_PLOT_SHARED_H

#include "figures/sheet.h"
#include "io/io.h"

/** Write a sheet of a single panel; other arguments as in nqm_sheet. */
NQM_MUST_CHECK nqm_status nqm_panel_write(const char *path, nqm_sheet_panel panel, double width, double height,
                                          const char *title, const char *note, const nqm_plot_options *options,
                                          nqm_error *err);

enum { NQM_MAX_GROUPS = 8 };

typedef struct nqm_points {
    size_t n, n_series;
    double *x, *y;                     /* (n), sorted by series */
    nqm_series series[NQM_MAX_GROUPS]; /* views into x and y; names are borrowed from the CSV */
} nqm_points;

/** Index of a column, or NQM_ERR_FORMAT if it is missing; NQM_ERR_INCOMPATIBLE for a file without rows. */
NQM_MUST_CHECK nqm_status nqm_points_column(const nqm_csv *csv, const char *path, const char *name, int *column_ret,
                                            nqm_error *err);
/** The numbers of a column into values (rows). */
NQM_MUST_CHECK nqm_status nqm_points_values(const nqm_csv *csv, int column, double *values, nqm_error *err);
/** Read x and y, with a series for each text of group_column (-1: one series without a name). The eighth series takes all
 *  further groups, as "other". */
NQM_MUST_CHECK nqm_status nqm_points_read(const nqm_csv *csv, int x_column, int y_column, int group_column,
                                          nqm_points *points_ret, nqm_error *err);
/** Free the arrays; a zeroed one is allowed. */
void nqm_points_free(nqm_points *points);

#endif
