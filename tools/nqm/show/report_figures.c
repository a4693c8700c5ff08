/* SPDX-License-Identifier: MIT
 *
 * The figures of a report. Each is drawn to a temporary file, embedded in the page and removed.
 */
#include "nqm/show/report.h"

#include <stdlib.h>
#include <unistd.h>

enum { SCALE_STEPS = 256 };

void begin_figures(report_page *page) {
    const label_run *labels = &page->run->labels;
    size_t n_tests = labels->n_items - 1, n_points = nqm_scene_count(labels->scene);
    page->all = all_frames(&labels->scene_options);
    const size_t n_pixels = page->all.width * page->all.height;
    page->white = make_backdrop(labels->scene, &page->all, BACKDROP_WHITE);
    page->picture = allocate(3 * n_pixels, sizeof *page->picture);
    page->map = allocate(n_pixels, sizeof *page->map);
    page->delta_e = allocate(n_tests * n_points, sizeof *page->delta_e);
    const double **maps = allocate(n_tests, sizeof *maps);
    nqm_error err = {0};
    for (size_t i = 0; i < n_tests; ++i) {
        double *map = page->delta_e + i * n_points;
        nqm_scene_delta_e_map(labels->scene, labels->items[0].rgb_cdm2, labels->items[i + 1].rgb_cdm2, map);
        maps[i] = map;
    }
    must(nqm_map_scale(n_tests, maps, n_points, &page->delta_e_max, &err), &err);
    free(maps);
}

void end_figures(report_page *page) {
    free(page->white);
    free(page->picture);
    free(page->map);
    free(page->delta_e);
}

/* Embed the figure, at a size in CSS pixels. */
static void embed(const report_page *page, const char *alt, size_t width, size_t height) {
    html_image(page->out, page->figure, alt, width, height);
    unlink(page->figure);
}

/* The picture in page->figure; its colours are tone-mapped or on the scale of all maps. */
static void put_pixels(const report_page *page, nqm_picture picture, size_t shrink, const char *alt) {
    const nqm_tone tone = tone_of(&page->run->labels.scene_options);
    nqm_error err = {0};
    picture.delta_e_max = page->delta_e_max;
    must(nqm_picture_write(page->figure, &picture, shrink, &tone, &err), &err);
    embed(page, alt, picture.width / shrink, picture.height / shrink);
}

void put_picture(const report_page *page, size_t item, const char *alt) {
    const label_run *labels = &page->run->labels;
    const canvas *c = &page->all;
    draw_picture(labels->scene, c, page->white, labels->items[item].rgb_cdm2, page->picture);
    put_pixels(page, (nqm_picture){.width = c->width, .height = c->height, .rgb_cdm2 = page->picture}, labels->shrink,
               alt);
}

void put_map(const report_page *page, size_t test, const char *alt) {
    const label_run *labels = &page->run->labels;
    const canvas *c = &page->all;
    draw_map(labels->scene, c, page->delta_e + test * nqm_scene_count(labels->scene), page->map);
    put_pixels(page, (nqm_picture){.width = c->width, .height = c->height, .delta_e = page->map}, labels->shrink, alt);
}

void put_scale(const report_page *page, const char *alt) {
    double steps[SCALE_STEPS];
    for (size_t i = 0; i < SCALE_STEPS; ++i)
        steps[i] = page->delta_e_max * ((double)i + 0.5) / SCALE_STEPS;
    put_pixels(page, (nqm_picture){.width = SCALE_STEPS, .height = 1, .delta_e = steps}, 1, alt);
}

void put_attribution(const report_page *page, size_t test, const char *alt) {
    const nqm_plot_options look = {.title = "", .width = 440, .height = 400, .scale = 2};
    const nqm_brdf *const brdfs[] = {page->run->brdfs[0], page->run->brdfs[test + 1]};
    nqm_error err = {0};
    must(nqm_plot_attribution(page->figure, brdfs, NULL, &look, &err), &err);
    embed(page, alt, (size_t)look.width, (size_t)look.height);
}

void put_slices(const report_page *page, size_t test, const char *alt) {
    const nqm_plot_options look = {.title = "", .width = 860, .height = 530, .scale = 2};
    const nqm_brdf *const brdfs[] = {page->run->brdfs[0], page->run->brdfs[test + 1]};
    static const char *const names[] = {"reference", "test"};
    nqm_error err = {0};
    must(nqm_plot_slices(page->figure, 2, brdfs, names, &(nqm_slice_angles){.phi_d_rad = 1.5707963267948966}, &look,
                         &err),
         &err);
    embed(page, alt, (size_t)look.width, (size_t)look.height);
}
