/* SPDX-License-Identifier: MIT
 *
 * nqm label - Delta-E ITP and JOD of pairs of BRDFs by rendering them: create the scene, render each BRDF, and compare its picture with
 * that of its reference; the results as a table, JSON, CSV, or JODs only.
 */
#include "nqm/label/label.h"
#include "nqm/rows.h"
#include "pairs/pairs.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Textures stay open for all rounds. The error of a test is stored in its item. */
static void open_textures(label_run *run) {
    for (size_t i = 0; i < run->n_items; ++i) {
        label_item *item = &run->items[i];
        item->argument = parse_argument(item->name);
        if (!nqm_argument_is_textured(item->argument))
            continue;
        const nqm_status status = open_texture(item->argument, &item->texture, &item->err);
        if (status != NQM_OK && (item->reference == i || status == NQM_ERR_CANCELLED))
            stop_error(&item->err);
    }
}

/* Positions are those of the finest texture of the group, so that a reference and its tests have the same. */
static nqm_texture_view view_of_group(const label_run *run, size_t reference) {
    nqm_texture_view view = run->view;
    double finest = 0;
    for (size_t i = 0; i < run->n_items; ++i) {
        if (run->items[i].reference != reference || !run->items[i].texture)
            continue;
        const nqm_texture_info info = nqm_texture_get_info(run->items[i].texture, NULL);
        const double n_texels = (double)info.width * (double)info.height;
        if (n_texels > finest)
            view.beside = run->items[i].texture;
        finest = fmax(finest, n_texels);
    }
    return view;
}

static void forget_picture(label_item *item) {
    free(item->rgb_cdm2);
    item->rgb_cdm2 = NULL;
    nqm_brdf_free(item->made.brdf);
    item->made.brdf = NULL;
}

static nqm_status render_item(const label_run *run, label_item *item) {
    const double nan = (double)NAN;
    forget_picture(item); /* of an earlier round */
    item->made = (rendered){.valid = 1};
    item->label = (nqm_label){nan, {nan, nan, nan}, nan, nan, 0};
    item->jod = item->valid = nan;
    if (item->err.status != NQM_OK)
        return item->err.status;
    item->rgb_cdm2 = allocate(9 * nqm_scene_get_info(run->scene).n_points, sizeof *item->rgb_cdm2);
    const nqm_texture_view view = view_of_group(run, item->reference);
    if (item->texture)
        return nqm_scene_render_texture(run->scene, item->texture, &view, item->rgb_cdm2, &item->err);
    return render_brdf(run->scene, item->argument, true, item->rgb_cdm2, &item->made, &item->err);
}

static nqm_scene_picture picture_of(const label_item *item) {
    return (nqm_scene_picture){item->made.brdf, item->rgb_cdm2, item->made.valid};
}

/* Render item i and compare it with its reference. Errors of tests are stored in the item. */
static nqm_status label_item_at(label_run *run, size_t i) {
    label_item *item = &run->items[i], *reference = &run->items[item->reference];
    nqm_status status = render_item(run, item);
    if (item == reference)
        return status;
    const nqm_scene_picture seen = picture_of(reference), test = picture_of(item);
    if (status == NQM_OK)
        status = nqm_scene_label(run->scene, &seen, &test, &item->label, NULL, &item->valid, &item->err);
    if (status == NQM_OK) {
        item->points_error = nqm_scene_compare(run->scene, reference->rgb_cdm2, item->rgb_cdm2, NULL).error;
        const nqm_label_info info = nqm_label_get_info(&item->label);
        item->jod = nqm_curve_jod(&info.curve, item->label.delta_e);
    }
    if (!run->keep_rgb)
        forget_picture(item);
    return NQM_OK;
}

/* The progress of one picture as that of the run. */
static int show_label_progress(void *user, const char *stage, double done, double total) {
    const label_run *run = user;
    if (!run->scene || strcmp(stage, "table") == 0)
        return show_scene_progress(NULL, stage, done, total);
    return show_progress(NULL, "label", 100 * ((double)run->n_done + done / total) / (double)run->n_items, 100);
}

