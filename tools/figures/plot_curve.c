/* SPDX-License-Identifier: MIT
 *
 * Plots of labels: JOD against Delta-E with the fitted curve (paper, figure 1a), and predictions against labels.
 */
#include "figures/plot_shared.h"
#include "math/math.h"

#include <math.h>
#include <nqm/label.h>
#include <string.h>

static void share_range(nqm_chart *chart) {
    chart->x.min = chart->y.min = fmin(chart->x.min, chart->y.min);
    chart->x.max = chart->y.max = fmax(chart->x.max, chart->y.max);
}

/* Around the points; human scores may be outside of 0 to 10. is_shared: both axes show the same range. */
static void round_axes(nqm_chart *chart, bool is_shared) {
    nqm_axis x = nqm_axis_make(NULL, chart->x.scale),
             y = nqm_axis_make(NULL, chart->y.scale); /* ranges of the points */
    for (size_t i = 0; i < chart->n_series; ++i) {
        nqm_axis_include(&x, chart->series[i].n, chart->series[i].x);
        nqm_axis_include(&y, chart->series[i].n, chart->series[i].y);
    }
    nqm_axis_include(&chart->x, 2, (double[]){x.min, x.max});
    nqm_axis_include(&chart->y, 2, (double[]){y.min, y.max});
    nqm_axis_round(&chart->x, 8);
    nqm_axis_round(&chart->y, 8);
    if (is_shared) {
        share_range(chart);
        chart->x.step = chart->y.step = nqm_tick_step(chart->x.max - chart->x.min, 10);
    }
    nqm_axis_pad(&chart->x, x.min, x.max);
    nqm_axis_pad(&chart->y, y.min, y.max);
    if (is_shared)
        share_range(chart);
}

/* ---- the curve --------------------------------------------------------------------------------------------------- */

enum { N_CURVE = 256 };

static nqm_status draw_curve(const char *path, nqm_points *points, const nqm_regress_report *fit,
                             const nqm_plot_options *options, nqm_error *err) {
    nqm_series series[NQM_MAX_GROUPS + 1];
    double x[N_CURVE], y[N_CURVE];
    nqm_chart chart = {.x = nqm_axis_make("\xce\x94"
                                          "E ITP",
                                          NQM_LINEAR),
                       .y = nqm_axis_make("JOD", NQM_LINEAR)};
    chart.y.step = 1;
    chart.series = series;
    chart.n_series = points->n_series;
    memcpy(series, points->series, points->n_series * sizeof *series);
    nqm_axis_include(&chart.x, 1, &(double){0});
    nqm_axis_include(&chart.y, 2, (double[]){0, 10});
    round_axes(&chart, false);
    for (size_t i = 0; i < N_CURVE; ++i) {
        x[i] = chart.x.max * (double)i / (N_CURVE - 1);
        y[i] = nqm_curve_jod(&fit->curve, x[i]);
    }
    series[chart.n_series++] =
        (nqm_series){.name = "fitted curve", .style = 6, .size = 2.2, .n = N_CURVE, .x = x, .y = y};
    char note[256];
    snprintf(note, sizeof note,
             "JOD = 10 (1 \xe2\x88\x92 1 / (1 + exp(b_{1} (\xe2\x88\x92\xce\x94"
             "E^{b3} \xe2\x88\x92 b_{2})))): b_{1} = %.3f, b_{2} = %.4f, b_{3} = %.4f\n"
             "least squares over %zu labels, RMSE %.3f JOD; Spearman correlation %.3f",
             fit->curve.b1, fit->curve.b2, fit->curve.b3, fit->n, fit->rmse, fit->spearman);
    return nqm_panel_write(path, (nqm_sheet_panel){.chart = &chart}, 640, 440, "Quality against colour difference",
                           note, options, err);
}

nqm_status nqm_plot_curve(const char *path, const char *labels_csv, const nqm_regress_report *fit,
                          const nqm_plot_options *options, nqm_error *err) {
    nqm_points points;
    nqm_status status = nqm_points_load(labels_csv, "DeltaE", "JOD", "model", &points, err);
    if (status != NQM_OK)
        return status;
    status = draw_curve(path, &points, fit, options, err);
    nqm_points_free(&points);
    return status;
}

/* ---- predictions ------------------------------------------------------------------------------------------------- */

static bool is_metric(const char *name) {
    for (int i = 0; i < NQM_METRIC_COUNT; ++i)
        if (strcmp(nqm_metric_name((nqm_metric)i), name) == 0)
            return true;
    return false;
}

