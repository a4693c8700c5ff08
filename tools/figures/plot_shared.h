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

/** Points from a CSV. */
typedef struct nqm_points {
    nqm_csv *csv;
    size_t n, n_series;
    double *x, *y;                     /* (n), sorted by series */
    nqm_series series[NQM_MAX_GROUPS]; /* views into x and y; names are views into the CSV */
} nqm_points;

/** The numbers of a column into values (rows). NQM_ERR_FORMAT if the column is missing or contains something else;
 *  NQM_ERR_INCOMPATIBLE for a file without rows. */
NQM_MUST_CHECK nqm_status nqm_points_values(const nqm_csv *csv, const char *path, const char *name, double *values,
                                            nqm_error *err);
/** Fill the zeroed `points`, whose csv is loaded from `path`, from the columns x and y, with a series for each text of the column
 *  `group` (one series without a name if there is no such column). The eighth series takes all further groups, as "other". */
NQM_MUST_CHECK nqm_status nqm_points_fill(nqm_points *points, const char *path, const char *x, const char *y,
                                          const char *group, nqm_error *err);
/** The same for a file that is not loaded yet; an error leaves nothing to free. */
NQM_MUST_CHECK nqm_status nqm_points_load(const char *path, const char *x, const char *y, const char *group,
                                          nqm_points *points_ret, nqm_error *err);
/** Free the arrays and the CSV; a zeroed one is allowed. */
void nqm_points_free(nqm_points *points);

#endif
