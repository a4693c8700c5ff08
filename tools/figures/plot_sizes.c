/* SPDX-License-Identifier: MIT
 *
 * Plot of what `nqm batch` says of a list with the columns `map` and `size`: JOD over size, and for each map a line of
 * the best JOD up to each size, for rows in the order of their sizes.
 */
#include "figures/plot_shared.h"

/* Around the values, clear of the frame. */
static void round_axis(nqm_axis *axis, size_t n, const double *values) {
    nqm_axis_include(axis, n, values);
    const nqm_axis range = *axis;
    nqm_axis_round(axis, 8);
    nqm_axis_pad(axis, range.min, range.max);
}

nqm_status nqm_plot_sizes(const char *path, const char *scores_csv, const nqm_plot_options *options, nqm_error *err) {
    nqm_series series[2 * NQM_MAX_GROUPS];
    nqm_chart chart = {.x = nqm_axis_make("bits per texel of the map", NQM_LOG),
                       .y = nqm_axis_make("JOD", NQM_LINEAR),
                       .series = series};
    nqm_points points;
    double *best;
    nqm_status status = nqm_points_load(scores_csv, "size", "jod", "map", &points, err);
    if (status != NQM_OK)
        return status;
    best = nqm_alloc(points.n, sizeof *best);
    if (!best) {
        nqm_points_free(&points);
        return nqm_fail_nomem(err, points.n * sizeof *best);
    }
    chart.n_series = 2 * points.n_series;
    for (size_t k = 0; k < points.n_series; ++k) {
        series[k] = series[points.n_series + k] = points.series[k];
        double *y = best + (points.series[k].y - points.y);
        for (size_t i = 0; i < points.series[k].n; ++i)
            y[i] = i && y[i - 1] > points.series[k].y[i] ? y[i - 1] : points.series[k].y[i];
        series[k].mark = NQM_MARK_STEPS;
        series[k].y = y;
        series[points.n_series + k].mark = NQM_MARK_POINTS;
        series[points.n_series + k].name = NULL;
    }
    round_axis(&chart.x, points.n, points.x);
    round_axis(&chart.y, points.n, points.y);
    status =
        nqm_panel_write(path, (nqm_sheet_panel){.chart = &chart}, 520, 340, "Which size is enough", NULL, options, err);
    nqm_free(best);
    nqm_points_free(&points);
    return status;
}