/* `nqm eval --human --pairs` leaves delta_e empty: the column jod has the scores of people, on any scale. */
static bool has_human_scores(const nqm_csv *csv) {
    const int column = nqm_csv_column(csv, "delta_e");
    return column >= 0 && nqm_csv_rows(csv) > 0 && !*nqm_csv_text(csv, 0, column);
}

static nqm_status draw_predictions(const char *path, nqm_points *points, const char *predictor,
                                   const nqm_plot_options *options, nqm_error *err) {
    nqm_series series[NQM_MAX_GROUPS + 1];
    char title[128], label[128];
    double ends[2];
    const bool jod = !is_metric(predictor), human = has_human_scores(points->csv);
    snprintf(title, sizeof title, "%s against the %s of each pair", predictor, human ? "human score" : "label");
    snprintf(label, sizeof label, "%s (%s)", jod ? "predicted JOD" : "distance", predictor);
    nqm_chart chart = {.x = nqm_axis_make(human ? "score of people" : "JOD of the label", NQM_LINEAR),
                       .y = nqm_axis_make(label, jod ? NQM_LINEAR : NQM_LOG),
                       .series = series,
                       .n_series = points->n_series};
    memcpy(series, points->series, points->n_series * sizeof *series);
    for (size_t i = 0; i < points->n_series; ++i)
        series[i].size = 5;
    round_axes(&chart, jod && !human);
    if (jod && !human) {
        ends[0] = chart.x.min;
        ends[1] = chart.x.max;
        series[chart.n_series++] =
            (nqm_series){.name = "equal", .style = 6, .dash = 1, .size = 1.2, .n = 2, .x = ends, .y = ends};
    }
    char note[128];
    double sign = jod ? 1 : -1; /* a larger distance is lower quality */
    if (points->n > 1)
        snprintf(note, sizeof note, "%zu pairs; Spearman correlation %.3f%s", points->n,
                 sign * nqm_spearman(points->n, points->x, points->y), jod ? "" : " (signed: higher is better)");
    else
        snprintf(note, sizeof note, "1 pair");
    return nqm_panel_write(path, (nqm_sheet_panel){.chart = &chart}, 560, 580, title, note, options, err);
}

/* Set the column of predictions, unless one was named: that after the labels. Files that have none, and those of nqm batch and of
 * nqm eval --human, are refused. */
static nqm_status find_predictor(const char *path, const nqm_csv *csv, const char **predictor, nqm_error *err) {
    const int label = nqm_csv_column(csv, "jod");
    if (nqm_csv_column(csv, "jod_low") >= 0)
        return nqm_fail(err, NQM_ERR_INCOMPATIBLE, 0,
                        "%s: has the scores of nqm batch (column jod_low) and no labels; nqm eval --pairs FILE writes "
                        "labels and predictions, also with --human",
                        path);
    if (label >= 0 && !*predictor && (size_t)label + 1 < nqm_csv_columns(csv))
        *predictor = nqm_csv_header(csv, label + 1);
    if (label >= 0 && *predictor)
        return NQM_OK;
    const char *needed = "scatter needs the column jod (labels) and after it a column of predictions";
    if (nqm_csv_column(csv, "test_a") >= 0)
        return nqm_fail(err, NQM_ERR_FORMAT, 0,
                        "%s: %s; these are choices of people, which `nqm eval --human %s --json | nqm plot bars - -o "
                        "bars.svg` draws",
                        path, needed, path);
    if (nqm_csv_column(csv, "reference") >= 0 &&
        (label >= 0 || nqm_csv_column(csv, "score") >= 0 || nqm_csv_column(csv, "distance") >= 0))
        return nqm_fail(
            err, NQM_ERR_FORMAT, 0,
            "%s: %s; these are answers of people: `nqm eval --human %s --pairs pairs.csv` writes both columns, "
            "and `nqm plot scatter pairs.csv` draws them",
            path, needed, path);
    return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: %s; `nqm eval --pairs FILE.csv` writes both", path, needed);
}

nqm_status nqm_plot_predictions(const char *path, const char *pairs_csv, const char *predictor,
                                const nqm_plot_options *options, nqm_error *err) {
    nqm_points points = {0};
    nqm_status status = nqm_csv_load(pairs_csv, &points.csv, err);
    if (status == NQM_OK)
        status = find_predictor(pairs_csv, points.csv, &predictor, err);
    if (status == NQM_OK)
        status = nqm_points_fill(&points, pairs_csv, "jod", predictor, "family", err);
    if (status == NQM_OK)
        status = draw_predictions(path, &points, predictor, options, err);
    nqm_points_free(&points);
    return status;
}
