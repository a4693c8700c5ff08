/* SPDX-License-Identifier: MIT
 *
 * The data of a report's page, which fill report.html: title, summary, guide, provenance, and the values of its charts.
 */
#include "base/os.h"
#include "figures/picture.h"
#include "nqm/show/charts.h"
#include "nqm/show/report.h"
#include "texture/texture.h"

#include <math.h>
#include <openssl/evp.h>
#include <stdlib.h>
#include <string.h>

/* The page while it is written. Its functions report an error and exit. */
typedef struct report_page {
    const report_run *run;
    char *figure; /* temporary file for a picture, a .png */
    json_t *json_labels;
    canvas all; /* frames of the scene, the pictures of the page */
} report_page;

enum { MAX_COMPARED = 12 }; /* tests in the table of preferences, which must fit on a sheet of paper */

static size_t count_tests(const report_page *page) {
    return page->run->scores.n_rows;
}

static const scored_pair *row_at(const report_page *page, size_t place) {
    return &page->run->scores.rows[place];
}

/* ---- markup ------------------------------------------------------------------------------------------------------ */

/* The text of a stream of open_text(), which is closed and freed. */
static json_t *html_text(FILE *stream, char **text) {
    size_t n;
    close_text(stream, text, &n);
    json_t *string = json_string(*text);
    free(*text);
    return string;
}

/* Markup: an <img> of width x height CSS pixels that contains the bytes of a PNG file. */
static json_t *html_image(const char *path, const char *alt, size_t width, size_t height) {
    enum { AT_ONCE = 3 * 1024 };
    unsigned char base64[AT_ONCE / 3 * 4 + 1];
    char *text;
    size_t n;
    nqm_map map;
    FILE *out = open_text(&text, &n);
    must(nqm_map_open_own(path, &map, &fault));
    fprintf(out, "<img width='%zu' height='%zu' alt='", width, height);
    escape_xml(out, alt);
    fputs("' src='data:image/png;base64,", out);
    for (size_t at = 0; at < map.n_bytes; at += AT_ONCE) {
        const int n_bytes = (int)nqm_smaller(AT_ONCE, map.n_bytes - at);
        fwrite(base64, 1, (size_t)EVP_EncodeBlock(base64, map.data + at, n_bytes), out);
    }
    nqm_map_close(&map);
    fputs("'/>\n", out);
    return html_text(out, &text);
}

/* A value, which is released, as JSON for a <script type='application/json'>: < > & occur in strings only, where JSON can escape
 * them. n_digits: of numbers. */
static json_t *html_json(json_t *value, size_t n_digits) {
    char *text = must_have(json_dumps(value, JSON_COMPACT | JSON_REAL_PRECISION(n_digits))), *escaped;
    size_t n;
    FILE *out = open_text(&escaped, &n);
    json_decref(value);
    for (const char *p = text; *p; ++p)
        fprintf(out, *p == '<' || *p == '>' || *p == '&' ? "\\u%04x" : "%c", (unsigned)*p);
    free(text);
    return html_text(out, &escaped);
}

/* ---- summary ----------------------------------------------------------------------------------------------------- */

static json_t *json_title(const report_page *page) {
    const size_t n = count_tests(page);
    const char *reference = page->run->names[0];
    if (page->run->title)
        return json_name(page->run->title);
    json_t *name = json_name(n == 1 ? page->run->names[1] : reference), *ref = json_name(reference);
    json_t *title = n == 1 ? json_sprintf("How closely %s matches %s", json_string_value(name), json_string_value(ref))
                           : json_sprintf("How closely %zu approximations match %s", n, json_string_value(ref));
    json_decref(name);
    json_decref(ref);
    return title;
}

static bool has_interval(const nqm_score_result *r) {
    return !r->identical && isfinite(r->jod_low) && isfinite(r->jod_high);
}

/* The fractions of people who prefer the test to each of the others. */
static json_t *json_preferred(const report_page *page, size_t place) {
    json_t *list = json_array();
    for (size_t k = 0; k < count_tests(page); ++k) {
        const double fraction = nqm_jod_preference(row_at(page, place)->result.jod, row_at(page, k)->result.jod);
        json_array_append_new(list, place == k ? json_null() : json_real(fraction));
    }
    return list;
}

/* Element i of the results of a document. */
static json_t *result_at(const json_t *document, size_t i) {
    return json_array_get(json_object_get(document, "results"), i);
}

