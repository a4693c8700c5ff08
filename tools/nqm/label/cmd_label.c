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
static int read_items(label_run *run, int n_arguments, char **argv) {
    run->items = calloc((size_t)n_arguments, sizeof *run->items);
    if (!run->items)
        return report("label", EXIT_LIMIT, "out of memory");
    size_t reference = 0;
    for (int i = 0; i < n_arguments; ++i) {
        if (strcmp(argv[i], group_mark) == 0) {
            if (reference == run->n_items || i + 1 == n_arguments)
                return report("label", EXIT_USAGE, "a '+' must be between a test and another reference");
            reference = run->n_items;
            continue;
        }
        run->items[run->n_items] = (label_item){.name = argv[i], .reference = reference};
        run->n_groups += run->n_items == reference;
        ++run->n_items;
    }
    for (size_t i = 0; i < run->n_items; ++i)
        if (run->items[i].reference == i && (i + 1 == run->n_items || run->items[i + 1].reference != i))
            return report("label", EXIT_USAGE, "%s: this reference has no test", run->items[i].name);
    return EXIT_OK;
}

static int run_label(label_run *run) {
    int exit_code = make_labels("label", run);
    if (exit_code != EXIT_OK)
        return exit_code;
    exit_code = print_labels(run);
    int draw_code = draw_labels(run);
    exit_code = exit_code == EXIT_OK ? draw_code : exit_code;
    for (size_t i = 0; i < run->n_items; ++i)
        if (run->items[i].err.status != NQM_OK) {
            int code = report_error("label", &run->items[i].err);
            exit_code = exit_code == EXIT_OK ? code : exit_code; /* of the first error */
        }
    return exit_code;
}

/* Check options that depend on each other. */
static int check_label(label_run *run, uint64_t shrink) {
    bool pictures = run->map || run->grid || run->keep;
    run->shrink = (size_t)shrink;
    run->keep_rgb = pictures;
    if (pictures && !run->scene_options.width)
        return report("label", EXIT_USAGE, "--map, --grid and --keep-renders need pictures: leave out --points");
    if (pictures && (run->scene_options.width % run->shrink || run->scene_options.height % run->shrink))
        return report("label", EXIT_USAGE, "--shrink must divide the size of the picture");
    return EXIT_OK;
}

int cmd_label(int argc, char **argv) {
    bool json = false, csv = false, quiet = false;
    uint64_t shrink = 1;
    label_run run = {0};
    scene_args scene = scene_args_begin();
    const option options[] = {
        {"map", 0, OPTION_TEXT, &run.map, "FILE.png", "draw reference, test and their difference, one row per test", 0,
         0},
        {"grid", 0, OPTION_TEXT, &run.grid, "FILE.png", "draw each reference and its tests in a row", 0, 0},
        {"rows", 0, OPTION_TEXT, &run.rows, "A,B,...", "titles of the rows of a figure", 0, 0},
        {"columns", 0, OPTION_TEXT, &run.columns, "A,B,...", "titles of its columns", 0, 0},
        {"shrink", 0, OPTION_COUNT, &shrink, "N", "average N x N rendered pixels into one of a figure", 1, 16},
        {"keep-renders", 0, OPTION_TEXT, &run.keep, "DIR",
         "write every picture (.exr, .png) and difference to this folder", 0, 0},
        {"json", 0, OPTION_FLAG, &json, NULL, "print JSON", 0, 0},
        {"csv", 0, OPTION_FLAG, &csv, NULL, "print CSV", 0, 0},
        {"quiet", 'q', OPTION_FLAG, &quiet, NULL, "print the JODs only, one per line", 0, 0},
        OPTION_ROW_SIZE(&scene),
        {0}};
    const command cmd = {
        .name = "label",
        .usage = "REF TEST... [+ REF TEST...]... [options]",
        .about = "Render REF and each TEST on a shape under a light map and compare the pictures: mean Delta-E ITP\n"
                 "(ITU-R BT.2124), and the JOD of the published curve. These are the labels of training corpora;\n"
                 "`nqm score` predicts them without rendering. A '+' starts another reference. doc/labels.md.",
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
    int n_arguments, exit_code;
    if (!parse_arguments(&cmd, argc, argv, &n_arguments, &exit_code))
        return exit_code;
    exit_code = choose_result_format("label", json, csv, quiet, &run.format);
    if (exit_code != EXIT_OK)
        return exit_code;
    exit_code = scene_args_end("label", &scene);
    run.scene_options = scene.scene;
    if (exit_code == EXIT_OK)
        exit_code = check_label(&run, shrink);
    if (exit_code == EXIT_OK)
        exit_code = read_items(&run, n_arguments, argv);
    if (exit_code == EXIT_OK)
        exit_code = run_label(&run);
    free_labels(&run);
    return exit_code;
}
