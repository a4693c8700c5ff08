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

/* The first test without a score or a picture ends the report. */
static int first_fault(const report_run *run) {
    for (size_t i = 0; i < run->scores.n_rows; ++i)
        if (run->scores.rows[i].err.status != NQM_OK)
            return report_error("report", &run->scores.rows[i].err);
    for (size_t i = 0; i < run->labels.n_items; ++i)
        if (run->labels.items[i].err.status != NQM_OK)
            return report_error("report", &run->labels.items[i].err);
    return EXIT_OK;
}

static int render_all(report_run *run) {
    const score_run *scores = &run->scores;
    label_run *labels = &run->labels;
    labels->items = calloc(scores->n_rows + 1, sizeof *labels->items);
    if (!labels->items)
        return report("report", EXIT_LIMIT, "out of memory");
    labels->n_items = scores->n_rows + 1;
    labels->n_groups = 1;
    labels->keep_rgb = true;
    labels->items[0].name = scores->ref_name;
    for (size_t i = 0; i < scores->n_rows; ++i)
        labels->items[i + 1].name = scores->rows[i].name;
    return make_labels("report", labels);
}

/* Presets and short specs need no short form. */
static bool is_short(const char *argument) {
    enum { MAX_LENGTH = 40 };
    return strlen(argument) <= MAX_LENGTH && !strchr(argument, '/');
}

static int name_all(report_run *run) {
    const label_run *labels = &run->labels;
    run->short_names = calloc(labels->n_items, sizeof *run->short_names);
    run->names = calloc(labels->n_items, sizeof *run->names);
    if (!run->short_names || !run->names)
        return report("report", EXIT_LIMIT, "out of memory");
    for (size_t i = 0; i < labels->n_items; ++i)
        short_name(labels->items[i].name, run->short_names[i], sizeof run->short_names[i]);
    for (size_t i = 0; i < labels->n_items; ++i) {
        bool whole = is_short(labels->items[i].name);
        for (size_t k = 0; k < labels->n_items; ++k)
            whole = whole || (k != i && strcmp(run->short_names[i], run->short_names[k]) == 0);
        run->names[i] = whole ? labels->items[i].name : run->short_names[i];
    }
    return EXIT_OK;
}

static int rank_all(report_run *run) {
    const score_run *scores = &run->scores;
    run->ranking = (ranking){.model = scores->model, .n_rows = scores->n_rows};
    run->ranking.rows = calloc(scores->n_rows, sizeof *run->ranking.rows);
    if (!run->ranking.rows)
        return report("report", EXIT_LIMIT, "out of memory");
    for (size_t i = 0; i < scores->n_rows; ++i)
        run->ranking.rows[i] = (rank_row){.order = i,
                                          .pair = {scores->ref_name, scores->rows[i].name},
                                          .result = scores->rows[i].result,
                                          .err = &scores->rows[i].err};
    rank_rows(&run->ranking);
    return EXIT_OK;
}

/* Compute everything before the page is written. */
static int gather(report_run *run, const char *model) {
    int exit_code = make_scores("report", &run->scores, model);
    if (exit_code == EXIT_OK)
        exit_code = first_fault(run);
    if (exit_code == EXIT_OK)
        exit_code = rank_all(run);
    if (exit_code == EXIT_OK)
        exit_code = render_all(run);
    if (exit_code == EXIT_OK)
        exit_code = name_all(run);
    return exit_code == EXIT_OK ? first_fault(run) : exit_code;
}

/* The temporary file of the figures has the unique name of the page's own, and an ending. */
static int write_page(const report_run *run, output_file *out) {
    static const char suffix[] = ".png";
    size_t n = strlen(out->file.temporary) + sizeof suffix;
    char *figure = malloc(n);
    if (!figure)
        return report("report", EXIT_LIMIT, "out of memory");
    snprintf(figure, n, "%s%s", out->file.temporary, suffix);
    int exit_code = write_report(run, out->stream, figure);
    free(figure);
    if (exit_code == EXIT_OK && interrupted())
        exit_code = report("report", EXIT_INTERRUPTED, "interrupted");
    return exit_code;
}

static int make_report(report_run *run, const char *model, const char *path) {
    output_file out;
    int exit_code = open_output("report", path, &out); /* first: a missing folder is reported before the work */
    if (exit_code == EXIT_OK && !out.file.temporary)
        exit_code = report("report", EXIT_USAGE, "the page must be a file: -o FILE.html");
    if (exit_code == EXIT_OK)
        exit_code = gather(run, model);
    if (exit_code == EXIT_OK)
        exit_code = write_page(run, &out);
    end_progress();
    int close_code = close_output("report", &out, exit_code == EXIT_OK);
    return exit_code == EXIT_OK ? close_code : exit_code;
}

