/* SPDX-License-Identifier: MIT
 *
 * What a section of a report has of textured materials: the map of Delta-E of the texels, scores from near and from
 * afar, which map is to blame, and small pictures of the maps.
 */
#include "figures/picture.h"
#include "nqm/show/report.h"
#include "texture/texture.h"

#include <math.h>

enum { SIDE = 160, NORMAL = NQM_SPEC_MAX_KEYS };

/* ---- numbers ----------------------------------------------------------------------------------------------------- */

static void put_row(FILE *out, const char *name, double v, const char *words) {
    html(out, "<tr><th scope='row'>%s</th><td class='n'>%.2f</td><td>%s</td></tr>\n", name, v, words);
}

static void put_scores(FILE *out, const nqm_texture_result *t) {
    char text[100];
    html(out, "<table class='metrics'><caption>Over the texels</caption>\n<thead><tr><th scope='col'>Score</th>"
              "<th scope='col' class='n'>JOD</th><th scope='col'></th></tr></thead>\n<tbody>\n");
    snprintf(text, sizeof text, "the texels are seen: mean of %zu x %zu", t->width, t->height);
    put_row(out, "near", t->jod, text);
    snprintf(text, sizeof text, "the texture is smaller than a pixel (%.2f to %.2f)", t->far_jod[1], t->far_jod[2]);
    put_row(out, "from afar", t->far_jod[0], isnan(t->far_jod[1]) ? "the texture is smaller than a pixel" : text);
    put_row(out, "median texel", t->median, "");
    snprintf(text, sizeof text, "%.1f %% of texels are below 9, %.1f %% below 8", 100 * t->below[0], 100 * t->below[1]);
    put_row(out, "worst 5 %", t->worst, text);
    for (size_t i = 0; i < t->n_blame; ++i) {
        snprintf(text, sizeof text, "%.47s alone", t->blame[i].key);
        put_row(out, text, t->blame[i].jod, t->blame[i].mistake);
    }
    html(out, "</tbody></table>\n");
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

static void put_map_of(const report_page *page, const nqm_texture *texture, size_t property) {
    const char *key = property == NORMAL ? "normal" : texture->keys[property].name;
    const size_t tiles[2] = {1, 1};
    shown_map m = {texture, property};
    nqm_raster r = {.width = SIDE, .height = SIDE, .channels = 3};
    nqm_error err = {0};
    must(write_texels(texture, tiles, write_texel, &m, &r, &err), &err);
    must(nqm_raster_write_png(page->figure, &r, true, &err), &err);
    nqm_raster_clear(&r);
    html(page->out, "<figure>");
    put_figure(page, key, SIDE, SIDE);
    html(page->out, "<figcaption>%s</figcaption></figure>\n", key);
}

static void put_maps(const report_page *page, const char *who, const nqm_texture *texture) {
    if (!texture)
        return;
    html(page->out, "<p class='note'>Maps of the %s:</p>\n<div class='maps'>\n", who);
    for (size_t k = 0; k < texture->n_properties; ++k)
        if (texture->properties[k].node != NQM_NO_NODE)
            put_map_of(page, texture, k);
    if (texture->normal != NQM_NO_NODE)
        put_map_of(page, texture, NORMAL);
    html(page->out, "</div>\n");
}

void put_texture(const report_page *page) {
    const scored_pair *row = page->row;
    if (!row->texture)
        return;
    html(page->out, "<div class='two'>\n<figure>");
    const double end = write_heat(page->figure, row->texture, row->heat);
    put_figure(page, "Map of Delta-E ITP of the texels", 440, 440);
    html(page->out,
         "<figcaption>\xce\x94"
         "E&#160;ITP of each texel, 0 (dark) to %.3g and above (bright)</figcaption></figure>\n<div>\n",
         end);
    put_scores(page->out, row->texture);
    html(page->out, "</div>\n</div>\n");
    put_maps(page, "reference", page->run->labels.items[0].texture);
    put_maps(page, "test", page->item->texture);
}
