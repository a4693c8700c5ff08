/* SPDX-License-Identifier: MIT
 *
 * The figures of nqm label, of the first frame: one row per test (reference, test, map of Delta-E), or one row per reference
 * (reference and its tests); and every frame as a file.
 */
#include "nqm/label/label.h"

#include <ctype.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { MAX_CELLS = 64, MAX_TITLES = 2048 };

/* Picture, map and texts of an item. */
typedef struct view {
    char name[128], caption[64];
    double *picture; /* (height, width, 3); NULL: the item failed */
    double *map;     /* (height, width); NULL also for references */
} view;

typedef struct drawing {
    const label_run *run;
    size_t n_pixels;
    double *white, *black; /* backdrops */
    double *delta_e;       /* (points) */
    view *views;           /* (n_items) */
} drawing;

static bool is_reference(const label_run *run, size_t i) {
    return run->items[i].reference == i;
}

/* Fill the picture and the map of item i in one frame. */
static void view_frame(const drawing *d, size_t i, size_t frame, const double *blank, view *v) {
    const label_run *run = d->run;
    const label_item *item = &run->items[i];
    frame_picture(run->scene, &run->scene_options, frame, blank, item->rgb_cdm2, v->picture);
    if (!v->map)
        return;
    nqm_scene_delta_e_map(run->scene, run->items[item->reference].rgb_cdm2, item->rgb_cdm2, d->delta_e);
    frame_map(run->scene, &run->scene_options, frame, d->delta_e, v->map);
}

static bool make_views(drawing *d) {
    const label_run *run = d->run;
    for (size_t i = 0; i < run->n_items; ++i) {
        const label_item *item = &run->items[i];
        view *v = &d->views[i];
        short_name(item->name, v->name, sizeof v->name);
        if (item->err.status != NQM_OK) {
            snprintf(v->caption, sizeof v->caption, "failed");
            continue;
        }
        v->picture = calloc(3 * d->n_pixels, sizeof *v->picture);
        if (!is_reference(run, i)) {
            v->map = calloc(d->n_pixels, sizeof *v->map);
            snprintf(v->caption, sizeof v->caption, "\u0394E %.1f \u00b7 JOD %.2f", item->delta_e, item->jod);
        }
        if (!v->picture || (!is_reference(run, i) && !v->map))
            return false;
        view_frame(d, i, 0, d->white, v);
    }
    return true;
}

/* Split a copy of a list at its commas into titles (n). Titles missing in the list are unchanged. */
static void cut_titles(const char *list, char copy[MAX_TITLES], size_t n, const char **titles) {
    snprintf(copy, MAX_TITLES, "%s", list ? list : "");
    char *p = list ? copy : NULL;
    for (size_t i = 0; i < n && p; ++i) {
        char *comma = strchr(p, ',');
        titles[i] = p;
        p = comma ? comma + 1 : NULL;
        if (comma)
            *comma = 0;
    }
}

static nqm_figure figure_of(const drawing *d, size_t n_rows, size_t n_columns, const nqm_panel *panels) {
    const nqm_scene_options *o = &d->run->scene_options;
    return (nqm_figure){.n_rows = n_rows,
                        .n_columns = n_columns,
                        .width = o->width,
                        .height = o->height,
                        .supersample = d->run->shrink,
                        .panels = panels,
                        .tone = tone_of(o)};
}

/* One row per test: reference, test, map. */
static nqm_status draw_map(const drawing *d, nqm_error *err) {
    const label_run *run = d->run;
    nqm_panel panels[3 * MAX_CELLS] = {0};
    char row_copy[MAX_TITLES], column_copy[MAX_TITLES];
    const char *rows[MAX_CELLS] = {0}, *columns[3] = {"reference", "test", "difference"};
    size_t n = 0;
    for (size_t i = 0; i < run->n_items; ++i) {
        const view *test = &d->views[i], *ref = &d->views[run->items[i].reference];
        if (ref == test)
            continue;
        panels[3 * n] = (nqm_panel){.rgb_cdm2 = ref->picture, .caption = ref->name};
        panels[3 * n + 1] = (nqm_panel){.rgb_cdm2 = test->picture, .caption = test->name};
        panels[3 * n + 2] = (nqm_panel){.delta_e = test->map, .caption = test->caption};
        ++n;
    }
    cut_titles(run->rows, row_copy, n, rows);
    cut_titles(run->columns, column_copy, 3, columns);
    nqm_figure figure = figure_of(d, n, 3, panels);
    figure.column_titles = columns;
    figure.row_titles = rows;
    return nqm_figure_write(run->map, &figure, err);
}

static size_t count_columns(const label_run *run) {
    size_t most = 0;
    for (size_t i = 0; i < run->n_items; ++i) {
        size_t n = i - run->items[i].reference + 1;
        most = n > most ? n : most;
    }
    return most;
}