/* What summary and section of a test both have: its row of scores, and more; `seen` is its row of labels. */
static json_t *json_test(const report_page *page, size_t place) {
    const scored_pair *row = row_at(page, place);
    const nqm_score_result *r = &row->result;
    json_t *test = json_deep_copy(result_at(page->run->json_scores, row->order));
    return json_set(test, "place:z rank:z name:s interval:o people:f seen:O preferred:o adapted:f", place + 1,
                    row->rank, page->run->names[row->order + 1],
                    has_interval(r) ? json_sprintf("%.2f to %.2f", r->jod_low, r->jod_high) : NULL,
                    nqm_verdict_preference(r), result_at(page->json_labels, row->order),
                    count_tests(page) <= MAX_COMPARED ? json_preferred(page, place) : NULL,
                    nqm_label_get_info(&r->parts).adapted_jod);
}

/* ---- how to read it ---------------------------------------------------------------------------------------------- */

static json_t *json_guide(void) {
    static const double ends[] = {10, 9.5, 9, 8, 6, 0}; /* ranges of nqm_verdict_words() */
    json_t *list = json_array();
    for (size_t i = 1; i < sizeof ends / sizeof *ends; ++i) {
        const double from = ends[i], to = ends[i - 1];
        json_t *range = from == 0 ? json_sprintf("below %.3g", to) : json_sprintf("%.3g to %.3g", from, to);
        json_array_append_new(list, json_row("range:o words:s least:f most:f", range, nqm_verdict_words(from),
                                             from > 0 ? nqm_jod_preference(10, to) : (double)NAN,
                                             nqm_jod_preference(10, from)));
    }
    return list;
}

/* ---- provenance -------------------------------------------------------------------------------------------------- */

static json_t *json_material(const report_page *page, size_t item) {
    const nqm_texture *texture = page->run->labels.items[item].texture;
    const char *term = item ? "Test" : "Reference";
    if (texture) {
        const nqm_texture_info t = nqm_texture_get_info(texture, NULL);
        return json_row("term:s name:s about:o", term, t.name,
                        json_sprintf("%s, %zu \xc3\x97 %zu texels, maps of %s", t.model, t.width, t.height, t.varying));
    }
    const nqm_brdf_info info = nqm_brdf_get_info(page->run->brdfs[item]);
    return json_row("term:s name:s about:o doi:s", term, info.name, json_sprintf("%s, %s", info.format, info.layout),
                    info.source_doi ? info.source_doi : "");
}

static json_t *json_materials(const report_page *page) {
    json_t *list = json_array();
    json_array_append_new(list, json_material(page, 0));
    for (size_t i = 0; i < count_tests(page); ++i)
        json_array_append_new(list, json_material(page, row_at(page, i)->order + 1));
    return list;
}

static json_t *scene_text(const report_page *page) {
    const nqm_scene_options *o = &page->run->labels.scene_options;
    json_t *scene = json_scene(o);
    char *text;
    size_t n;
    FILE *out = open_text(&text, &n);
    if (nqm_scene_is_standard(o))
        fputs("the standard set of four scenes", out);
    else
        fprintf(out, "%s under %s", json_string_value(json_object_get(scene, "shape")),
                json_string_value(json_object_get(scene, "light")));
    fprintf(out,
            ", %zu \xc3\x97 %zu pixels, %zu light directions per point, a white surface at %.6g cd/m\xc2\xb2, "
            "peak %.6g cd/m\xc2\xb2, seed %zu",
            o->width, o->height, nqm_scene_n_lights(o), o->exposure_cdm2, o->peak_cdm2, o->seed);
    if (o->turn_rad != 0 || o->elevation_rad != 0)
        fprintf(out, ", turned by %.6g\xc2\xb0, seen from %.6g\xc2\xb0",
                json_real_value(json_object_get(scene, "turn")), json_real_value(json_object_get(scene, "elevation")));
    if (o->n_frames > 1)
        fprintf(out, ", %zu views", o->n_frames);
    fprintf(out, "%s%s", o->shadows ? "" : ", no shadows", o->interreflection ? ", one interreflection" : "");
    json_decref(scene);
    return html_text(out, &text);
}

/* ---- charts ------------------------------------------------------------------------------------------------------ */

static json_t *json_numbers(size_t n, const double *values) {
    json_t *list = json_array();
    for (size_t i = 0; i < n; ++i)
        json_array_append_new(list, json_number(values[i]));
    return list;
}

static json_t *json_slices(const nqm_brdf *brdf) {
    double rgb[CHART_SLICES * CHART_POINTS * 3];
    chart_slices(brdf, 0, rgb);
    return json_numbers(CHART_SLICES * CHART_POINTS * 3, rgb);
}

