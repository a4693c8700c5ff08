/* SPDX-License-Identifier: MIT
 *
 * Plot of trainings: losses over the epochs and, below, the learning rate.
 */
#include "figures/plot_shared.h"

#include <string.h>

enum { MAX_LOGS = 8, TRAIN = 0, VALIDATION, RATE, EPOCH, N_COLUMNS };

typedef struct training {
    size_t n;
    double *block, *values[N_COLUMNS]; /* (n) each, in the block */
    char names[2][128];                /* names of the two losses in the legend */
} training;

static nqm_status read_log(const char *path, training *t, nqm_error *err) {
    static const char *const columns[N_COLUMNS] = {"train_loss", "validation_loss", "lr_first", "epoch"};
    nqm_csv *csv;
    nqm_status status = nqm_csv_load(path, &csv, err);
    if (status != NQM_OK)
        return status;
    if (nqm_csv_column(csv, columns[TRAIN]) < 0)
        status = nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: no column %s; loss draws the file of `nqm train --log`", path,
                          columns[TRAIN]);
    t->n = nqm_csv_rows(csv);
    t->block = nqm_alloc(t->n, N_COLUMNS * sizeof *t->block);
    if (status == NQM_OK && !t->block)
        status = nqm_fail_nomem(err, t->n * N_COLUMNS * sizeof *t->block);
    for (size_t k = 0; status == NQM_OK && k < N_COLUMNS; ++k) {
        t->values[k] = t->block + k * t->n;
        status = nqm_points_values(csv, path, columns[k], t->values[k], err);
    }
    nqm_csv_free(csv);
    return status;
}

/* The names of several logs begin with their files. */
static void name_losses(training *t, const char *path, bool is_only) {
    static const char *const losses[2] = {"training", "validation"};
    const char *file = strrchr(path, '/') ? strrchr(path, '/') + 1 : path;
    for (size_t k = 0; k < 2; ++k)
        snprintf(t->names[k], sizeof t->names[k], "%.100s%s%s", is_only ? "" : file, is_only ? "" : ", ", losses[k]);
}

/* Around the values, clear of the frame. */
static void round_axis(nqm_axis *axis, size_t n_most) {
    const nqm_axis values = *axis;
    nqm_axis_round(axis, n_most);
    nqm_axis_pad(axis, values.min, values.max);
}

static nqm_status draw(const char *path, size_t n, const training *trainings, const nqm_plot_options *options,
                       nqm_error *err) {
    nqm_series losses[2 * MAX_LOGS], rates[MAX_LOGS];
    nqm_chart upper = {.x = nqm_axis_make(NULL, NQM_LINEAR), .y = nqm_axis_make("loss (log-cosh)", NQM_LOG)};
    nqm_chart lower = {.x = nqm_axis_make("epoch", NQM_LINEAR), .y = nqm_axis_make("learning rate", NQM_LOG)};
    for (size_t i = 0; i < n; ++i) {
        const training *t = &trainings[i];
        const bool is_point = t->n == 1; /* no line */
        for (size_t k = 0; k < 2; ++k) {
            losses[2 * i + k] = (nqm_series){.name = t->names[k],
                                             .mark = is_point ? NQM_MARK_POINTS : NQM_MARK_LINE,
                                             .style = n == 1 ? k : i,
                                             .dash = k == TRAIN,
                                             .n = t->n,
                                             .x = t->values[EPOCH],
                                             .y = t->values[k]};
            nqm_axis_include(&upper.y, t->n, t->values[k]);
        }
        rates[i] = (nqm_series){.mark = is_point ? NQM_MARK_POINTS : NQM_MARK_STEPS,
                                .style = n == 1 ? 6 : i,
                                .n = t->n,
                                .x = t->values[EPOCH],
                                .y = t->values[RATE]};
        nqm_axis_include(&lower.y, t->n, t->values[RATE]);
        nqm_axis_include(&lower.x, t->n, t->values[EPOCH]);
    }
    nqm_axis_include(&lower.x, 1, &(double){0});
    const double last = lower.x.max;
    nqm_axis_round(&lower.x, 10);
    nqm_axis_pad(&lower.x, last, last);
    round_axis(&upper.y, 6);
    round_axis(&lower.y, 4);
    upper.x.min = lower.x.min;
    upper.x.max = lower.x.max;
    upper.y.label_width = lower.y.label_width = 44;
    upper.series = losses;
    upper.n_series = 2 * n;
    lower.series = rates;
    lower.n_series = n;
    const nqm_sheet sheet = {.title = "Training",
                             .note = "mean loss of each epoch; learning rate of the first layer",
                             .width = 640,
                             .height = 520,
                             .n_rows = 2,
                             .n_columns = 1,
                             .row_heights = (double[]){0.64, 0.36},
                             .panels = (nqm_sheet_panel[]){{.chart = &upper}, {.chart = &lower}}};
    return nqm_sheet_write(path, &sheet, options, err);
}

nqm_status nqm_plot_losses(const char *path, size_t n, const char *const *log_csv, const nqm_plot_options *options,
                           nqm_error *err) {
    training trainings[MAX_LOGS] = {0};
    nqm_status status = NQM_OK;
    if (n < 1 || n > MAX_LOGS)
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s: 1 to %d trainings can be drawn, not %zu", path, (int)MAX_LOGS, n);
    for (size_t i = 0; status == NQM_OK && i < n; ++i) {
        status = read_log(log_csv[i], &trainings[i], err);
        name_losses(&trainings[i], log_csv[i], n == 1);
    }
    if (status == NQM_OK)
        status = draw(path, n, trainings, options, err);
    for (size_t i = 0; i < n; ++i)
        nqm_free(trainings[i].block);
    return status;
}
