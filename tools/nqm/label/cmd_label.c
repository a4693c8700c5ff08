/* SPDX-License-Identifier: MIT
 *
 * nqm label - Delta-E ITP and JOD of pairs of BRDFs by rendering them.
 */
#include "nqm/label/label.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char group_mark[] = "+";

/* Read the arguments: groups of a reference and its tests, separated by '+'. */
static void read_items(label_run *run, int n_arguments, char **argv, const char *const *names) {
    run->items = allocate((size_t)n_arguments, sizeof *run->items);
    size_t reference = 0;
    for (int i = 0; i < n_arguments; ++i) {
        if (strcmp(argv[i], group_mark) == 0) {
            if (reference == run->n_items || i + 1 == n_arguments)
                stop(EXIT_USAGE, "a '+' must be between a test and another reference");
            reference = run->n_items;
            continue;
        }
        run->items[run->n_items] =
            (label_item){.name = argv[i], .shown = names[i] ? names[i] : argv[i], .reference = reference};
        run->n_groups += run->n_items == reference;
        ++run->n_items;
    }
    for (size_t i = 0; i < run->n_items; ++i)
        if (run->items[i].reference == i && (i + 1 == run->n_items || run->items[i + 1].reference != i))
            stop(EXIT_USAGE, "%s: this reference has no test", run->items[i].name);
}

/* Check options that depend on each other. */
static void check_label(label_run *run, uint64_t shrink) {
    run->keep_rgb = run->map || run->grid || run->keep;
    if (run->keep_rgb)
        set_shrink(run, shrink, "--map, --grid and --keep-renders need pictures: leave out --points");
    if (run->keep)
        require_folder_name("--keep-renders", run->keep, ".png|.exr|.hdr|.jpg", "the pictures");
    if (run->keep)
        make_folder(run->keep);
}

/* ---- the verb ---------------------------------------------------------------------------------------------------- */

static uint64_t shrink = 1;
static label_run run;
static scene_args scene;
static view_args view;

static const option options[] = {
    {"map", 0, OPTION_TEXT, &run.map, "FILE.png", "draw reference, test and their difference, one row per test", 0, 0},
    {"grid", 0, OPTION_TEXT, &run.grid, "FILE.png", "draw each reference and its tests in a row", 0, 0},
    {"shrink", 0, OPTION_COUNT, &shrink, "N", "average N x N rendered pixels into one of a figure", 1, 16},
    {"keep-renders", 0, OPTION_TEXT, &run.keep, "DIR", "write every picture (.exr, .png) and difference to this folder",
     0, 0},
    {"json", 0, OPTION_FORMAT, &run.format, NULL, "print JSON", FORMAT_JSON, 0},
    {"csv", 0, OPTION_FORMAT, &run.format, NULL, "print CSV", FORMAT_CSV, 0},
    {"quiet", 'q', OPTION_FORMAT, &run.format, NULL, "print the JODs only, one per line", FORMAT_QUIET, 0},
    OPTION_ROW_TILES(&view),
    OPTION_ROW_TEXELS(&view),
    OPTION_ROW_SIZE(&scene, "pixels of a frame, if it is to be a picture (with a figure: 256 for all frames together)"),
    OPTION_ROW_IGNORE,
    {0}};

static const command cmd = {
    .usage = "REF TEST... [+ REF TEST...]... [options]",
    .about = "Render REF and each TEST on a shape under a light map and compare the pictures: mean Delta-E ITP (ITU-R"
             " BT.2124), and the JOD of the published curve. These are the labels of training corpora; `nqm score` "
             "predicts them without rendering. A '+' starts another reference. doc/labels.md.",
    .example = "nqm label sgd:nickel ward:nickel\n"
               "nqm label measured.bsdf fit1.binary fit2.binary --shape bunny.ply --light probe.exr --json\n"
               "nqm label sgd:nickel ward:nickel --map difference.png --keep-renders renders\n"
               "nqm label sgd:nickel ward:nickel + sgd:gold-paint ward:gold-paint --grid grid.png",
    .options = options,
    .table = &nqm_scene_option_table,
    .table_target = &scene.scene,
    .min_arguments = 2,
    .max_arguments = -1,
};

int cmd_label(int argc, char **argv) {
    scene = scene_args_begin();
    view = view_args_begin();
    const int n_arguments = parse_arguments(&cmd, argc, argv);
    if (run.map || run.grid || run.keep)
        scene.side = 256;
    const nqm_scene_options given = scene.scene;
    scene_args_end(&scene);
    run.adds_samples = !scene.scene.width && !given.n_points && !given.n_lights;
    run.scene_options = scene.scene;
    run.view = view_of(&view);
    check_label(&run, shrink);
    const char **names = take_names(n_arguments, argv);
    read_items(&run, n_arguments, argv, names);
    make_labels(&run);
    if (run.keep_rgb)
        map_labels(&run);
    print_labels(&run);
    draw_labels(&run);
    int exit_code = EXIT_OK;
    for (size_t i = 0; i < run.n_items; ++i)
        if (run.items[i].err.status != NQM_OK) {
            int code = report_error(&run.items[i].err);
            exit_code = exit_code == EXIT_OK ? code : exit_code; /* exit code of the first error */
        }
    free_labels(&run);
    free(names);
    return exit_code;
}
