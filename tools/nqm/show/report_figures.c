/* SPDX-License-Identifier: MIT
 *
 * The figures of a report. Each is drawn to a temporary file, embedded in the page and removed.
 */
#include "nqm/show/report.h"

#include <stdlib.h>
#include <unistd.h>

enum { SCALE_STEPS = 256 };

static const nqm_scene_options *scene_options(const report_page *page) {
    return &page->run->labels.scene_options;
}

int begin_figures(report_page *page) {
    const label_run *labels = &page->run->labels;
    const nqm_scene_options *o = scene_options(page);
    size_t n_tests = labels->n_items - 1, n_points = nqm_scene_count(labels->scene);
    page->white = make_backdrop(labels->scene, o, BACKDROP_WHITE);
    page->picture = calloc(3 * o->width * o->height, sizeof *page->picture);
    page->map = calloc(o->width * o->height, sizeof *page->map);
    page->delta_e = calloc(n_tests * n_points, sizeof *page->delta_e);
    const double **maps = calloc(n_tests, sizeof *maps);
    nqm_error err = {.status = NQM_ERR_NOMEM, .byte_offset = -1};
    nqm_status status = NQM_ERR_NOMEM;
    if (page->white && page->picture && page->map && page->delta_e && maps) {
        for (size_t i = 0; i < n_tests; ++i) {
            double *map = page->delta_e + i * n_points;
            nqm_scene_delta_e_map(labels->scene, labels->items[0].rgb_cdm2, labels->items[i + 1].rgb_cdm2, map);
            maps[i] = map;
        }
        status = nqm_map_scale(n_tests, maps, n_points, &page->delta_e_max, &err);
    }
    free(maps);
    return status == NQM_OK ? EXIT_OK : report_error("report", &err);
}

void end_figures(report_page *page) {
    free(page->white);
    free(page->picture);
    free(page->map);
    free(page->delta_e);
}

/* Embed the figure that was drawn with `status`, at a size in CSS pixels. */
static int embed(const report_page *page, nqm_status status, const nqm_error *err, const char *alt, size_t width,
                 size_t height) {
    if (status != NQM_OK)
        return report_error("report", err);
    const html_picture picture = {page->figure, alt, width, height};
    int exit_code = html_image("report", page->out, &picture);
    unlink(page->figure);
    return exit_code;
}

int put_picture(const report_page *page, size_t item, const char *alt) {
    const label_run *labels = &page->run->labels;
    const nqm_scene_options *o = scene_options(page);
    const nqm_tone tone = tone_of(o);
    const nqm_picture picture = {.width = o->width, .height = o->height, .rgb_cdm2 = page->picture};
    nqm_error err = {0};
    frame_picture(labels->scene, o, 0, page->white, labels->items[item].rgb_cdm2, page->picture);
    nqm_status status = nqm_picture_write(page->figure, &picture, labels->shrink, &tone, &err);
    return embed(page, status, &err, alt, o->width / labels->shrink, o->height / labels->shrink);
}

int put_map(const report_page *page, size_t test, const char *alt) {
    const label_run *labels = &page->run->labels;
    const nqm_scene_options *o = scene_options(page);
    nqm_error err = {0};
    frame_map(labels->scene, o, 0, page->delta_e + test * nqm_scene_count(labels->scene), page->map);
    nqm_status status =
        nqm_map_write(page->figure, o->width, o->height, page->map, labels->shrink, page->delta_e_max, &err);
    return embed(page, status, &err, alt, o->width / labels->shrink, o->height / labels->shrink);
}

int put_scale(const report_page *page, const char *alt) {
    double steps[SCALE_STEPS];
    nqm_error err = {0};
    for (size_t i = 0; i < SCALE_STEPS; ++i)
        steps[i] = page->delta_e_max * ((double)i + 0.5) / SCALE_STEPS;
    nqm_status status = nqm_map_write(page->figure, SCALE_STEPS, 1, steps, 1, page->delta_e_max, &err);
    return embed(page, status, &err, alt, SCALE_STEPS, 1);
}

int put_attribution(const report_page *page, size_t test, const char *alt) {
    const nqm_plot_options look = {.title = "", .width = 440, .height = 400, .scale = 2};
    const score_run *scores = &page->run->scores;
    nqm_error err = {0};
    nqm_status status = nqm_plot_attribution(page->figure, scores->ref, scores->rows[test].brdf, &look, &err);
    return embed(page, status, &err, alt, (size_t)look.width, (size_t)look.height);
}

int put_slices(const report_page *page, size_t test, const char *alt) {
    const nqm_plot_options look = {.title = "", .width = 860, .height = 530, .scale = 2};
    const score_run *scores = &page->run->scores;
    const nqm_brdf *const brdfs[] = {scores->ref, scores->rows[test].brdf};
    static const char *const names[] = {"reference", "test"};
    nqm_error err = {0};
    nqm_status status = nqm_plot_slices(page->figure, 2, brdfs, names, 0, 1.5707963267948966, &look, &err);
    return embed(page, status, &err, alt, (size_t)look.width, (size_t)look.height);
}
