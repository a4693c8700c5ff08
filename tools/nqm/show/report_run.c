/* SPDX-License-Identifier: MIT
 *
 * The contents of a report: scores, pictures and names of its BRDFs; and its file.
 */
#include "nqm/show/report.h"

#include <stdlib.h>
#include <string.h>

/* The first test without a score or a picture ends the report. */
static void check_results(const report_run *run) {
    for (size_t i = 0; i < run->scores.n_rows; ++i)
        must(run->scores.rows[i].err.status, &run->scores.rows[i].err);
    for (size_t i = 0; i < run->labels.n_items; ++i)
        must(run->labels.items[i].err.status, &run->labels.items[i].err);
}

static void render_all(label_run *labels, int n_arguments, char **arguments) {
    labels->n_items = (size_t)n_arguments;
    labels->items = allocate(labels->n_items, sizeof *labels->items);
    labels->n_groups = 1;
    labels->keep_rgb = true;
    for (size_t i = 0; i < labels->n_items; ++i)
        labels->items[i].name = labels->items[i].shown = arguments[i];
    make_labels(labels);
}

/* Presets and short specs need no short form. */
static bool is_short(const char *argument) {
    enum { MAX_LENGTH = 40 };
    return strlen(argument) <= MAX_LENGTH && !strchr(argument, '/');
}

static void name_all(report_run *run) {
    const label_run *labels = &run->labels;
    run->short_names = allocate(labels->n_items, sizeof *run->short_names);
    run->names = allocate(labels->n_items, sizeof *run->names);
    for (size_t i = 0; i < labels->n_items; ++i)
        short_name(labels->items[i].name, run->short_names[i], sizeof run->short_names[i]);
    for (size_t i = 0; i < labels->n_items; ++i) {
        bool whole = is_short(labels->items[i].name);
        for (size_t k = 0; k < labels->n_items; ++k)
            whole = whole || (k != i && strcmp(run->short_names[i], run->short_names[k]) == 0);
        run->names[i] = whole ? labels->items[i].name : run->short_names[i];
    }
}

/* The temporary file of the figures has the unique name of the page's own, and an ending. */
static void write_page(const report_run *run, const output_file *out) {
    static const char suffix[] = ".png";
    size_t n = strlen(out->file.temporary) + sizeof suffix;
    char *figure = allocate(n, 1);
    snprintf(figure, n, "%s%s", out->file.temporary, suffix);
    write_report(run, out->stream, figure);
    free(figure);
    if (interrupted())
        stop(EXIT_INTERRUPTED, "interrupted");
}

void make_report(report_run *run, int n_arguments, char **arguments, const char *const *names, output_file *out) {
    choose_metrics("all", run->scores.metrics);
    run->brdfs = allocate((size_t)n_arguments, sizeof *run->brdfs);
    for (int i = 0; i < n_arguments; ++i)
        run->brdfs[i] = is_textured(arguments[i]) ? NULL : open_brdf(arguments[i]);
    run->scores.keep_heat = true;
    set_pairs(&run->scores, n_arguments, arguments, names);
    make_scores(&run->scores);
    check_results(run);
    run->json_scores = json_scores(&run->scores); /* before ranking: in the order of the arguments */
    rank_rows(&run->scores, false);
    render_all(&run->labels, n_arguments, arguments);
    map_labels(&run->labels);
    name_all(run);
    for (int i = 0; names && i < n_arguments; ++i)
        run->names[i] = names[i] ? names[i] : run->names[i];
    check_results(run);
    write_page(run, out);
    end_progress();
    close_output(out);
}

void write_fit_page(const char *title, int n_arguments, char **arguments, const char *const *names, const char *metric,
                    output_file *out) {
    report_run run = {.title = title, .scores = {.options = nqm_score_options_default()}, .labels = {.shrink = 1}};
    scene_args scene = scene_args_begin();
    const bool has_maps = is_textured(arguments[0]);
    scene.side = has_maps ? 128 : 256;
    scene_args_end(&scene);
    run.labels.scene_options = scene.scene;
    run.labels.view = nqm_scene_texture_view_default();
    run.labels.view.n_samples = has_maps ? 1 : run.labels.view.n_samples;
    run.scores.model = open_model(metric);
    make_report(&run, n_arguments, arguments, names, out);
    free_report(&run);
}

void free_report(report_run *run) {
    json_decref(run->json_scores);
    free(run->short_names);
    free(run->names);
    close_brdfs((int)run->labels.n_items, run->brdfs);
    free_labels(&run->labels);
    free_scores(&run->scores);
}