/* Mark the tests that need more samples, and their references: the standard error is above 1 % of Delta-E or .01 JOD. More
 * samples of the kind, points or directions, that makes the error larger than that. */
static size_t mark_uncertain(label_run *run, nqm_scene_options *options) {
    size_t n = 0;
    bool points = false, lights = false, has_texture = false;
    static const double enough = 0.7; /* two parts of this size make an error of 1 */
    for (size_t i = 0; i < run->n_items; ++i)
        run->items[i].is_done = true;
    for (size_t i = 0; i < run->n_items; ++i) {
        label_item *item = &run->items[i], *reference = &run->items[item->reference];
        const nqm_label *l = &item->label;
        double excess = fmax(l->error / (0.01 * fmax(l->delta_e, 1)), nqm_label_get_info(l).jod_error / 0.01);
        if (item == reference || item->err.status != NQM_OK || !(excess > 1))
            continue;
        item->is_done = reference->is_done = false;
        has_texture |= item->texture != NULL;
        const double share = item->points_error / l->error; /* the error is the root of the sum of two squares */
        points |= excess * share > enough;
        lights |= excess * sqrt(fmax(1 - share * share, 0)) > enough;
        ++n;
    }
    options->n_points *= points ? 2 : 1;
    options->n_lights = nqm_scene_n_lights(options) * (lights        ? 3
                                                       : has_texture ? 1
                                                                     : 2); /* blur by few directions is in no error */
    return n;
}

/* Render all items that are not done in one scene. */
static void make_round(label_run *run, const nqm_scene_options *options) {
    nqm_scene_free(run->scene);
    run->scene = NULL;
    must(nqm_scene_create(options, &run->scene, &fault));
    for (run->n_done = 0; run->n_done < run->n_items; ++run->n_done) {
        if (!run->items[run->n_done].is_done && label_item_at(run, run->n_done) != NQM_OK)
            stop_error(&run->items[run->n_done].err);
        if (interrupted())
            stop(EXIT_INTERRUPTED, "interrupted");
    }
}

void set_shrink(label_run *run, uint64_t shrink, const char *no_pictures) {
    const nqm_scene_options *o = &run->scene_options;
    run->shrink = (size_t)shrink;
    if (!o->width)
        stop(EXIT_USAGE, "%s", no_pictures);
    if (o->width % run->shrink || o->height % run->shrink)
        stop(EXIT_USAGE, "--shrink must divide the size of the picture");
}

void make_labels(label_run *run) {
    enum { MAX_ROUNDS = 3 };
    run->scene_options.progress = show_label_progress;
    run->scene_options.progress_user = run;
    nqm_scene_options options = run->scene_options;
    if (!run->view.n_samples)
        run->view = nqm_scene_texture_view_default();
    open_textures(run);
    make_round(run, &options);
    for (size_t round = 1; run->adds_samples && round < MAX_ROUNDS && mark_uncertain(run, &options) > 0; ++round)
        make_round(run, &options);
    end_progress();
}

void map_labels(label_run *run) {
    const size_t n_points = nqm_scene_get_info(run->scene).n_points;
    const double **maps = allocate(run->n_items, sizeof *maps);
    size_t n_maps = 0;
    run->delta_e = allocate(run->n_items * n_points, sizeof *run->delta_e);
    for (size_t i = 0; i < run->n_items; ++i) {
        const nqm_scene_picture seen = picture_of(&run->items[run->items[i].reference]),
                                test = picture_of(&run->items[i]);
        nqm_label label;
        if (run->items[i].reference == i || run->items[i].err.status != NQM_OK)
            continue;
        must(nqm_scene_label(run->scene, &seen, &test, &label, run->delta_e + i * n_points, NULL, &fault));
        maps[n_maps++] = run->delta_e + i * n_points;
    }
    must(nqm_map_scale(n_maps, maps, n_points, &run->delta_e_max, &fault));
    free(maps);
}