/* Without a date: the day of SOURCE_DATE_EPOCH (https://reproducible-builds.org/specs/source-date-epoch/), or none. */
static int find_date(const char **date, char text[DATE_SIZE]) {
    const char *epoch = getenv("SOURCE_DATE_EPOCH");
    if (*date || !epoch)
        return EXIT_OK;
    char *end;
    errno = 0;
    long long seconds = strtoll(epoch, &end, 10);
    time_t t = (time_t)seconds;
    struct tm day;
    if (end == epoch || *end || errno || seconds < 0 || !gmtime_r(&t, &day) ||
        strftime(text, DATE_SIZE, "%Y-%m-%d", &day) == 0)
        return report("report", EXIT_USAGE, "SOURCE_DATE_EPOCH must be a number of seconds, not '%s'", epoch);
    *date = text;
    return EXIT_OK;
}

static int check_scene(label_run *labels, uint64_t shrink) {
    const nqm_scene_options *o = &labels->scene_options;
    labels->shrink = (size_t)shrink;
    if (!o->width)
        return report("report", EXIT_USAGE, "--points renders no pictures, which the report needs");
    if (o->width % labels->shrink || o->height % labels->shrink)
        return report("report", EXIT_USAGE, "--shrink must divide the size of the picture");
    return EXIT_OK;
}

int cmd_report(int argc, char **argv) {
    bool json = false;
    uint64_t shrink = 1;
    const char *output = NULL, *model = "default", *invalid = "drop";
    char date[DATE_SIZE];
    report_run run = {.scores = {.options = nqm_score_options_default()}};
    scene_args scene = scene_args_begin();
    scene.size = "400"; /* sharp on paper */
    const option options[] = {
        {"output", 'o', OPTION_TEXT, &output, "FILE.html", "the page", 0, 0},
        {"title", 0, OPTION_TEXT, &run.title, "TEXT", "title of the page, instead of the automatic one", 0, 0},
        {"date", 0, OPTION_TEXT, &run.date, "TEXT", "date in the line to quote [default: SOURCE_DATE_EPOCH, or none]",
         0, 0},
        {"model", 'm', OPTION_TEXT, &model, "MODEL", "name of a built-in model, or a model file", 0, 0},
        {"invalid", 0, OPTION_TEXT, &invalid, "POLICY", "for directions without a value: drop, zero, nearest, error", 0,
         0},
        {"min-valid", 0, OPTION_NUMBER, &run.scores.options.min_valid_fraction, "F",
         "smallest fraction of valid directions of a pair", 0, 1},
        {"shrink", 0, OPTION_COUNT, &shrink, "N", "average N x N rendered pixels into one", 1, 16},
        {"json", 0, OPTION_FLAG, &json, NULL, "print the scores, as `nqm score --json`", 0, 0},
        OPTION_ROW_SIZE(&scene),
        {0}};
    const command cmd = {
        .name = "report",
        .usage = "REF TEST... -o FILE.html [options]",
        .about =
            "Write a page for readers: the JOD of each TEST and its meaning, rendered pictures of reference and test\n"
            "with a map of their colour difference, all metrics, the directions where they differ, and a line to\n"
            "quote. The page is a single file, loads nothing from the network, prints well, and holds its numbers as\n"
            "JSON. The same arguments give the same bytes on one machine.",
        .example = "nqm report sgd:nickel ward:nickel -o nickel.html\n"
                   "nqm report measured.bsdf fit1.binary fit2.binary --shape bunny.ply --light probe.exr -o fits.html\n"
                   "nqm report sgd:nickel ward:nickel abc:nickel --title 'Three models of nickel' -o nickel.html",
        .options = options,
        .table = &nqm_scene_option_table,
        .table_target = &scene.scene,
        .min_arguments = 2,
        .max_arguments = -1,
    };
    int n_arguments, exit_code;
    if (!parse_arguments(&cmd, argc, argv, &n_arguments, &exit_code))
        return exit_code;
    if (!output)
        return report("report", EXIT_USAGE, "give the file of the page: -o FILE.html");
    exit_code = set_option("report", &nqm_score_option_table, "invalid", &run.scores.options, invalid);
    if (exit_code == EXIT_OK)
        exit_code = scene_args_end("report", &scene);
    run.labels.scene_options = scene.scene;
    if (exit_code == EXIT_OK)
        exit_code = check_scene(&run.labels, shrink);
    if (exit_code == EXIT_OK)
        exit_code = find_date(&run.date, date);
    if (exit_code == EXIT_OK)
        exit_code = choose_metrics("report", "all", run.scores.metrics);
    if (exit_code != EXIT_OK)
        return exit_code;
    run.scores.ref_name = argv[0];
    run.scores.test_names = argv + 1;
    run.scores.n_rows = (size_t)n_arguments - 1;
    exit_code = make_report(&run, model, output);
    if (exit_code == EXIT_OK && json)
        exit_code = print_json(json_scores(&run.scores));
    free(run.short_names);
    free(run.names);
    free(run.ranking.rows);
    free_labels(&run.labels);
    free_scores(&run.scores);
    return exit_code;
}