/* What drawReport() of web/charts.js reads, in the order of the page. */
static json_t *json_charts(const report_page *page) {
    json_t *tests = json_array();
    for (size_t i = 0; i < count_tests(page); ++i) {
        const scored_pair *row = row_at(page, i);
        const nqm_brdf *ref = page->run->brdfs[0], *test = page->run->brdfs[row->order + 1];
        const bool has_range = has_interval(&row->result);
        json_t *one = json_row("score:{jod:f low:o high:o rendered:f}", row->result.jod,
                               has_range ? json_real(row->result.jod_low) : json_null(),
                               has_range ? json_real(row->result.jod_high) : json_null(),
                               page->run->labels.items[row->order + 1].jod);
        if (!row->texture) {
            double map[CHART_ROWS * CHART_COLUMNS];
            chart_map(ref, test, map);
            json_set(one, "slices:[oo] map:o", json_slices(ref), json_slices(test),
                     json_numbers(CHART_ROWS * CHART_COLUMNS, map));
        }
        json_array_append_new(tests, one);
    }
    return tests;
}

/* The policy allows this script alone and forbids the page to load anything. */
static json_t *json_hash(json_t *script) {
    unsigned char hash[EVP_MAX_MD_SIZE], text[2 * EVP_MAX_MD_SIZE];
    unsigned n = 0;
    if (!EVP_Digest(json_string_value(script), json_string_length(script), hash, &n, EVP_sha256(), NULL))
        stop(EXIT_LIMIT, "cannot compute a checksum: out of memory");
    EVP_EncodeBlock(text, hash, (int)n);
    return json_sprintf("sha256-%s", (const char *)text);
}

/* ---- a test ------------------------------------------------------------------------------------------------------ */

static json_t *json_metrics(const nqm_score_result *r) {
    json_t *rows = json_array();
    for (int m = 0; m < NQM_METRIC_COUNT; ++m) {
        const nqm_metric_info info = nqm_metric_get_info((nqm_metric)m);
        json_array_append_new(rows, json_row("metric:s value:o description:s", info.name,
                                             number_text(r->metrics[m], 4, '#'), info.description));
    }
    return rows;
}

