/* SPDX-License-Identifier: MIT
 *
 * The data of a report's section about one test: its score in words, pictures, metrics, warnings.
 */
#include "nqm/show/report.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static json_t *json_words(const nqm_label *label) {
    char words[NQM_LABEL_TEXT];
    return isnan(label->structure) ? json_null() : json_string(nqm_label_describe(label, words));
}

static void add_parts(json_t *rows, const char *label, const nqm_label *l) {
    json_t *numbers = json_array();
    for (size_t c = 0; c < 3; ++c)
        json_array_append_new(numbers, html_number(l->shift[c], 2, 'f'));
    json_array_append_new(numbers, html_number(l->contrast, 3, 'f'));
    json_array_append_new(numbers, html_number(l->structure, 2, 'f'));
    json_array_append_new(numbers, html_number(nqm_label_adapted_jod(l), 2, 'f'));
    json_array_append_new(rows, json_pack("{s:s,s:o}", "label", label, "numbers", numbers));
}

static json_t *json_parts(const nqm_label *predicted, const nqm_label *seen) {
    json_t *rows = json_array();
    if (!isnan(predicted->structure))
        add_parts(rows, "Predicted", predicted);
    add_parts(rows, "Pictures", seen);
    return rows;
}

static json_t *json_metrics(const nqm_score_result *r) {
    json_t *rows = json_array();
    for (int m = 0; m < NQM_METRIC_COUNT; ++m) {
        const nqm_metric_info info = nqm_metric_get_info((nqm_metric)m);
        json_array_append_new(rows, json_pack("{s:s,s:o,s:s}", "metric", info.name, "value",
                                              html_number(r->metrics[m], 4, '#'), "description", info.description));
    }
    return rows;
}

static json_t *json_counts(const nqm_score_result *r) {
    json_t *rows = json_array();
    for (size_t k = 0; k < 2; ++k)
        json_array_append_new(rows, json_pack("{s:s,s:[I,I,I]}", "label", k ? "Test" : "Reference", "numbers",
                                              (json_int_t)r->n_clamped[k], (json_int_t)r->n_invalid[k],
                                              (json_int_t)r->n_unusual[k]));
    return rows;
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

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

static json_t *draw_item(const report_page *page, size_t item, const char *alt) {
    const label_run *labels = &page->run->labels;
    const canvas *c = &page->all;
    double *picture = allocate(3 * c->width * c->height, sizeof *picture);
    draw_picture(labels->scene, c, page->white, labels->items[item].rgb_cdm2, picture);
    json_t *image =
        draw(page, (nqm_picture){.width = c->width, .height = c->height, .rgb_cdm2 = picture}, labels->shrink, alt);
    free(picture);
    return image;
}

static json_t *draw_difference(const report_page *page, size_t item) {
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

static json_t *draw_scale(const report_page *page) {
    double steps[SCALE_STEPS];
    for (size_t i = 0; i < SCALE_STEPS; ++i)
        steps[i] = page->run->labels.delta_e_max * ((double)i + 0.5) / SCALE_STEPS;
    return draw(page, (nqm_picture){.width = SCALE_STEPS, .height = 1, .delta_e = steps}, 1,
                "Colour scale from dark (equal) to bright (different)");
}

/* ---- the section ------------------------------------------------------------------------------------------------- */

json_t *json_test(const report_page *page, const scored_pair *row) {
    const score_run *scores = &page->run->scores;
    const nqm_score_result *r = &row->result;
    const size_t i = row->order + 1;
    const label_item *item = &page->run->labels.items[i];
    const bool is_renamed = strcmp(page->run->names[i], row->pair.test) != 0;
    json_t *remarks = json_remarks(&scores->terms, &row->pair, "reference", "test", r);
    json_t *json = json_pack(
        "{s:o,s:b,s:b,s:o,s:o,s:o,s:o,s:o,s:o,s:b}", "argument", is_renamed ? json_name(row->pair.test) : json_null(),
        "identical", r->identical, "different", !r->identical, "predicted", json_words(&r->parts), "seen",
        json_words(&item->label), "parts", json_parts(&r->parts, &item->label), "metrics", json_metrics(r), "valid",
        json_sprintf("%zu of %zu", r->n_valid, scores->terms.n_directions), "counts", json_counts(r), "plain",
        row->texture == NULL);
    if (json_array_size(remarks))
        json_object_set_new(json, "remarks", json_pack("{s:O}", "list", remarks));
    json_decref(remarks);
    json_object_set_new(json, "picture_ref", draw_item(page, 0, "Rendered picture of the reference"));
    json_object_set_new(json, "picture_test", draw_item(page, i, "Rendered picture of the test"));
    json_object_set_new(json, "picture_map", draw_difference(page, i));
    json_object_set_new(json, "picture_scale", draw_scale(page));
    json_object_set_new(json, "texture", row->texture ? json_report_texture(page, row) : json_null());
    return json;
}