/* One row per group: the reference and its tests. Column titles come from --columns, else from the tests of the first group. */
static nqm_status draw_grid(const drawing *d, nqm_error *err) {
    const label_run *run = d->run;
    size_t n_columns = count_columns(run), row = 0;
    char row_copy[MAX_TITLES], column_copy[MAX_TITLES];
    const char *columns[MAX_CELLS] = {"reference"}, *rows[MAX_CELLS] = {0};
    nqm_panel *panels = calloc((size_t)MAX_CELLS * MAX_CELLS, sizeof *panels);
    if (!panels)
        return NQM_ERR_NOMEM;
    for (size_t i = 0; i < run->n_items; ++i) {
        size_t column = i - run->items[i].reference;
        row += i > 0 && column == 0;
        panels[row * n_columns + column] = (nqm_panel){.rgb_cdm2 = d->views[i].picture, .caption = d->views[i].caption};
        if (column == 0)
            rows[row] = d->views[i].name;
        else if (!columns[column])
            columns[column] = d->views[i].name;
    }
    cut_titles(run->rows, row_copy, run->n_groups, rows);
    cut_titles(run->columns, column_copy, n_columns, columns);
    nqm_figure figure = figure_of(d, run->n_groups, n_columns, panels);
    figure.column_titles = columns;
    figure.row_titles = rows;
    nqm_status status = nqm_figure_write(run->grid, &figure, err);
    free(panels);
    return status;
}

/* DIR/NN-name[-frame]SUFFIX: the number distinguishes equal short names. */
static void keep_path(const drawing *d, size_t i, size_t frame, const char *suffix, char *path, size_t n_path) {
    char name[sizeof d->views->name], number[32] = "";
    snprintf(name, sizeof name, "%s", d->views[i].name);
    for (char *p = name; *p; ++p)
        if (!isalnum((unsigned char)*p) && *p != '-' && *p != '.')
            *p = '_';
    if (d->run->scene_options.n_frames > 1)
        snprintf(number, sizeof number, "-%04zu", frame + 1);
    snprintf(path, n_path, "%s/%02zu-%s%s%s", d->run->keep, i, name, number, suffix);
}

static nqm_status keep_item(const drawing *d, size_t i, size_t frame, nqm_error *err) {
    const label_run *run = d->run;
    const nqm_tone tone = tone_of(&run->scene_options);
    view *v = &d->views[i];
    const nqm_picture picture = {
        .width = run->scene_options.width, .height = run->scene_options.height, .rgb_cdm2 = v->picture};
    char path[4096];
    view_frame(d, i, frame, d->white, v);
    keep_path(d, i, frame, ".png", path, sizeof path);
    nqm_status status = nqm_picture_write(path, &picture, 1, &tone, err);
    if (status == NQM_OK) {
        view_frame(d, i, frame, d->black, v);
        keep_path(d, i, frame, ".exr", path, sizeof path);
        status = nqm_picture_write(path, &picture, 1, &tone, err);
    }
    if (status != NQM_OK || !v->map)
        return status;
    const nqm_panel panel = {.delta_e = v->map, .caption = v->caption};
    nqm_figure figure = figure_of(d, 1, 1, &panel);
    figure.supersample = 1;
    keep_path(d, i, frame, "-difference.png", path, sizeof path);
    return nqm_figure_write(path, &figure, err);
}

static nqm_status keep_renders(const drawing *d, nqm_error *err) {
    nqm_status status = NQM_OK;
    if (mkdir(d->run->keep, 0777) != 0 && errno != EEXIST) {
        *err = (nqm_error){.status = NQM_ERR_IO, .byte_offset = -1};
        snprintf(err->message, sizeof err->message, "%s: cannot create the folder: %s", d->run->keep, strerror(errno));
        return NQM_ERR_IO;
    }
    for (size_t i = 0; i < d->run->n_items; ++i)
        for (size_t frame = 0; status == NQM_OK && frame < d->run->scene_options.n_frames; ++frame)
            if (d->views[i].picture)
                status = keep_item(d, i, frame, err);
    return status;
}

static nqm_status draw_all(drawing *d, nqm_error *err) {
    const label_run *run = d->run;
    *err = (nqm_error){.status = NQM_ERR_NOMEM, .byte_offset = -1};
    if (!d->white || !d->black || !d->delta_e || !d->views || !make_views(d))
        return NQM_ERR_NOMEM;
    nqm_status status = run->map ? draw_map(d, err) : NQM_OK;
    if (status == NQM_OK && run->grid)
        status = draw_grid(d, err);
    if (status == NQM_OK && run->keep) /* last, because it overwrites the views with other frames */
        status = keep_renders(d, err);
    return status;
}

int draw_labels(const label_run *run) {
    if (!run->map && !run->grid && !run->keep)
        return EXIT_OK;
    if (run->n_items - run->n_groups > MAX_CELLS || count_columns(run) > MAX_CELLS || run->n_groups > MAX_CELLS)
        return report("label", EXIT_LIMIT, "a figure holds at most %d tests", (int)MAX_CELLS);
    nqm_error err;
    const nqm_scene_options *o = &run->scene_options;
    drawing d = {.run = run,
                 .n_pixels = o->width * o->height,
                 .white = make_backdrop(run->scene, o, BACKDROP_WHITE),
                 .black = make_backdrop(run->scene, o, BACKDROP_BLACK),
                 .delta_e = calloc(nqm_scene_count(run->scene), sizeof *d.delta_e),
                 .views = calloc(run->n_items, sizeof *d.views)};
    int exit_code = draw_all(&d, &err) == NQM_OK ? EXIT_OK : report_error("label", &err);
    for (size_t i = 0; d.views && i < run->n_items; ++i) {
        free(d.views[i].picture);
        free(d.views[i].map);
    }
    free(d.views);
    free(d.delta_e);
    free(d.white);
    free(d.black);
    return exit_code;
}