void free_labels(label_run *run) {
    for (size_t i = 0; i < run->n_items; ++i) {
        forget_picture(&run->items[i]);
        nqm_texture_free(run->items[i].texture);
        nqm_argument_free(run->items[i].argument);
    }
    free(run->items);
    free(run->delta_e);
    nqm_scene_free(run->scene);
}

/* ---- output ------------------------------------------------------------------------------------------------------ */

static bool is_reference(const label_run *run, size_t i) {
    return run->items[i].reference == i;
}

/* Mean luminance of the picture of a reference, cd/m2 (weights of BT.709). */
static double mean_luminance(const label_run *run, const double *rgb_cdm2) {
    size_t n = nqm_scene_get_info(run->scene).n_points;
    const double *weight = nqm_scene_get_info(run->scene).weights;
    double sum = 0;
    for (size_t i = 0; i < n; ++i)
        sum += (weight ? weight[i] : 1 / (double)n) *
               (0.2126 * rgb_cdm2[3 * i] + 0.7152 * rgb_cdm2[3 * i + 1] + 0.0722 * rgb_cdm2[3 * i + 2]);
    return sum;
}

static bool has_textures(const label_run *run) {
    for (size_t i = 0; i < run->n_items; ++i)
        if (run->items[i].texture)
            return true;
    return false;
}

static json_t *item_json(const label_run *run, const label_item *item) {
    const label_item *reference = &run->items[item->reference];
    const nqm_score_result parts = {.parts = item->label};
    json_t *row =
        json_row("test:s name:s delta_e_itp:f jod:f delta_e_error:f jod_error:f parts:o reference_luminance_cdm2:f "
                 "valid:f tabulated:{reference:b test:b} reference:o error:o",
                 item->name, item->shown, item->label.delta_e, item->jod, item->label.error,
                 nqm_label_get_info(&item->label).jod_error, isnan(item->label.structure) ? json_null() : json_object(),
                 mean_luminance(run, reference->rgb_cdm2), item->valid, reference->made.is_tabulated,
                 item->made.is_tabulated, run->n_groups > 1 ? json_name(reference->name) : NULL,
                 item->err.status != NQM_OK ? json_name(item->err.message) : NULL);
    return set_columns(row, COLUMNS_PARTS | COLUMNS_OF_LABEL, NULL, &parts, NULL);
}

json_t *json_labels(const label_run *run) {
    json_t *results = json_array();
    for (size_t i = 0; i < run->n_items; ++i)
        if (!is_reference(run, i))
            json_array_append_new(results, item_json(run, &run->items[i]));
    json_t *scene = json_scene(&run->scene_options);
    if (has_textures(run))
        json_set(scene, "tiles:f texels:z", run->view.tiles, run->view.n_samples);
    return json_row("schema:i tool:o reference:s scene:o results:o delta_e_max:o", 1, json_tool(), run->items[0].name,
                    scene, results, run->map || run->keep ? json_number(run->delta_e_max) : NULL);
}

static void print_csv_tests(const label_run *run) {
    char *columns =
        list_columns(run->n_groups > 1 ? "test,delta_e_itp,jod,error,reference" : "test,delta_e_itp,jod,error",
                     COLUMNS_PARTS | COLUMNS_OF_LABEL, NULL, ",name,delta_e_error,jod_error,valid");
    print_csv_line(stdout, columns, NULL, NULL);
    for (size_t i = 0; i < run->n_items; ++i) {
        const label_item *item = &run->items[i];
        const row_text texts[] = {{"test", item->name},
                                  {"error", item->err.message},
                                  {"reference", run->items[item->reference].name},
                                  {"name", item->shown},
                                  {0}};
        json_t *row = is_reference(run, i) ? NULL : item_json(run, item);
        if (row)
            print_csv_line(stdout, columns, row, texts);
        json_decref(row);
    }
    free(columns);
}

