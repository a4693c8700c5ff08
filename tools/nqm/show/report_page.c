/* SPDX-License-Identifier: MIT
 *
 * The page of a report: what report.html leaves open, that is summary, a section for each test (report_test.c), guide,
 * provenance, and the data of its charts.
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

static const char *name_at(const report_page *page, size_t place) {
    return page->run->names[row_at(page, place)->order + 1];
}

/* ---- head -------------------------------------------------------------------------------------------------------- */

static void put_title(const report_page *page) {
    const score_run *scores = &page->run->scores;
    if (page->run->title)
        html(page->out, "%s", page->run->title);
    else if (scores->n_rows == 1)
        html(page->out, "How closely %s matches %s", page->run->names[1], page->run->names[0]);
    else
        html(page->out, "How closely %zu approximations match %s", scores->n_rows, page->run->names[0]);
}

/* ---- summary ----------------------------------------------------------------------------------------------------- */

bool has_interval(const nqm_score_result *r) {
    return !r->identical && isfinite(r->jod_low) && isfinite(r->jod_high);
}

static void put_summary_row(const report_page *page, size_t place) {
    const scored_pair *row = row_at(page, place);
    const label_item *item = &page->run->labels.items[row->order + 1];
    char verdict[VERDICT_TEXT];
    FILE *out = page->out;
    html(out,
         "<tr><td class='n'>%zu</td><th scope='row'><a href='#test-%zu'>%s</a></th><td class='n'><strong>%.2f</strong>",
         row->rank, place + 1, name_at(page, place), row->result.jod);
    if (has_interval(&row->result))
        html(out, "<br/><span class='interval'>%.2f to %.2f</span>", row->result.jod_low, row->result.jod_high);
    html(out, "</td><td>%s</td><td class='n'>%s</td><td class='n'>%.2f</td><td class='n'>%.2f</td></tr>\n",
         verdict_words(&row->result, verdict), html_people(preference_share(&row->result)).text, item->jod,
         item->label.delta_e);
}

static void put_summary(const report_page *page) {
    for (size_t i = 0; i < count_tests(page); ++i)
        put_summary_row(page, i);
}

/* The fraction of people who prefer one test to another. */
static void put_preferences(const report_page *page) {
    size_t n = count_tests(page);
    FILE *out = page->out;
    if (n < 2 || n > MAX_COMPARED)
        return;
    html(
        out,
        "<section>\n<h2>Preferences between the tests</h2>\n<div class='scroll' role='region' aria-label='Preferences' "
        "tabindex='0'>\n"
        "<table class='matrix'><caption>Expected percentage of people who prefer the test of the row to the test of "
        "the column (same numbers) when they also see the reference</caption>\n<thead><tr><th scope='col'>Test</th>");
    for (size_t k = 0; k < n; ++k)
        html(out, "<th scope='col' class='n'>(%zu)</th>", k + 1);
    html(out, "</tr></thead>\n<tbody>\n");
    for (size_t i = 0; i < n; ++i) {
        html(out, "<tr><th scope='row'>(%zu) %s</th>", i + 1, name_at(page, i));
        for (size_t k = 0; k < n; ++k) {
            double fraction = nqm_jod_preference(row_at(page, i)->result.jod, row_at(page, k)->result.jod);
            html(out, "<td class='n'>%s</td>", i == k ? "" : html_people(fraction).text);
        }
        html(out, "</tr>\n");
    }
    html(out, "</tbody></table>\n</div>\n</section>\n");
}

/* ---- how to read it ---------------------------------------------------------------------------------------------- */

static void put_range(FILE *out, double from, double to) {
    if (from == 0)
        html(out, "<tr><td>below %.3g</td>", to);
    else
        html(out, "<tr><td>%.3g to %.3g</td>", from, to);
    html(out, "<td>%s</td><td class='n'>", jod_words(from));
    if (from > 0)
        html(out, "%s to ", html_people(nqm_jod_preference(10, to)).text);
    html(out, "%s</td></tr>\n", html_people(nqm_jod_preference(10, from)).text);
}

