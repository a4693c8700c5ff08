/* SPDX-License-Identifier: MIT
 *
 * Plot of an evaluation: Spearman correlations as bars with 95 % intervals (paper, figure 3).
 */
#include "figures/plot_shared.h"

#include <errno.h>
#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_PREDICTORS = 64 };

static double number(const json_t *value) {
    return json_is_number(value) ? json_number_value(value) : (double)NAN;
}

/* Correlation over all pairs, and mean over materials. */
static nqm_bar_row read_predictor(const json_t *row) {
    static const char *const values[NQM_BARS] = {"spearman", "spearman_mean_by_material"};
    static const char *const intervals[NQM_BARS] = {"ci95", "ci95_mean_by_material"};
    nqm_bar_row p = {.name = json_string_value(json_object_get(row, "name"))};
    for (size_t k = 0; k < NQM_BARS; ++k) {
        const json_t *interval = json_object_get(row, intervals[k]);
        p.value[k] = number(json_object_get(row, values[k]));
        p.low[k] = number(json_array_get(interval, 0));
        p.high[k] = number(json_array_get(interval, 1));
    }
    return p;
}

static double rank_value(const nqm_bar_row *p) {
    double value = isfinite(p->value[1]) ? p->value[1] : p->value[0];
    return isfinite(value) ? value : -2;
}

/* Best first; equal ones by name, so that the order is unique. */
static int compare(const void *a, const void *b) {
    double x = rank_value(a), y = rank_value(b);
    return x != y ? (x < y) - (x > y) : strcmp(((const nqm_bar_row *)a)->name, ((const nqm_bar_row *)b)->name);
}

static nqm_status read_predictors(const char *path, const json_t *root, nqm_bar_row *predictors, size_t *n,
                                  nqm_error *err) {
    const json_t *rows = json_object_get(root, "results");
    *n = json_array_size(rows);
    if (!json_is_array(rows))
        return nqm_fail(err, NQM_ERR_FORMAT, 0,
                        "%s: there is no list \"results\"; expected the output of nqm eval --json", path);
    if (*n == 0)
        return nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "%s: there are no results to draw", path);
    if (*n > MAX_PREDICTORS)
        return nqm_fail(err, NQM_ERR_LIMIT, -1, "%s: there are %zu predictors; at most %d can be drawn", path, *n,
                        (int)MAX_PREDICTORS);
    for (size_t i = 0; i < *n; ++i) {
        predictors[i] = read_predictor(json_array_get(rows, i));
        if (!predictors[i].name)
            return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: result %zu has no name", path, i);
        if (isnan(predictors[i].value[0]) && isnan(predictors[i].value[1]))
            return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: result %zu (%.80s) has no Spearman correlation", path, i,
                            predictors[i].name);
    }
    qsort(predictors, *n, sizeof *predictors, compare);
    return NQM_OK;
}

static nqm_status draw(const char *path, const nqm_bar_row *predictors, size_t n, const char *note,
                       const nqm_plot_options *options, nqm_error *err) {
    static const char *const groups[NQM_BARS] = {"over all pairs", "mean over materials"};
    nqm_axis axis = nqm_axis_make("Spearman correlation with the labels (1: the same order)", NQM_LINEAR);
    nqm_axis_include(&axis, 2, (double[]){0, 1});
    for (size_t i = 0; i < n; ++i) {
        nqm_axis_include(&axis, NQM_BARS, predictors[i].value);
        nqm_axis_include(&axis, NQM_BARS, predictors[i].low);
    }
    nqm_axis_round(&axis, 6);
    axis.max += 0.12 * (axis.max - axis.min); /* room for the numbers after the bars */
    const nqm_bars bars = {axis, n, predictors, groups};
    return nqm_panel_write(path, (nqm_sheet_panel){.bars = &bars}, 640, 150 + 42 * (double)n,
                           "Agreement with the labels", note, options, err);
}

static void describe(const json_t *root, char *note, size_t n_note) {
    const json_t *first = json_array_get(json_object_get(root, "results"), 0);
    const char *split = json_string_value(json_object_get(json_object_get(root, "dataset"), "split"));
    snprintf(note, n_note, "%lld pairs of %lld materials%s%.40s; whiskers: 95 %% intervals, bootstrap over materials",
             (long long)json_integer_value(json_object_get(first, "n")),
             (long long)json_integer_value(json_object_get(first, "n_materials")), split ? ", split: " : "",
             split ? split : "");
}

static nqm_status load(const char *path, json_t **root_ret, nqm_error *err) {
    json_error_t fault;
    *root_ret = json_load_file(path, 0, &fault);
    if (!*root_ret && json_error_code(&fault) == json_error_cannot_open_file)
        return nqm_fail(err, NQM_ERR_IO, -1, "%s: cannot open: %s", path, strerror(errno));
    if (!*root_ret)
        return nqm_fail(err, NQM_ERR_FORMAT, fault.position, "%s: line %d is not JSON: %s", path, fault.line,
                        fault.text);
    return NQM_OK;
}

nqm_status nqm_plot_bars(const char *path, const char *eval_json, const nqm_plot_options *options, nqm_error *err) {
    json_t *root = NULL;
    nqm_bar_row predictors[MAX_PREDICTORS];
    size_t n;
    char note[200];
    nqm_status status = load(eval_json, &root, err);
    if (status == NQM_OK)
        status = read_predictors(eval_json, root, predictors, &n, err);
    if (status == NQM_OK) {
        describe(root, note, sizeof note);
        status = draw(path, predictors, n, note, options, err);
    }
    json_decref(root);
    return status;
}