static void print_text_test(const label_item *item) {
    const nqm_label_info info = nqm_label_get_info(&item->label);
    if (item->err.status != NQM_OK) {
        printf("%9s  %6s  %10s  %-20s  %s\n", "", "", "", "failed", shown(item->shown));
        return;
    }
    printf("%9.3f  %6.2f  %10.2f  %-20s  %s\n", item->label.delta_e, item->jod, info.adapted_jod,
           item->label.delta_e > 0 ? nqm_verdict_words(item->jod) : "equal pictures", shown(item->shown));
    print_phrases(info.words);
    if (info.jod_error > 0.02)
        printf("%16s (standard error %.2f JOD; --points and --lights add samples)\n", "", info.jod_error);
    if (item->valid < 1)
        printf("%16s (no value for %.3g %% of the light, which counts in neither picture)\n", "",
               100 * (1 - item->valid));
}

static void print_labels(const label_run *run) {
    if (run->format == FORMAT_JSON) {
        print_json(json_labels(run));
        return;
    }
    if (run->format == FORMAT_CSV) {
        print_csv_tests(run);
        return;
    }
    for (size_t i = 0; i < run->n_items; ++i) {
        const label_item *item = &run->items[i];
        if (is_reference(run, i)) {
            if (run->format == FORMAT_TEXT)
                printf("reference  %s\n%9s  %6s  %10s  %-20s  test\n", shown(item->shown), "Delta-E", "JOD", "adapted",
                       "verdict");
        } else if (run->format == FORMAT_QUIET) {
            printf("%.4f\n", item->jod);
        } else {
            print_text_test(item);
        }
    }
    if (run->format == FORMAT_TEXT && (run->map || run->keep))
        printf("colours of differences: Delta-E 0 (dark) to %.6g and above (bright)\n", run->delta_e_max);
}

/* ---- figures ----------------------------------------------------------------------------------------------------- */

double *item_picture(const label_run *run, size_t i, const canvas *c, backdrop kind) {
    return run->items[i].err.status == NQM_OK ? draw_picture(run->scene, c, kind, run->items[i].rgb_cdm2) : NULL;
}

double *item_map(const label_run *run, size_t i, const canvas *c) {
    if (run->items[i].err.status != NQM_OK || is_reference(run, i))
        return NULL;
    double *map = allocate(c->width * c->height, sizeof *map);
    draw_map(run->scene, c, run->delta_e + i * nqm_scene_get_info(run->scene).n_points, map);
    return map;
}

/* panels (n_rows, n_columns) and what they show are freed. */
static void write_figure(const label_run *run, const char *path, size_t n_rows, size_t n_columns, nqm_panel *panels) {
    const canvas all = all_frames(&run->scene_options);
    const nqm_figure figure = {.n_rows = n_rows,
                               .n_columns = n_columns,
                               .width = all.width,
                               .height = all.height,
                               .supersample = run->shrink,
                               .panels = panels,
                               .delta_e_max = run->delta_e_max,
                               .tone = tone_of(&run->scene_options)};
    must(nqm_figure_write(path, &figure, &fault));
    for (size_t i = 0; i < n_rows * n_columns; ++i) {
        free((void *)(uintptr_t)panels[i].rgb_cdm2);
        free((void *)(uintptr_t)panels[i].delta_e);
    }
    free(panels);
}

/* One row per test: reference, test, map. */
static void draw_tests(const label_run *run) {
    const canvas all = all_frames(&run->scene_options);
    nqm_panel *panels = allocate(3 * run->n_items, sizeof *panels);
    size_t n = 0;
    for (size_t i = 0; i < run->n_items; ++i) {
        if (is_reference(run, i))
            continue;
        panels[3 * n].rgb_cdm2 = item_picture(run, run->items[i].reference, &all, BACKDROP_WHITE);
        panels[3 * n + 1].rgb_cdm2 = item_picture(run, i, &all, BACKDROP_WHITE);
        panels[3 * n + 2].delta_e = item_map(run, i, &all);
        ++n;
    }
    write_figure(run, run->map, n, 3, panels);
}