static void put_guide(const report_page *page) {
    static const double ends[] = {10, 9.5, 9, 8, 6, 0}; /* ranges of jod_words() */
    for (size_t i = 1; i < sizeof ends / sizeof *ends; ++i)
        put_range(page->out, ends[i], ends[i - 1]);
}

static void put_calibration(const report_page *page) {
    if (*nqm_model_get_info(page->run->scores.model).calibration)
        html(page->out,
             "<p>The 95&#160;%% interval contains the JOD of rendered pictures for 95&#160;%% of pairs with materials "
             "that the model was not trained on.</p>\n");
}

/* ---- provenance -------------------------------------------------------------------------------------------------- */

static void put_material(const report_page *page, const char *term, size_t item) {
    FILE *out = page->out;
    if (page->run->labels.items[item].texture) {
        const nqm_texture_info texture = nqm_texture_get_info(page->run->labels.items[item].texture, NULL);
        html(out,
             "<dt>%s</dt><dd><span class='name'>%s</span> \xe2\x80\x93 %s, %zu \xc3\x97 %zu texels, maps of %s</dd>\n",
             term, texture.name, texture.model, texture.width, texture.height, texture.varying);
        return;
    }
    const nqm_brdf_info info = nqm_brdf_get_info(page->run->brdfs[item]);
    html(out, "<dt>%s</dt><dd><span class='name'>%s</span> \xe2\x80\x93 %s, %s", term, info.name, info.format,
         info.layout);
    if (info.source_doi)
        html(out, ", DOI&#160;%s", info.source_doi);
    html(out, "</dd>\n");
}

static void put_scene(const report_page *page) {
    const nqm_scene_options *o = &page->run->labels.scene_options;
    json_t *scene = json_scene(o);
    if (nqm_scene_is_standard(o))
        html(page->out, "the standard set of four scenes");
    else
        html(page->out, "%s under %s", json_string_value(json_object_get(scene, "shape")),
             json_string_value(json_object_get(scene, "light")));
    html(page->out,
         ", %zu \xc3\x97 %zu pixels, %zu light directions per point, a white surface at %.6g cd/m\xc2\xb2, "
         "peak %.6g cd/m\xc2\xb2, seed %zu",
         o->width, o->height, nqm_scene_n_lights(o), o->exposure_cdm2, o->peak_cdm2, o->seed);
    if (o->turn_rad != 0 || o->elevation_rad != 0)
        html(page->out, ", turned by %.6g\xc2\xb0, seen from %.6g\xc2\xb0",
             json_real_value(json_object_get(scene, "turn")), json_real_value(json_object_get(scene, "elevation")));
    if (o->n_frames > 1)
        html(page->out, ", %zu views", o->n_frames);
    html(page->out, "%s%s", o->shadows ? "" : ", no shadows", o->interreflection ? ", one interreflection" : "");
    json_decref(scene);
}

