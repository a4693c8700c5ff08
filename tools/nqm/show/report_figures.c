/* SPDX-License-Identifier: MIT
 *
 * The pictures of a report. Each is written to a temporary file, embedded in the page and removed.
 */
#include "nqm/show/report.h"

#include <stdlib.h>
#include <unistd.h>

enum { SCALE_STEPS = 256 };

void put_figure(const report_page *page, const char *alt, size_t width, size_t height) {
    html_image(page->out, page->figure, alt, width, height);
    unlink(page->figure);
}

/* Colours are tone-mapped or on the scale of all maps. */
static void put_pixels(const report_page *page, nqm_picture picture, size_t shrink, const char *alt) {
    const nqm_tone tone = tone_of(&page->run->labels.scene_options);
    nqm_error err = {0};
    picture.delta_e_max = page->run->labels.delta_e_max;
    must(nqm_picture_write(page->figure, &picture, shrink, &tone, &err), &err);
    put_figure(page, alt, picture.width / shrink, picture.height / shrink);
}

static void put_picture(const report_page *page, size_t item, const char *alt) {
    const label_run *labels = &page->run->labels;
    const canvas *c = &page->all;
    double *picture = allocate(3 * c->width * c->height, sizeof *picture);
    draw_picture(labels->scene, c, page->white, labels->items[item].rgb_cdm2, picture);
    put_pixels(page, (nqm_picture){.width = c->width, .height = c->height, .rgb_cdm2 = picture}, labels->shrink, alt);
    free(picture);
}

static void put_map(const report_page *page, size_t item) {
    const label_run *labels = &page->run->labels;
    const canvas *c = &page->all;
    double *map = allocate(c->width * c->height, sizeof *map);
    char alt[100];
    snprintf(alt, sizeof alt, "Map of the colour difference of the two pictures, mean %.2f",
             labels->items[item].label.delta_e);
    draw_map(labels->scene, c, labels->delta_e + item * nqm_scene_count(labels->scene), map);
    put_pixels(page, (nqm_picture){.width = c->width, .height = c->height, .delta_e = map}, labels->shrink, alt);
    free(map);
}

static void put_scale(const report_page *page) {
    const double end = page->run->labels.delta_e_max;
    double steps[SCALE_STEPS];
    for (size_t i = 0; i < SCALE_STEPS; ++i)
        steps[i] = end * ((double)i + 0.5) / SCALE_STEPS;
    put_pixels(page, (nqm_picture){.width = SCALE_STEPS, .height = 1, .delta_e = steps}, 1,
               "Colour scale from dark (equal) to bright (different)");
    html(page->out,
         "<span class='ticks'><span>0</span><span>%.3g</span><span>\xe2\x89\xa5&#160;%.3g</span></span></span>"
         "</figcaption></figure>\n</div>\n",
         end / 2, end);
}

void put_pictures(const report_page *page, const scored_pair *row) {
    html(page->out, "<div class='triple'>\n<figure>");
    put_picture(page, 0, "Rendered picture of the reference");
    html(page->out, "<figcaption>Reference: <span class='name'>%s</span></figcaption></figure>\n<figure>",
         page->run->names[0]);
    put_picture(page, row->order + 1, "Rendered picture of the test");
    html(page->out, "<figcaption>Test: <span class='name'>%s</span></figcaption></figure>\n<figure>",
         page->run->names[row->order + 1]);
    put_map(page, row->order + 1);
    html(page->out, "<figcaption>\xce\x94"
                    "E&#160;ITP of each pixel; 1 is barely visible under ideal conditions\n<span class='scale'>");
    put_scale(page);
}
