/* SPDX-License-Identifier: MIT
 *
 * The implementation of plot_shared.h.
 */
#include "figures/plot_shared.h"

#include "base/names.h"

#include <string.h>

nqm_plot_options nqm_plot_options_default(void) {
    return (nqm_plot_options){.scale = 2};
}

nqm_status nqm_panel_write(const char *path, nqm_sheet_panel panel, double width, double height, const char *title,
                           const char *note, const nqm_plot_options *options, nqm_error *err) {
    const nqm_sheet sheet = {
        .title = title, .note = note, .width = width, .height = height, .n_rows = 1, .n_columns = 1, .panels = &panel};
    return nqm_sheet_write(path, &sheet, options, err);
}

nqm_status nqm_points_values(const nqm_csv *csv, const char *path, const char *name, double *values, nqm_error *err) {
    const int column = nqm_csv_column(csv, name);
    if (column < 0) {
        nqm_nearest nearest = nqm_nearest_begin(name);
        for (size_t i = 0; i < nqm_csv_columns(csv); ++i)
            nqm_nearest_add(&nearest, nqm_csv_header(csv, (int)i));
        return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: the header has no column %s%s", path, name, nearest.advice);
    }
    if (nqm_csv_rows(csv) == 0)
        return nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "%s: there are no rows", path);
    nqm_status status = NQM_OK;
    for (size_t row = 0; status == NQM_OK && row < nqm_csv_rows(csv); ++row)
        status = nqm_csv_number(csv, row, column, &values[row], err);
    return status;
}

/* Index of the series of a text; new texts get a new series while there is room. */
static size_t find_series(nqm_points *p, const char *text) {
    size_t i = 0;
    while (i < p->n_series && strcmp(p->series[i].name, text) != 0)
        ++i;
    if (i == NQM_MAX_GROUPS)
        p->series[--i].name = "other";
    else if (i == p->n_series)
        p->series[p->n_series++] = (nqm_series){.name = text, .mark = NQM_MARK_POINTS, .style = i};
    return i;
}

nqm_status nqm_points_fill(nqm_points *p, const char *path, const char *x_name, const char *y_name,
                           const char *group_name, nqm_error *err) {
    p->n = nqm_csv_rows(p->csv);
    const int group_column = nqm_csv_column(p->csv, group_name);
    double *x = NULL, *y = NULL; /* by row */
    size_t *group = NULL, n_sorted = 0;
    nqm_status status =
        nqm_alloc_arrays(NQM_ARRAYS({&p->x, p->n, sizeof *p->x}, {&p->y, p->n, sizeof *p->y}, {&x, p->n, sizeof *x},
                                    {&y, p->n, sizeof *y}, {&group, p->n, sizeof *group}),
                         err);
    if (status == NQM_OK)
        status = nqm_points_values(p->csv, path, x_name, x, err);
    if (status == NQM_OK)
        status = nqm_points_values(p->csv, path, y_name, y, err);
    for (size_t row = 0; status == NQM_OK && row < p->n; ++row)
        group[row] = find_series(p, group_column < 0 ? "" : nqm_csv_text(p->csv, row, group_column));
    for (size_t i = 0; status == NQM_OK && i < p->n_series; ++i) {
        nqm_series *s = &p->series[i];
        s->x = p->x + n_sorted;
        s->y = p->y + n_sorted;
        s->name = *s->name ? s->name : NULL;
        for (size_t row = 0; row < p->n; ++row)
            if (group[row] == i) {
                p->x[n_sorted] = x[row];
                p->y[n_sorted++] = y[row];
                ++s->n;
            }
    }
    return status;
}

nqm_status nqm_points_load(const char *path, const char *x_name, const char *y_name, const char *group_name,
                           nqm_points *points_ret, nqm_error *err) {
    nqm_points p = {0};
    nqm_status status = nqm_csv_load(path, &p.csv, err);
    if (status == NQM_OK)
        status = nqm_points_fill(&p, path, x_name, y_name, group_name, err);
    if (status != NQM_OK)
        nqm_points_free(&p);
    else
        *points_ret = p;
    return status;
}

void nqm_points_free(nqm_points *points) {
    nqm_free(points->x);
    nqm_csv_free(points->csv);
    *points = (nqm_points){0};
}