static void put_provenance(const report_page *page) {
    static const char *const remedy[] = {"skipped", "set to 0", "filled from the nearest direction", "an error"};
    const score_run *scores = &page->run->scores;
    nqm_model_info info = nqm_model_get_info(scores->model);
    FILE *out = page->out;
    char prefix[13];
    snprintf(prefix, sizeof prefix, "%s", info.sha256);
    html(out,
         "<p class='quote'>JOD predicted with nqm %s, model %s "
         "(SHA-256 %s), at %zu directions (%s); pictures: ",
         nqm_version(), info.id, prefix, scores->terms.n_directions, nqm_directions_id(info.directions));
    put_scene(page);
    html(out, "%s%s.</p>\n<dl>\n", page->run->date ? "; " : "", page->run->date ? page->run->date : "");
    put_material(page, "Reference", 0);
    for (size_t i = 0; i < count_tests(page); ++i)
        put_material(page, "Test", row_at(page, i)->order + 1);
    html(out,
         "<dt>Model</dt><dd>%s, recipe %s, %zu parameters, SHA-256 <span class='hash'>%s</span></dd>\n"
         "<dt>Directions without a value</dt><dd>%s</dd>\n</dl>\n",
         info.id, info.recipe, info.n_parameters, info.sha256, remedy[scores->options.invalid]);
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

static void put_data(const report_page *page) {
    html_json(page->out, "nqm-report", json_incref(page->run->json_scores), 9);
    html_json(page->out, "nqm-label", json_labels(&page->run->labels), 9);
    html_json(page->out, "nqm-charts", json_charts(page), 4);
}

/* The script is HTML and XML alike; free() it. */
static char *make_script(void) {
    static const char form[] = "//<![CDATA[\n%sdrawReport();\n//]]>";
    const size_t n = sizeof form + strlen(report_charts_js);
    char *script = allocate(n, 1);
    snprintf(script, n, form, report_charts_js);
    return script;
}

static void put_script(const report_page *page) {
    char *script = make_script();
    fputs(script, page->out);
    free(script);
}

/* The policy allows this script alone and forbids the page to load anything. */
static void put_hash(const report_page *page) {
    unsigned char hash[EVP_MAX_MD_SIZE], text[2 * EVP_MAX_MD_SIZE];
    char *script = make_script();
    unsigned n = 0;
    if (!EVP_Digest(script, strlen(script), hash, &n, EVP_sha256(), NULL))
        stop(EXIT_LIMIT, "cannot compute a checksum: out of memory");
    EVP_EncodeBlock(text, hash, (int)n);
    html(page->out, "sha256-%s", (const char *)text);
    free(script);
}

/* ---- the page ---------------------------------------------------------------------------------------------------- */

static void put_version(const report_page *page) {
    html(page->out, "%s", nqm_version());
}

static void put_model(const report_page *page) {
    html(page->out, "%s", nqm_model_get_info(page->run->scores.model).id);
}

static void put_style(const report_page *page) {
    fputs(report_charts_css, page->out);
    fputs(report_css, page->out);
}

/* ---- the template ------------------------------------------------------------------------------------------------ */

static const report_part parts[] = {{"{{hash}}", put_hash},
                                    {"{{version}}", put_version},
                                    {"{{title}}", put_title},
                                    {"{{style}}", put_style},
                                    {"{{summary}}", put_summary},
                                    {"{{model}}", put_model},
                                    {"{{preferences}}", put_preferences},
                                    {"{{interval}}", put_calibration},
                                    {"{{guide}}", put_guide},
                                    {"{{provenance}}", put_provenance},
                                    {"{{data}}", put_data},
                                    {"{{script}}", put_script},
                                    {NULL, NULL}};

static bool begins(const char *p, const char *mark) {
    return strncmp(p, mark, strlen(mark)) == 0;
}

static const report_part *find_part(const report_part *list, const char *p) {
    while (list->mark && !begins(p, list->mark))
        ++list;
    return list->mark ? list : NULL;
}

/* Write the template from p to its end, or to {{end}}; returns what follows. Between {{tests}} and {{end}} is the section of each
 * test; between {{plain}} and {{end}} what only tests without textures have. */
static const char *fill(report_page *page, const char *p) {
    static const char tests[] = "{{tests}}", plain[] = "{{plain}}", end[] = "{{end}}";
    while (*p && !begins(p, end)) {
        const report_part *part = find_part(parts, p);
        part = part ? part : find_part(report_test_parts, p);
        if (part) {
            part->put(page);
            p += strlen(part->mark);
        } else if (begins(p, tests)) {
            const char *section = p + strlen(tests);
            for (page->place = 0; page->place < count_tests(page); ++page->place) {
                step_progress("draw", page->place, count_tests(page));
                page->row = row_at(page, page->place);
                page->item = &page->run->labels.items[page->row->order + 1];
                p = fill(page, section);
            }
        } else if (begins(p, plain)) {
            p = page->row->texture ? strstr(p, end) + strlen(end) : fill(page, p + strlen(plain));
        } else {
            fputc(*p++, page->out);
        }
    }
    return *p ? p + strlen(end) : p;
}

void write_report(const report_run *run, FILE *out, char *figure) {
    report_page page = {.run = run, .out = out, .figure = figure, .all = all_frames(&run->labels.scene_options)};
    page.white = make_backdrop(run->labels.scene, &page.all, BACKDROP_WHITE);
    fill(&page, report_html);
    free(page.white);
}
