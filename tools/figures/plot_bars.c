/* SPDX-License-Identifier: MIT
 *
 * Plot of an evaluation as bars with 95 % intervals: Spearman correlations with labels or human scores (paper, figure 3), or the
 * fraction of human choices that is predicted.
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

/* What the bars show. Predictors are ordered by the last value that they have. */
typedef struct statistics {
    const char *values[NQM_BARS], *intervals[NQM_BARS]; /* members of a result; "": none */
    const char *groups[NQM_BARS];
    const char *name, *axis, *title;
} statistics;

#define CORRELATIONS                                                                                                   \
    {"spearman", "spearman_mean_by_material"}, {"ci95", "ci95_mean_by_material"},                                      \
        {"over all pairs", "mean over materials"}, "Spearman correlation"
static const statistics of_labels = {CORRELATIONS, "Spearman correlation with the labels (1: the same order)",
                                     "Agreement with the labels"};
static const statistics of_scores = {CORRELATIONS, "Spearman correlation with the scores of people (1: the same order)",
                                     "Agreement with the scores of people"};
static const statistics of_choices = {{"majority", "agreement"},
                                      {"", "ci95"},
                                      {"each pair of tests: choice of most people", "all choices"},
                                      "agreement",
                                      "fraction of the choices that is predicted (0.5: guessing)",
                                      "Agreement with the choices of people"};

static const statistics *choose_statistics(const json_t *root) {
    const json_t *human = json_object_get(root, "human");
    const char *kind = json_string_value(json_object_get(human, "kind"));
    return !human ? &of_labels : kind && strcmp(kind, "choice") == 0 ? &of_choices : &of_scores;
}

static nqm_bar_row read_predictor(const json_t *row, const statistics *s) {
    nqm_bar_row p = {.name = json_string_value(json_object_get(row, "name"))};
    for (size_t k = 0; k < NQM_BARS; ++k) {
        const json_t *interval = json_object_get(row, s->intervals[k]);
        p.value[k] = number(json_object_get(row, s->values[k]));
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

static nqm_status read_predictors(const char *path, const json_t *root, const statistics *s, nqm_bar_row *predictors,
                                  size_t *n, nqm_error *err) {
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
        predictors[i] = read_predictor(json_array_get(rows, i), s);
        if (!predictors[i].name)
            return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: result %zu has no name", path, i);
        if (isnan(predictors[i].value[0]) && isnan(predictors[i].value[1]))
            return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: result %zu (%.80s) has no %s", path, i, predictors[i].name,
                            s->name);
    }
    qsort(predictors, *n, sizeof *predictors, compare);
    return NQM_OK;
}

static bool has_bar(const nqm_bars *rows, size_t group) {
    size_t i = 0;
    while (i < rows->n && !isfinite(rows->rows[i].value[group]))
        ++i;
    return i < rows->n;
}

static bool has_interval(const nqm_bars *rows) {
    for (size_t i = 0; i < rows->n * NQM_BARS; ++i) {
        const nqm_bar_row *row = &rows->rows[i / NQM_BARS];
        if (isfinite(row->value[i % NQM_BARS]) && isfinite(row->low[i % NQM_BARS]) && isfinite(row->high[i % NQM_BARS]))
            return true;
    }
    return false;
}

static nqm_status draw(const char *path, const statistics *s, const nqm_bars *rows, const char *note,
                       const nqm_plot_options *options, nqm_error *err) {
    nqm_axis axis = nqm_axis_make(s->axis, NQM_LINEAR);
    nqm_axis_include(&axis, 2, (double[]){0, 1});
    for (size_t i = 0; i < rows->n; ++i) {
        nqm_axis_include(&axis, NQM_BARS, rows->rows[i].value);
        nqm_axis_include(&axis, NQM_BARS, rows->rows[i].low);
    }
    nqm_axis_round(&axis, 6);
    axis.max += 0.12 * (axis.max - axis.min); /* room for the numbers after the bars */
    const char *groups[NQM_BARS];
    for (size_t k = 0; k < NQM_BARS; ++k)
        groups[k] = has_bar(rows, k) ? s->groups[k] : NULL;
    const nqm_bars bars = {axis, rows->n, rows->rows, groups};
    return nqm_panel_write(path, (nqm_sheet_panel){.bars = &bars}, 640, fmax(150 + 42 * (double)rows->n, 200), s->title,
                           note, options, err);
}

static long long count(const json_t *of, const char *key) {
    return (long long)json_number_value(json_object_get(of, key));
}

/* "1 material", "7 materials" */
static const char *count_materials(long long n, char text[40]) {
    snprintf(text, 40, "%lld material%s", n, n == 1 ? "" : "s");
    return text;
}

/* The note: what was judged. A split belongs to labels only. */
static void describe(const json_t *root, const statistics *s, bool has_whiskers, char *note, size_t n_note) {
    const json_t *first = json_array_get(json_object_get(root, "results"), 0), *human = json_object_get(root, "human");
    const char *split = json_string_value(json_object_get(json_object_get(root, "dataset"), "split"));
    char what[160], materials[40];
    if (s == &of_choices)
        snprintf(what, sizeof what, "%lld choices between %lld pairs of tests, %s; at most %.3f can be predicted",
                 count(human, "choices"), count(human, "triplets"),
                 count_materials(count(human, "materials"), materials),
                 json_number_value(json_object_get(human, "ceiling")));
    else
        snprintf(what, sizeof what, "%lld pairs of %s%s%.40s", count(first, "n"),
                 count_materials(count(first, "n_materials"), materials), split && !human ? ", split: " : "",
                 split && !human ? split : "");
    snprintf(note, n_note, "%s%s%s", what,
             !has_whiskers      ? ""
             : s == &of_choices ? "\n"
                                : "; ",
             has_whiskers ? "whiskers: 95 % intervals, bootstrap over materials" : "");
}

static nqm_status load(const char *path, json_t **root_ret, nqm_error *err) {
    json_error_t fault;
    *root_ret = json_load_file(path, 0, &fault);
    if (!*root_ret && json_error_code(&fault) == json_error_cannot_open_file)
        return nqm_fail(err, NQM_ERR_IO, -1, "%s: cannot open: %s", path, strerror(errno));
    if (!*root_ret)
        return nqm_fail(err, NQM_ERR_FORMAT, fault.position,
                        "%s: line %d is not JSON, but bars draws the document of `nqm eval --json`: %s", path,
                        fault.line, fault.text);
    return NQM_OK;
}

nqm_status nqm_plot_bars(const char *path, const char *eval_json, const nqm_plot_options *options, nqm_error *err) {
    json_t *root = NULL;
    nqm_bar_row predictors[MAX_PREDICTORS];
    size_t n;
    char note[240];
    nqm_status status = load(eval_json, &root, err);
    const statistics *s = choose_statistics(root);
    if (status == NQM_OK)
        status = read_predictors(eval_json, root, s, predictors, &n, err);
    if (status == NQM_OK) {
        const nqm_bars rows = {.n = n, .rows = predictors};
        describe(root, s, has_interval(&rows), note, sizeof note);
        status = draw(path, s, &rows, note, options, err);
    }
    json_decref(root);
    return status;
}
