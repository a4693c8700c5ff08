/* SPDX-License-Identifier: MIT
 *
 * nqm report - a self-contained page about a reference and its tests: scores, pictures, metrics, differences over angle,
 * provenance. report_page.c writes it.
 */
#include "nqm/show/report.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { DATE_SIZE = 16 };

/* Without a date: the day of SOURCE_DATE_EPOCH (https://reproducible-builds.org/specs/source-date-epoch/), or none. */
static const char *find_date(char text[DATE_SIZE]) {
    const char *epoch = getenv("SOURCE_DATE_EPOCH");
    if (!epoch)
        return NULL;
    char *end;
    errno = 0;
    long long seconds = strtoll(epoch, &end, 10);
    time_t t = (time_t)seconds;
    const struct tm *day = gmtime(&t);
    if (end == epoch || *end || errno || seconds < 0 || !day || strftime(text, DATE_SIZE, "%Y-%m-%d", day) == 0)
        stop(EXIT_USAGE, "SOURCE_DATE_EPOCH must be a number of seconds, not '%s'", epoch);
    return text;
}

/* ---- contents ---------------------------------------------------------------------------------------------------- */

/* The first test without a score or a picture ends the report. */
static void check_results(const report_run *run) {
    for (size_t i = 0; i < run->scores.n_rows; ++i)
        if (run->scores.rows[i].err.status != NQM_OK)
            stop_error(&run->scores.rows[i].err);
    for (size_t i = 0; i < run->labels.n_items; ++i)
        if (run->labels.items[i].err.status != NQM_OK)
            stop_error(&run->labels.items[i].err);
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

/* Score and render the arguments, a reference and its tests, and write the page to `out`, which is closed. Model and options of the
 * scores, scene and shrink of the labels, title and date are set. names: (n_arguments) shown instead of automatic ones where
 * not NULL; NULL: none. Errors end the program. */
static void make_report(report_run *run, int n_arguments, char **arguments, const char *const *names,
                        output_file *out) {
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

static void free_report(report_run *run) {
    json_decref(run->json_scores);
    free(run->short_names);
    free(run->names);
    close_brdfs((int)run->labels.n_items, run->brdfs);
    free_labels(&run->labels);
    free_scores(&run->scores);
}

void open_page(const char *name, const char *path, output_file *out) {
    open_output(path, out);
    if (!out->file.temporary)
        stop(EXIT_USAGE, "the page must be a file: %s FILE.html", name);
}

void write_fit_page(const char *title, int n, const page_item *items, const char *metric, output_file *out) {
    report_run run = {.title = title, .scores = {.options = nqm_score_options_default()}, .labels = {.shrink = 1}};
    scene_args scene = scene_args_begin();
    char **arguments = allocate((size_t)n, sizeof *arguments);
    const char **names = allocate((size_t)n, sizeof *names);
    for (int i = 0; i < n; ++i) {
        arguments[i] = (char *)(uintptr_t)items[i].argument; /* they are read only */
        names[i] = *items[i].name ? items[i].name : NULL;
    }
    const bool has_maps = is_textured(arguments[0]);
    scene.side = has_maps ? 128 : 256;
    scene_args_end(&scene);
    run.labels.scene_options = scene.scene;
    run.labels.view = nqm_scene_texture_view_default();
    run.labels.view.n_samples = has_maps ? 1 : run.labels.view.n_samples;
    run.scores.model = open_model(metric);
    make_report(&run, n, arguments, names, out);
    free_report(&run);
    free(arguments);
    free(names);
}

/* ---- the verb ---------------------------------------------------------------------------------------------------- */

static bool json;
static uint64_t shrink = 1;
static const char *output, *model = "default", *invalid = "drop";
static report_run run;
static scene_args scene;
static view_args view;

static const option options[] = {
    {"output", 'o', OPTION_NEEDED, &output, "FILE.html|.htm", "the page", 0, 0},
    {"title", 0, OPTION_TEXT, &run.title, "TEXT", "title of the page, instead of the automatic one", 0, 0},
    {"date", 0, OPTION_TEXT, &run.date, "TEXT", "date in the line to quote [default: SOURCE_DATE_EPOCH, or none]", 0,
     0},
    OPTION_ROWS_MODEL(&model),
    {"invalid", 0, OPTION_TEXT, &invalid, "POLICY", "for directions without a value: drop, zero, nearest, error", 0, 0},
    {"shrink", 0, OPTION_COUNT, &shrink, "N", "average N x N rendered pixels into one", 1, 16},
    {"json", 0, OPTION_FLAG, &json, NULL, "print the scores, as `nqm score --json`", 0, 0},
    OPTION_ROW_TILES(&view),
    OPTION_ROW_TEXELS(&view),
    OPTION_ROW_SIZE(&scene, "pixels of a frame (400 for all frames together; 200 with a textured material)"),
    OPTION_ROW_IGNORE,
    {0}};

static const command cmd = {
    .usage = "REF TEST... -o FILE.html [options]",
    .about = "Write a page for readers: the JOD of each TEST and its meaning, rendered pictures of reference and test"
             " with a map of their colour difference, all metrics, the directions where they differ, and a line to "
             "quote. The page is a single file, loads nothing from the network, prints well, and contains its numbers"
             " as JSON. The same arguments give the same bytes on one machine.",
    .example = "nqm report sgd:nickel ward:nickel -o nickel.html\n"
               "nqm report measured.bsdf fit1.binary fit2.binary --shape bunny.ply --light probe.exr -o fits.html\n"
               "nqm report sgd:nickel ward:nickel abc:nickel --title 'Three models of nickel' -o nickel.html",
    .options = options,
    .table = &nqm_scene_option_table,
    .table_target = &scene.scene,
    .min_arguments = 2,
    .max_arguments = -1,
};

int cmd_report(int argc, char **argv) {
    run = (report_run){.scores = {.options = nqm_score_options_default()}};
    scene = scene_args_begin();
    char date[DATE_SIZE];
    view = view_args_begin();
    view.texels = 1; /* each texel with a normal has light directions of its own */
    const int n_arguments = parse_arguments(&cmd, argc, argv);
    scene.side = 400; /* sharp on paper */
    for (int i = 0; i < n_arguments; ++i)
        scene.side = is_textured(argv[i]) ? 200 : scene.side;
    run.labels.view = view_of(&view);
    set_option(&nqm_score_option_table, "invalid", &run.scores.options, invalid);
    scene_args_end(&scene);
    run.scores.options.min_valid_fraction = scene.scene.min_valid;
    run.labels.scene_options = scene.scene;
    set_shrink(&run.labels, shrink, "--points renders no pictures, which the report needs");
    run.date = run.date ? run.date : find_date(date);
    output_file out;
    open_page("-o", output, &out); /* first: a missing folder is reported before the work */
    run.scores.model = open_model(model);
    const char **names = take_names(n_arguments, argv);
    make_report(&run, n_arguments, argv, names, &out);
    if (json)
        print_json(json_incref(run.json_scores));
    free_report(&run);
    free(names);
    return EXIT_OK;
}
