/* SPDX-License-Identifier: MIT
 *
 * The data of a report's page, which fill report.html: title, summary, guide, provenance, and the values of its charts. That of
 * the section of a test is in report_test.c.
 */
#include "nqm/show/charts.h"
#include "nqm/show/report.h"

#include <math.h>
#include <openssl/evp.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_COMPARED = 12 }; /* tests in the table of preferences, which must fit on a sheet of paper */

static size_t count_tests(const report_page *page) {
    return page->run->scores.n_rows;
}

static const scored_pair *row_at(const report_page *page, size_t place) {
    return &page->run->scores.rows[place];
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
        json_array_append_new(list, json_string(place == k ? "" : html_people(fraction).text));
    }
    return list;
}

/* What summary and section of a test both have. */
static json_t *json_row(const report_page *page, size_t place) {
    const scored_pair *row = row_at(page, place);
    const nqm_score_result *r = &row->result;
    const label_item *item = &page->run->labels.items[row->order + 1];
    char verdict[VERDICT_TEXT];
    return json_pack("{s:I,s:I,s:o,s:o,s:o,s:s,s:s,s:o,s:o,s:o}", "place", (json_int_t)place + 1, "rank",
                     (json_int_t)row->rank, "name", json_name(page->run->names[row->order + 1]), "jod",
                     html_number(r->jod, 2, 'f'), "interval",
                     has_interval(r) ? json_sprintf("%.2f to %.2f", r->jod_low, r->jod_high) : json_null(), "verdict",
                     verdict_words(r, verdict), "people", html_people(preference_share(r)).text, "rendered",
                     html_number(item->jod, 2, 'f'), "delta_e", html_number(item->label.delta_e, 2, 'f'), "preferred",
                     count_tests(page) <= MAX_COMPARED ? json_preferred(page, place) : json_null());
}

/* ---- how to read it ---------------------------------------------------------------------------------------------- */

static json_t *json_guide(void) {
    static const double ends[] = {10, 9.5, 9, 8, 6, 0}; /* ranges of jod_words() */
    json_t *list = json_array();
    for (size_t i = 1; i < sizeof ends / sizeof *ends; ++i) {
        const double from = ends[i], to = ends[i - 1];
        const html_percent least = html_people(nqm_jod_preference(10, to)),
                           most = html_people(nqm_jod_preference(10, from));
        json_array_append_new(
            list,
            json_pack("{s:o,s:s,s:o,s:s}", "range",
                      from == 0 ? json_sprintf("below %.3g", to) : json_sprintf("%.3g to %.3g", from, to), "words",
                      jod_words(from), "least", from > 0 ? json_string(least.text) : json_null(), "most", most.text));
    }
    return list;
}

/* ---- provenance -------------------------------------------------------------------------------------------------- */

static json_t *json_material(const report_page *page, size_t item) {
    const nqm_texture *texture = page->run->labels.items[item].texture;
    const char *term = item ? "Test" : "Reference";
    if (texture) {
        const nqm_texture_info t = nqm_texture_get_info(texture, NULL);
        return json_pack(
            "{s:s,s:o,s:o}", "term", term, "name", json_name(t.name), "about",
            json_sprintf("%s, %zu \xc3\x97 %zu texels, maps of %s", t.model, t.width, t.height, t.varying));
    }
    const nqm_brdf_info info = nqm_brdf_get_info(page->run->brdfs[item]);
    return json_pack("{s:s,s:o,s:o,s:s}", "term", term, "name", json_name(info.name), "about",
                     json_sprintf("%s, %s", info.format, info.layout), "doi", info.source_doi ? info.source_doi : "");
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
        json_t *one = json_pack("{s:{s:f,s:o,s:o,s:f}}", "score", "jod", row->result.jod, "low",
                                has_range ? json_real(row->result.jod_low) : json_null(), "high",
                                has_range ? json_real(row->result.jod_high) : json_null(), "rendered",
                                page->run->labels.items[row->order + 1].jod);
        if (!row->texture) {
            double map[CHART_ROWS * CHART_COLUMNS];
            chart_map(ref, test, map);
            json_object_set_new(one, "slices", json_pack("[o,o]", json_slices(ref), json_slices(test)));
            json_object_set_new(one, "map", json_numbers(CHART_ROWS * CHART_COLUMNS, map));
        }
        json_array_append_new(tests, one);
    }
    return tests;
}

/* The script is HTML and XML alike. */
static json_t *make_script(void) {
    return json_sprintf("//<![CDATA[\n%sdrawReport();\n//]]>", report_charts_js);
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

/* ---- the page ---------------------------------------------------------------------------------------------------- */

static json_t *json_page(const report_page *page) {
    static const char *const remedy[] = {"skipped", "set to 0", "filled from the nearest direction", "an error"};
    const report_run *run = page->run;
    const nqm_model_info info = nqm_model_get_info(run->scores.model);
    const size_t n = count_tests(page);
    const double end = run->labels.delta_e_max;
    json_t *rows = json_array(), *script = make_script();
    for (size_t i = 0; i < n; ++i)
        json_array_append_new(rows, json_row(page, i));
    json_t *json =
        json_pack("{s:o,s:o,s:s,s:o,s:o,s:I,s:b,s:b,s:o,s:o,s:o,s:o,s:o}", "hash", json_hash(script), "script", script,
                  "version", nqm_version(), "title", json_title(page), "rows", rows, "tests", (json_int_t)n,
                  "preferences", n > 1 && n <= MAX_COMPARED, "calibrated", *info.calibration != 0, "guide",
                  json_guide(), "materials", json_materials(page), "reference", json_name(run->names[0]), "middle",
                  html_number(end / 2, 3, 'g'), "top", html_number(end, 3, 'g'));
    json_object_update_new(
        json, json_pack("{s:o,s:s,s:o,s:s,s:I,s:I,s:s,s:o,s:o}", "model", json_name(info.id), "sha256", info.sha256,
                        "recipe", json_name(info.recipe), "directions_id", nqm_directions_id(info.directions),
                        "parameters", (json_int_t)info.n_parameters, "directions",
                        (json_int_t)run->scores.terms.n_directions, "invalid", remedy[run->scores.options.invalid],
                        "scene", scene_text(page), "date", run->date ? json_name(run->date) : json_null()));
    json_object_set_new(json, "prefix", json_stringn(info.sha256, 12));
    json_object_set_new(json, "style", json_sprintf("%s%s", report_charts_css, report_css));
    json_object_set_new(json, "score_data", html_json(json_incref(run->json_scores), 9));
    json_object_set_new(json, "label_data", html_json(json_labels(&run->labels), 9));
    json_object_set_new(json, "chart_data", html_json(json_charts(page), 4));
    return json;
}

/* The section of a test. */
static json_t *json_section(const void *user, size_t place) {
    const report_page *page = user;
    step_progress("draw", place, count_tests(page));
    json_t *json = json_row(page, place);
    json_object_update_new(json, json_test(page, row_at(page, place)));
    return json;
}

void write_report(const report_run *run, FILE *out, char *figure) {
    report_page page = {.run = run, .figure = figure, .all = all_frames(&run->labels.scene_options)};
    page.white = make_backdrop(run->labels.scene, &page.all, BACKDROP_WHITE);
    html_fill(out, report_html, json_page(&page), json_section, &page);
    free(page.white);
}
