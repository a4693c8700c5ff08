/* SPDX-License-Identifier: MIT
 *
 * The implementation of plot_shared.h.
 */
#include "figures/plot_shared.h"

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

nqm_status nqm_points_read(const nqm_csv *csv, int x_column, int y_column, int group_column, nqm_points *points_ret,
                           nqm_error *err) {
    nqm_points p = {.n = nqm_csv_rows(csv)};
    p.x = nqm_alloc(p.n, 4 * sizeof *p.x); /* x and y by series, then x and y by row */
    size_t *group = nqm_alloc(p.n, sizeof *group), n_sorted = 0;
    nqm_status status = p.x && group ? NQM_OK : nqm_fail_nomem(err, p.n * 5 * sizeof *p.x);
    double *x = p.x + 2 * p.n, *y = p.x + 3 * p.n;
    p.y = p.x + p.n;
    if (status == NQM_OK)
        status = nqm_points_values(csv, x_column, x, err);
    if (status == NQM_OK)
        status = nqm_points_values(csv, y_column, y, err);
    for (size_t row = 0; status == NQM_OK && row < p.n; ++row)
        group[row] = find_series(&p, group_column < 0 ? "" : nqm_csv_text(csv, row, group_column));
    for (size_t i = 0; status == NQM_OK && i < p.n_series; ++i) {
        nqm_series *s = &p.series[i];
        s->x = p.x + n_sorted;
        s->y = p.y + n_sorted;
        s->name = *s->name ? s->name : NULL;
        for (size_t row = 0; row < p.n; ++row)
            if (group[row] == i) {
                p.x[n_sorted] = x[row];
                p.y[n_sorted++] = y[row];
                ++s->n;
            }
    }
    nqm_free(group);
    if (status != NQM_OK)
        nqm_points_free(&p);
    *points_ret = p;
    return status;
}

void nqm_points_free(nqm_points *points) {
    nqm_free(points->x);
    *points = (nqm_points){0};
}
