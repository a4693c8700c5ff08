/* SPDX-License-Identifier: MIT
 *
 * The figures of nqm label: one row per test (reference, test, map of Delta-E), or one row per reference (reference and its
 * tests), each with all frames of the scene; and every frame as a file.
 */
#include "nqm/label/label.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_CELLS = 64 };

/* Picture and map of an item. */
typedef struct view {
    double *picture; /* (height, width, 3) of a canvas; NULL: the item failed */
    double *map;     /* (height, width); NULL also for references */
} view;

typedef struct drawing {
    const label_run *run;
    canvas all;           /* frames */
    double *backdrops[2]; /* BACKDROP_WHITE, BACKDROP_BLACK, of all frames; the beginning is that of one */
    view *views;          /* (n_items) */
} drawing;

static bool is_reference(const label_run *run, size_t i) {
    return run->items[i].reference == i;
}

/* Fill the picture and the map of item i. */
static void fill_view(const drawing *d, size_t i, const canvas *c, backdrop kind) {
    const view *v = &d->views[i];
    const label_run *run = d->run;
    const label_item *item = &run->items[i];
    draw_picture(run->scene, c, d->backdrops[kind], item->rgb_cdm2, v->picture);
    if (v->map)
        draw_map(run->scene, c, run->delta_e + i * nqm_scene_count(run->scene), v->map);
}

static void make_views(drawing *d) {
    const label_run *run = d->run;
    const size_t n_pixels = d->all.width * d->all.height;
    for (size_t i = 0; i < run->n_items; ++i) {
        const label_item *item = &run->items[i];
        view *v = &d->views[i];
        if (item->err.status != NQM_OK)
            continue;
        v->picture = allocate(3 * n_pixels, sizeof *v->picture);
        if (!is_reference(run, i))
            v->map = allocate(n_pixels, sizeof *v->map);
        fill_view(d, i, &d->all, BACKDROP_WHITE);
    }
}

static nqm_figure figure_of(const drawing *d, const canvas *c, size_t n_rows, size_t n_columns,
                            const nqm_panel *panels) {
    return (nqm_figure){.n_rows = n_rows,
                        .n_columns = n_columns,
                        .width = c->width,
                        .height = c->height,
                        .supersample = d->run->shrink,
                        .panels = panels,
                        .delta_e_max = d->run->delta_e_max,
                        .tone = tone_of(&d->run->scene_options)};
}

/* One row per test: reference, test, map. */
static void draw_tests(const drawing *d) {
    const label_run *run = d->run;
    nqm_panel panels[3 * MAX_CELLS] = {0};
    nqm_error err = {0};
    size_t n = 0;
    for (size_t i = 0; i < run->n_items; ++i) {
        if (is_reference(run, i))
            continue;
        panels[3 * n].rgb_cdm2 = d->views[run->items[i].reference].picture;
        panels[3 * n + 1].rgb_cdm2 = d->views[i].picture;
        panels[3 * n + 2].delta_e = d->views[i].map;
        ++n;
    }
    const nqm_figure figure = figure_of(d, &d->all, n, 3, panels);
    must(nqm_figure_write(run->map, &figure, &err), &err);
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
static void draw_grid(const drawing *d) {
    const label_run *run = d->run;
    const size_t n_columns = count_columns(run);
    nqm_panel *panels = allocate(run->n_groups * n_columns, sizeof *panels);
    nqm_error err = {0};
    for (size_t i = 0, row = 0; i < run->n_items; ++i) {
        row += i > 0 && is_reference(run, i);
        panels[row * n_columns + i - run->items[i].reference].rgb_cdm2 = d->views[i].picture;
    }
    const nqm_figure figure = figure_of(d, &d->all, run->n_groups, n_columns, panels);
    must(nqm_figure_write(run->grid, &figure, &err), &err);
    free(panels);
}

/* DIR/NN-name[-frame]SUFFIX: the number distinguishes equal short names. */
static void keep_path(const drawing *d, size_t i, size_t frame, const char *suffix, char *path, size_t n_path) {
    const label_item *item = &d->run->items[i];
    char name[128], number[32] = "";
    if (item->shown != item->name)
        snprintf(name, sizeof name, "%s", item->shown);
    else
        short_name(item->name, name, sizeof name);
    for (char *p = name; *p; ++p)
        if (!isalnum((unsigned char)*p) && *p != '-' && *p != '.')
            *p = '_';
    if (nqm_scene_frames(&d->run->scene_options) > 1)
        snprintf(number, sizeof number, "-%04zu", frame + 1);
    snprintf(path, n_path, "%s/%02zu-%s%s%s", d->run->keep, i, name, number, suffix);
}

/* Write a frame of item i: on white as .png, on black as .exr, and its map. */
static void keep_item(const drawing *d, size_t i, size_t frame) {
    static const struct {
        backdrop backdrop;
        const char *suffix;
    } forms[] = {{BACKDROP_WHITE, ".png"}, {BACKDROP_BLACK, ".exr"}};
    const nqm_scene_options *o = &d->run->scene_options;
    const nqm_tone tone = tone_of(o);
    const canvas c = one_frame(o, frame);
    const view *v = &d->views[i];
    const nqm_picture picture = {.width = o->width, .height = o->height, .rgb_cdm2 = v->picture};
    char path[4096];
    nqm_error err = {0};
    for (size_t k = 0; k < sizeof forms / sizeof *forms; ++k) {
        fill_view(d, i, &c, forms[k].backdrop);
        keep_path(d, i, frame, forms[k].suffix, path, sizeof path);
        must(nqm_picture_write(path, &picture, 1, &tone, &err), &err);
    }
    if (!v->map)
        return;
    const nqm_picture map = {
        .width = o->width, .height = o->height, .delta_e = v->map, .delta_e_max = d->run->delta_e_max};
    keep_path(d, i, frame, "-difference.png", path, sizeof path);
    must(nqm_picture_write(path, &map, 1, NULL, &err), &err);
}

static void keep_renders(const drawing *d) {
    for (size_t i = 0; i < d->run->n_items; ++i)
        for (size_t frame = 0; d->views[i].picture && frame < nqm_scene_frames(&d->run->scene_options); ++frame)
            keep_item(d, i, frame);
}

void draw_labels(const label_run *run) {
    if (!run->map && !run->grid && !run->keep)
        return;
    if (run->n_items - run->n_groups > MAX_CELLS || count_columns(run) > MAX_CELLS || run->n_groups > MAX_CELLS)
        stop(EXIT_LIMIT, "a figure can show at most %d tests", (int)MAX_CELLS);
    const canvas all = all_frames(&run->scene_options);
    drawing d = {.run = run,
                 .all = all,
                 .backdrops = {[BACKDROP_WHITE] = make_backdrop(run->scene, &all, BACKDROP_WHITE),
                               [BACKDROP_BLACK] = make_backdrop(run->scene, &all, BACKDROP_BLACK)},
                 .views = allocate(run->n_items, sizeof *d.views)};
    make_views(&d);
    if (run->map)
        draw_tests(&d);
    if (run->grid)
        draw_grid(&d);
    if (run->keep) /* last, because it overwrites the views with other frames */
        keep_renders(&d);
    for (size_t i = 0; i < run->n_items; ++i) {
        free(d.views[i].picture);
        free(d.views[i].map);
    }
    free(d.views);
    free(d.backdrops[BACKDROP_WHITE]);
    free(d.backdrops[BACKDROP_BLACK]);
}
