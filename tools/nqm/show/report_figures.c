/* SPDX-License-Identifier: MIT
 *
 * The pictures of a report. Each is written to a temporary file, embedded in the page and removed.
 */
#include "nqm/show/report.h"

#include <stdlib.h>
#include <unistd.h>

enum { SCALE_STEPS = 256 };

json_t *take_figure(const report_page *page, const char *alt, size_t width, size_t height) {
    json_t *image = html_image(page->figure, alt, width, height);
    unlink(page->figure);
    return image;
}

/* Colours are tone-mapped or on the scale of all maps. */
static json_t *draw(const report_page *page, nqm_picture picture, size_t shrink, const char *alt) {
    const nqm_tone tone = tone_of(&page->run->labels.scene_options);
    nqm_error err = {0};
    picture.delta_e_max = page->run->labels.delta_e_max;
    must(nqm_picture_write(page->figure, &picture, shrink, &tone, &err), &err);
    return take_figure(page, alt, picture.width / shrink, picture.height / shrink);
}

json_t *draw_item(const report_page *page, size_t item, const char *alt) {
    const label_run *labels = &page->run->labels;
    const canvas *c = &page->all;
    double *picture = allocate(3 * c->width * c->height, sizeof *picture);
    draw_picture(labels->scene, c, page->white, labels->items[item].rgb_cdm2, picture);
    json_t *image =
        draw(page, (nqm_picture){.width = c->width, .height = c->height, .rgb_cdm2 = picture}, labels->shrink, alt);
    free(picture);
    return image;
}

json_t *draw_difference(const report_page *page, size_t item) {
    const label_run *labels = &page->run->labels;
    const canvas *c = &page->all;
    const double *delta_e = labels->delta_e + item * nqm_scene_count(labels->scene);
    double *map = allocate(c->width * c->height, sizeof *map);
    char alt[100];
    snprintf(alt, sizeof alt, "Map of the colour difference of the two pictures, mean %.2f",
             labels->items[item].label.delta_e);
    draw_map(labels->scene, c, delta_e, map);
    json_t *image =
        draw(page, (nqm_picture){.width = c->width, .height = c->height, .delta_e = map}, labels->shrink, alt);
    free(map);
    return image;
}

json_t *draw_scale(const report_page *page) {
    double steps[SCALE_STEPS];
    for (size_t i = 0; i < SCALE_STEPS; ++i)
        steps[i] = page->run->labels.delta_e_max * ((double)i + 0.5) / SCALE_STEPS;
    return draw(page, (nqm_picture){.width = SCALE_STEPS, .height = 1, .delta_e = steps}, 1,
                "Colour scale from dark (equal) to bright (different)");
}