static size_t count_columns(const label_run *run) {
    size_t most = 0;
    for (size_t i = 0; i < run->n_items; ++i) {
        size_t n = i - run->items[i].reference + 1;
        most = n > most ? n : most;
    }
    return most;
}

/* One row per group: the reference and its tests. */
static void draw_grid(const label_run *run) {
    const canvas all = all_frames(&run->scene_options);
    const size_t n_columns = count_columns(run);
    nqm_panel *panels = allocate(run->n_groups * n_columns, sizeof *panels);
    for (size_t i = 0, row = 0; i < run->n_items; ++i) {
        row += i > 0 && is_reference(run, i);
        panels[row * n_columns + i - run->items[i].reference].rgb_cdm2 = item_picture(run, i, &all, BACKDROP_WHITE);
    }
    write_figure(run, run->grid, run->n_groups, n_columns, panels);
}

/* DIR/NN-name[-frame]SUFFIX: the number distinguishes equal short names. */
static void keep_path(const label_run *run, size_t i, size_t frame, const char *suffix, char *path, size_t n_path) {
    const label_item *item = &run->items[i];
    char name[128], number[32] = "";
    if (item->shown != item->name)
        snprintf(name, sizeof name, "%s", item->shown);
    else
        short_name(item->name, name, sizeof name);
    for (char *p = name; *p; ++p)
        if (!isalnum((unsigned char)*p) && *p != '-' && *p != '.')
            *p = '_';
    if (nqm_scene_frames(&run->scene_options) > 1)
        snprintf(number, sizeof number, "-%04zu", frame + 1);
    snprintf(path, n_path, "%s/%02zu-%s%s%s", run->keep, i, name, number, suffix);
}

/* Write a frame of item i: on white as .png, on black as .exr, and its map. */
static void keep_item(const label_run *run, size_t i, size_t frame) {
    static const struct {
        backdrop backdrop;
        const char *suffix;
    } forms[] = {{BACKDROP_WHITE, ".png"}, {BACKDROP_BLACK, ".exr"}};
    const nqm_tone tone = tone_of(&run->scene_options);
    const canvas c = one_frame(&run->scene_options, frame);
    char path[4096];
    for (size_t k = 0; k < sizeof forms / sizeof *forms; ++k) {
        double *rgb_cdm2 = item_picture(run, i, &c, forms[k].backdrop);
        const nqm_picture picture = {.width = c.width, .height = c.height, .rgb_cdm2 = rgb_cdm2};
        keep_path(run, i, frame, forms[k].suffix, path, sizeof path);
        must(nqm_picture_write(path, &picture, 1, &tone, &fault));
        free(rgb_cdm2);
    }
    double *delta_e = item_map(run, i, &c);
    const nqm_picture map = {.width = c.width, .height = c.height, .delta_e = delta_e, .delta_e_max = run->delta_e_max};
    keep_path(run, i, frame, "-difference.png", path, sizeof path);
    if (delta_e)
        must(nqm_picture_write(path, &map, 1, NULL, &fault));
    free(delta_e);
}

/* Draw the requested figures and write the requested renderings. */
static void draw_labels(const label_run *run) {
    if (run->map)
        draw_tests(run);
    if (run->grid)
        draw_grid(run);
    for (size_t i = 0; run->keep && i < run->n_items; ++i)
        for (size_t frame = 0; run->items[i].err.status == NQM_OK && frame < nqm_scene_frames(&run->scene_options);
             ++frame)
            keep_item(run, i, frame);
}

/* ---- arguments --------------------------------------------------------------------------------------------------- */

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
