/* SPDX-License-Identifier: MIT
 *
 * points.h - columns of a CSV as series of points, a series for each text of another column.
 */
#ifndef NQM_SRC_PLOT_POINTS_H
#define NQM_SRC_PLOT_POINTS_H

#include "figures/sheet.h"
#include "io/io.h"

enum { NQM_MAX_GROUPS = 8 };

typedef struct nqm_points {
    size_t n, n_series;
    double *x, *y; /* (n), sorted by series; nqm_free */
    nqm_series series[NQM_MAX_GROUPS];
} nqm_points;

/** The number of a column that must be there, or NQM_ERR_FORMAT; NQM_ERR_INCOMPATIBLE for a file without rows. */
NQM_MUST_CHECK nqm_status nqm_points_column(const nqm_csv *csv, const char *path, const char *name, int *column_ret,
                                            nqm_error *err);
/** A column as numbers into values (rows). */
NQM_MUST_CHECK nqm_status nqm_points_values(const nqm_csv *csv, int column, double *values, nqm_error *err);
/** Read x and y; group_column -1: one series without a name. The eighth series takes all further groups, as "other".
 *  Names are lent by the CSV. */
NQM_MUST_CHECK nqm_status nqm_points_read(const nqm_csv *csv, int x_column, int y_column, int group_column,
                                          nqm_points *points_ret, nqm_error *err);
/** Free the arrays; a zeroed one is allowed. */
void nqm_points_free(nqm_points *points);

#endif
