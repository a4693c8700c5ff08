/* SPDX-License-Identifier: MIT
 *
 * The data of textured materials in a section of a report: the map of Delta-E of the texels, scores from near and from
 * afar, which map is to blame, and small pictures of the maps.
 */
#include "figures/picture.h"
#include "nqm/show/report.h"
#include "texture/texture.h"

#include <math.h>

enum { SIDE = 160, NORMAL = NQM_SPEC_MAX_KEYS };

/* ---- numbers ----------------------------------------------------------------------------------------------------- */

static void add_score(json_t *rows, const char *label, double jod, const char *about) {
    json_array_append_new(
        rows, json_pack("{s:s,s:o,s:s}", "label", label, "value", html_number(jod, 2, 'f'), "about", about));
}

static json_t *json_near_and_far(const nqm_texture_result *t) {
    json_t *rows = json_array();
    char text[100];
    snprintf(text, sizeof text, "the texels are seen: mean of %zu x %zu", t->width, t->height);
    add_score(rows, "near", t->jod, text);
    snprintf(text, sizeof text, "the texture is smaller than a pixel (%.2f to %.2f)", t->far_jod[1], t->far_jod[2]);
    add_score(rows, "from afar", t->far_jod[0], isnan(t->far_jod[1]) ? "the texture is smaller than a pixel" : text);
    add_score(rows, "median texel", t->median, "");
    snprintf(text, sizeof text, "%.1f %% of texels are below 9, %.1f %% below 8", 100 * t->below[0], 100 * t->below[1]);
    add_score(rows, "worst 5 %", t->worst, text);
    for (size_t i = 0; i < t->n_blame; ++i) {
        snprintf(text, sizeof text, "%.47s alone", t->blame[i].key);
        add_score(rows, text, t->blame[i].jod, t->blame[i].mistake);
    }
    return rows;
}

/* ---- maps -------------------------------------------------------------------------------------------------------- */

typedef struct shown_map {
    const nqm_texture *texture;
    size_t property; /* or NORMAL */
} shown_map;

/* Colours as sRGB, numbers as grey, normals as maps have them. */
static void write_texel(void *user, const float *rows, size_t i, unsigned char *out) {
    const shown_map *m = user;
    const nqm_texture *t = m->texture;
    double normal[3];
    nqm_texture_normal(t, rows, i, normal);
    for (size_t c = 0; c < 3; ++c)
        if (m->property == NORMAL)
            out[c] = unit_byte((normal[c] + 1) / 2);
        else if (t->keys[m->property].n == 3)
            out[c] = nqm_srgb_byte(nqm_texture_value(t, m->property, c, rows, i));
        else
            out[c] = unit_byte(nqm_texture_value(t, m->property, 0, rows, i));
}

static void add_map(const report_page *page, const nqm_texture *texture, size_t property, json_t *list) {
    const char *key = property == NORMAL ? "normal" : texture->keys[property].name;
    const size_t tiles[2] = {1, 1};
    shown_map m = {texture, property};
    nqm_raster r = {.width = SIDE, .height = SIDE, .channels = 3};
    nqm_error err = {0};
    must(write_texels(texture, tiles, write_texel, &m, &r, &err), &err);
    must(nqm_raster_write_png(page->figure, &r, true, &err), &err);
    nqm_raster_clear(&r);
    json_array_append_new(list, json_pack("{s:s,s:o}", "key", key, "picture", take_figure(page, key, SIDE, SIDE)));
}

static void add_maps(const report_page *page, const char *who, const nqm_texture *texture, json_t *to) {
    json_t *list = json_array();
    for (size_t k = 0; texture && k < texture->n_properties; ++k)
        if (texture->properties[k].node != NQM_NO_NODE)
            add_map(page, texture, k, list);
    if (texture && texture->normal != NQM_NO_NODE)
        add_map(page, texture, NORMAL, list);
    if (texture)
        json_array_append_new(to, json_pack("{s:s,s:O}", "who", who, "list", list));
    json_decref(list);
}

json_t *json_report_texture(const report_page *page, const scored_pair *row) {
    const label_item *items = page->run->labels.items;
    const double end = write_heat(page->figure, row->texture, row->heat);
    json_t *maps = json_array(), *heat = take_figure(page, "Map of Delta-E ITP of the texels", 440, 440);
    add_maps(page, "reference", items[0].texture, maps);
    add_maps(page, "test", items[row->order + 1].texture, maps);
    return json_pack("{s:o,s:o,s:o,s:o}", "heat", heat, "brightest", html_number(end, 3, 'g'), "scores",
                     json_near_and_far(row->texture), "maps", maps);
}
