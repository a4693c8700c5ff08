/* SPDX-License-Identifier: MIT
 *
 * Plots of a model: its directions (paper, figure 1b), and its layers as a table (figure 2).
 */
#include "figures/plot_shared.h"

#include <string.h>

nqm_status nqm_plot_directions(const char *path, const nqm_directions *directions, const nqm_plot_options *options,
                               nqm_error *err) {
    size_t n = nqm_directions_count(directions);
    const double *degrees = nqm_directions_degrees(directions);
    double *columns = nqm_alloc(n, 3 * sizeof *columns);
    if (!columns)
        return nqm_fail_nomem(err, n * 3 * sizeof *columns);
    for (size_t i = 0; i < 3 * n; ++i)
        columns[i % 3 * n + i / 3] = degrees[i];
    nqm_series series[2];
    nqm_chart charts[2];
    nqm_sheet_panel panels[2];
    static const char *const labels[2] = {NQM_THETA "_{d} (" NQM_DEG ")", NQM_PHI "_{d} (" NQM_DEG ")"};
    static const double ends[2] = {90, 180}, steps[2] = {15, 30};
    for (size_t k = 0; k < 2; ++k) {
        series[k] =
            (nqm_series){.mark = NQM_MARK_POINTS, .size = 4.5, .n = n, .x = columns, .y = columns + (k + 1) * n};
        charts[k] =
            (nqm_chart){.x = {.label = NQM_THETA "_{h} (" NQM_DEG ")", .scale = NQM_LINEAR, .max = 90, .step = 15},
                        .y = {.label = labels[k], .scale = NQM_LINEAR, .max = ends[k], .step = steps[k]},
                        .n_series = 1,
                        .series = &series[k]};
        nqm_axis_include(&charts[k].y, n, series[k].y); /* phi_d from a file may have any value */
        nqm_axis_round(&charts[k].y, 6);
        panels[k] = (nqm_sheet_panel){.chart = &charts[k]};
    }
    char title[64], note[128];
    snprintf(title, sizeof title, "%zu directions", n);
    snprintf(note, sizeof note, "half-vector coordinates (Rusinkiewicz 1998), " NQM_PHI "_{h} = 0; id of the set %s",
             nqm_directions_id(directions));
    const nqm_sheet sheet = {
        .title = title, .note = note, .width = 760, .height = 420, .n_rows = 1, .n_columns = 2, .panels = panels};
    nqm_status status = nqm_sheet_write(path, &sheet, options, err);
    nqm_free(columns);
    return status;
}

/* ---- layers ------------------------------------------------------------------------------------------------------ */

enum { LAYER_COLUMNS = 6 };

/* 4171125 as "4,171,125". */
static void print_count(size_t count, char cell[NQM_CELL]) {
    char digits[24];
    int n = snprintf(digits, sizeof digits, "%zu", count);
    size_t at = 0;
    for (int i = 0; i < n; ++i) {
        if (i > 0 && (n - i) % 3 == 0)
            cell[at++] = ',';
        cell[at++] = digits[i];
    }
    cell[at] = 0;
}

/* The rows of the table: heading, one per layer, totals. */
static void fill_table(const nqm_model_info *info, char (*cells)[NQM_CELL]) {
    static const char *const heads[LAYER_COLUMNS] = {"layer",      "inputs",          "outputs",
                                                     "parameters", "multiplications", "followed by"};
    size_t all = 0;
    for (size_t k = 0; k < LAYER_COLUMNS; ++k)
        snprintf(cells[k], NQM_CELL, "%s", heads[k]);
    for (size_t i = 0; i < info->n_layers; ++i) {
        char(*row)[NQM_CELL] = cells + LAYER_COLUMNS * (i + 1);
        size_t in = info->layer_sizes[i], out = info->layer_sizes[i + 1];
        bool last = i + 1 == info->n_layers;
        snprintf(row[0], NQM_CELL, "linear %zu", i + 1);
        print_count(in, row[1]);
        print_count(out, row[2]);
        print_count(in * out + out + (last ? 0 : 2 * out), row[3]); /* LayerNorm: gain and shift */
        print_count(in * out, row[4]);
        snprintf(row[5], NQM_CELL, "%s", last ? "sigmoid over the range of labels" : "LayerNorm, GELU, dropout");
        all += in * out;
    }
    char(*sum)[NQM_CELL] = cells + LAYER_COLUMNS * (info->n_layers + 1);
    snprintf(sum[0], NQM_CELL, "total");
    print_count(info->n_parameters, sum[3]);
    print_count(all, sum[4]);
}

nqm_status nqm_plot_network(const char *path, const nqm_model *model, const nqm_plot_options *options, nqm_error *err) {
    const nqm_model_info info = nqm_model_get_info(model);
    size_t n_rows = info.n_layers + 2, n = n_rows * LAYER_COLUMNS;
    char(*cells)[NQM_CELL] = nqm_alloc(n, sizeof *cells);
    if (!cells)
        return nqm_fail_nomem(err, n * sizeof *cells);
    fill_table(&info, cells);
    const nqm_table table = {.n_rows = n_rows,
                             .n_columns = LAYER_COLUMNS,
                             .cells = cells,
                             .widths = (double[]){0.12, 0.1, 0.1, 0.17, 0.19, 0.32},
                             .right_aligned = (bool[]){false, true, true, true, true, false}};
    char title[128], note[256];
    snprintf(title, sizeof title, "The network of model \"%.60s\"", info.id);
    snprintf(note, sizeof note,
             "recipe %.40s; %zu directions; parameters of a layer: weights, biases, gain and shift of its LayerNorm\n"
             "output: JOD from %.2f to %.2f; dropout is active in training only",
             info.recipe, nqm_directions_count(info.directions), info.jod_min, info.jod_max);
    nqm_status status = nqm_panel_write(path, (nqm_sheet_panel){.table = &table}, 760, 90 + 30 * (double)n_rows, title,
                                        note, options, err);
    nqm_free(cells);
    return status;
}