static json_t *json_counts(const nqm_score_result *r) {
    json_t *rows = json_array();
    for (size_t k = 0; k < 2; ++k)
        json_array_append_new(rows, json_row("label:s numbers:[zzz]", k ? "Test" : "Reference", r->n_clamped[k],
                                             r->n_invalid[k], r->n_unusual[k]));
    return rows;
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

enum { SCALE_STEPS = 256 };

/* Markup of the picture in the temporary file, which is removed, at a size in CSS pixels. */
static json_t *take_figure(const report_page *page, const char *alt, size_t width, size_t height) {
    json_t *image = html_image(page->figure, alt, width, height);
    nqm_os_remove(page->figure);
    return image;
}

/* Colours are tone-mapped or on the scale of all maps. */
static json_t *draw(const report_page *page, nqm_picture picture, size_t shrink, const char *alt) {
    const nqm_tone tone = tone_of(&page->run->labels.scene_options);
    picture.delta_e_max = page->run->labels.delta_e_max;
    must(nqm_picture_write(page->figure, &picture, shrink, &tone, &fault));
    return take_figure(page, alt, picture.width / shrink, picture.height / shrink);
}

static json_t *draw_item(const report_page *page, size_t item, const char *alt) {
    const canvas *c = &page->all;
    double *picture = item_picture(&page->run->labels, item, c, BACKDROP_WHITE);
    const nqm_picture drawn = {.width = c->width, .height = c->height, .rgb_cdm2 = picture};
    json_t *image = draw(page, drawn, page->run->labels.shrink, alt);
    free(picture);
    return image;
}

static json_t *draw_difference(const report_page *page, size_t item) {
    const canvas *c = &page->all;
    double *map = item_map(&page->run->labels, item, c);
    char alt[100];
    snprintf(alt, sizeof alt, "Map of the colour difference of the two pictures, mean %.2f",
             page->run->labels.items[item].label.delta_e);
    const nqm_picture drawn = {.width = c->width, .height = c->height, .delta_e = map};
    json_t *image = draw(page, drawn, page->run->labels.shrink, alt);
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

/* ---- textures ---------------------------------------------------------------------------------------------------- */

enum { SIDE = 160, NORMAL = NQM_SCHEMA_MAX_KEYS };

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
            out[c] = nqm_unit_byte((normal[c] + 1) / 2);
        else if (t->keys[m->property].n == 3)
            out[c] = nqm_srgb_byte(nqm_texture_value(t, m->property, c, rows, i));
        else
            out[c] = nqm_unit_byte(nqm_texture_value(t, m->property, 0, rows, i));
}

static void add_map(const report_page *page, const nqm_texture *texture, size_t property, json_t *list) {
    const char *key = property == NORMAL ? "normal" : texture->keys[property].name;
    const size_t tiles[2] = {1, 1};
    shown_map m = {texture, property};
    nqm_raster r = {.width = SIDE, .height = SIDE, .channels = 3};
    nqm_ticker ticker = {.fn = show_progress};
    must(nqm_texture_write(texture, tiles, write_texel, &m, &ticker, &r, &fault));
    must(nqm_raster_write_png(page->figure, &r, true, NULL, &fault));
    nqm_raster_clear(&r);
    json_array_append_new(list, json_row("key:s picture:o", key, take_figure(page, key, SIDE, SIDE)));
}

static void add_maps(const report_page *page, const char *who, const nqm_texture *texture, json_t *to) {
    json_t *list = json_array();
    for (size_t k = 0; texture && k < texture->n_properties; ++k)
        if (texture->properties[k].node != NQM_NO_NODE)
            add_map(page, texture, k, list);
    if (texture && texture->normal != NQM_NO_NODE)
        add_map(page, texture, NORMAL, list);
    if (texture)
        json_array_append_new(to, json_row("who:s list:O", who, list));
    json_decref(list);
}

static void add_texture(const report_page *page, const scored_pair *row, json_t *to) {
    const label_item *items = page->run->labels.items;
    const double end = write_heat(page->figure, row->texture, row->heat);
    json_t *maps = json_array(), *heat = take_figure(page, "Map of Delta-E ITP of the texels", 440, 440);
    add_maps(page, "reference", items[0].texture, maps);
    add_maps(page, "test", items[row->order + 1].texture, maps);
    json_set(to, "heat:o brightest:f maps:o", heat, end, maps);
}

/* ---- the section ------------------------------------------------------------------------------------------------- */

static json_t *json_section(const void *user, size_t place) {
    const report_page *page = user;
    const scored_pair *row = row_at(page, place);
    const size_t i = row->order + 1;
    step_progress("draw", place, count_tests(page));
    json_t *test = json_test(page, place), *remarks = json_object_get(test, "warnings");
    if (row->texture)
        add_texture(page, row, json_object_get(test, "texture"));
    return json_set(
        test, "argument:o metrics:o counts:o remarks:o picture_ref:o picture_test:o picture_map:o picture_scale:o",
        strcmp(page->run->names[i], row->pair.test) != 0 ? json_name(row->pair.test) : NULL, json_metrics(&row->result),
        json_counts(&row->result), json_array_size(remarks) ? json_row("list:O", remarks) : NULL,
        draw_item(page, 0, "Rendered picture of the reference"), draw_item(page, i, "Rendered picture of the test"),
        draw_difference(page, i), draw_scale(page));
}

/* ---- the page ---------------------------------------------------------------------------------------------------- */

static json_t *json_page(const report_page *page) {
    static const char *const remedy[] = {"skipped", "set to 0", "filled from the nearest direction", "an error"};
    const report_run *run = page->run;
    const nqm_model_info info = nqm_model_get_info(run->scores.model);
    const size_t n = count_tests(page);
    const double end = run->labels.delta_e_max;
    json_t *rows = json_array();
    json_t *script = json_sprintf("//<![CDATA[\n%sdrawReport();\n//]]>", report_charts_js); /* HTML and XML alike */
    for (size_t i = 0; i < n; ++i)
        json_array_append_new(rows, json_test(page, i));
    json_t *hash = json_hash(script);
    return json_row("hash:o script:o version:s title:o rows:o tests:z preferences:b calibrated:b guide:o materials:o "
                    "reference:s middle:o top:o model:s sha256:s recipe:s directions_id:s parameters:z directions:z "
                    "invalid:s scene:o date:o prefix:o style:o score_data:o label_data:o chart_data:o",
                    hash, script, nqm_version(), json_title(page), rows, n, n > 1 && n <= MAX_COMPARED,
                    *info.calibration != 0, json_guide(), json_materials(page), run->names[0],
                    number_text(end / 2, 3, 'g'), number_text(end, 3, 'g'), info.id, info.sha256, info.recipe,
                    nqm_directions_id(info.directions), info.n_parameters, nqm_directions_get_info(info.directions).n,
                    remedy[run->scores.options.invalid], scene_text(page), run->date ? json_name(run->date) : NULL,
                    json_stringn(info.sha256, 12), json_sprintf("%s%s", report_charts_css, report_css),
                    html_json(json_incref(run->json_scores), 9), html_json(json_incref(page->json_labels), 9),
                    html_json(json_charts(page), 4));
}

void write_report(const report_run *run, FILE *out, char *figure) {
    report_page page = {.run = run,
                        .figure = figure,
                        .json_labels = json_labels(&run->labels),
                        .all = all_frames(&run->labels.scene_options)};
    fill_template(out, report_html, escape_xml, json_page(&page), json_section, &page);
    json_decref(page.json_labels);
}
