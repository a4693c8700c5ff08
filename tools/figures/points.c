/* SPDX-License-Identifier: MIT
 *
 * Columns of a CSV as series of points.
 */
#include "figures/points.h"

#include <string.h>

nqm_status nqm_points_column(const nqm_csv *csv, const char *path, const char *name, int *column_ret, nqm_error *err) {
    *column_ret = nqm_csv_column(csv, name);
    if (*column_ret < 0)
        return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: the header has no column %s", path, name);
    if (nqm_csv_rows(csv) == 0)
        return nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "%s: there are no rows to draw", path);
    return NQM_OK;
}

nqm_status nqm_points_values(const nqm_csv *csv, int column, double *values, nqm_error *err) {
    nqm_status status = NQM_OK;
    for (size_t row = 0; status == NQM_OK && row < nqm_csv_rows(csv); ++row)
        status = nqm_csv_number(csv, row, column, &values[row], err);
    return status;
}

/* The series of a row's text: a known one, a new one, or the last. */
static size_t series_of(nqm_points *p, const char *text) {
    size_t i = 0;
    while (i < p->n_series && strcmp(p->series[i].name, text) != 0)
        ++i;
    if (i == NQM_MAX_GROUPS) {
        p->series[--i].name = "other";
    } else if (i == p->n_series) {
        p->series[i] = (nqm_series){.name = text, .mark = NQM_MARK_POINTS, .style = i};
        ++p->n_series;
    }
    return i;
}

/* Bring the points of each series together, in the order of the file. */
static void sort(nqm_points *p, const size_t *group, const double *x, const double *y) {
    size_t at = 0;
    for (size_t i = 0; i < p->n_series; ++i) {
        p->series[i].x = p->x + at;
        p->series[i].y = p->y + at;
        for (size_t row = 0; row < p->n; ++row)
            if (group[row] == i) {
                p->x[at] = x[row];
                p->y[at++] = y[row];
                ++p->series[i].n;
            }
    }
}

nqm_status nqm_points_read(const nqm_csv *csv, int x_column, int y_column, int group_column, nqm_points *points_ret,
                           nqm_error *err) {
    nqm_points p = {.n = nqm_csv_rows(csv)};
    double *read = nqm_alloc(p.n, 2 * sizeof *read);
    size_t *group = nqm_alloc(p.n, sizeof *group);
    p.x = nqm_alloc(p.n, sizeof *p.x);
    p.y = nqm_alloc(p.n, sizeof *p.y);
    nqm_status status = NQM_OK;
    if (!read || !group || !p.x || !p.y)
        status = nqm_fail_nomem(err, p.n * 5 * sizeof *read);
    if (status == NQM_OK)
        status = nqm_points_values(csv, x_column, read, err);
    if (status == NQM_OK)
        status = nqm_points_values(csv, y_column, read + p.n, err);
    if (status == NQM_OK) {
        for (size_t row = 0; row < p.n; ++row)
            group[row] = series_of(&p, group_column < 0 ? "" : nqm_csv_text(csv, row, group_column));
        sort(&p, group, read, read + p.n);
        for (size_t i = 0; i < p.n_series; ++i)
            if (!*p.series[i].name)
                p.series[i].name = NULL;
        *points_ret = p;
    } else {
        nqm_points_free(&p);
    }
    nqm_free(read);
    nqm_free(group);
    return status;
}

void nqm_points_free(nqm_points *points) {
    nqm_free(points->x);
    nqm_free(points->y);
}
