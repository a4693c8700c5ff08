/* SPDX-License-Identifier: MIT
 *
 * The page of a report: head, summary, a section for each test (report_test.c), guide, provenance, data.
 */
#include "nqm/show/report.h"

#include <math.h>

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

/* The policy forbids the page to load anything. */
static void put_head(const report_page *page) {
    html(page->out,
         "<!DOCTYPE html>\n<html lang='en'>\n<head>\n<meta charset='utf-8'/>\n"
         "<meta http-equiv='Content-Security-Policy' content=\"default-src 'none'; img-src data:; "
         "style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'\"/>\n"
         "<meta name='viewport' content='width=device-width, initial-scale=1'/>\n"
         "<meta name='generator' content='nqm %s'/>\n<title>",
         nqm_version());
    put_title(page);
    html(page->out, "</title>\n<style>\n");
    fputs(report_style, page->out);
    html(page->out, "</style>\n</head>\n<body>\n<main>\n<header>\n<h1>");
    put_title(page);
    html(page->out,
         "</h1>\n<p class='lead'>Image quality in JOD (just-objectionable differences), predicted from the BRDFs "
         "without "
         "rendering. Rendered pictures and their colour differences let you check the predictions.</p>\n</header>\n");
}

/* ---- summary ----------------------------------------------------------------------------------------------------- */

/* Identical BRDFs have none. */
static bool has_interval(const nqm_score_result *r) {
    return !r->identical && isfinite(r->jod_low) && isfinite(r->jod_high);
}

void put_interval(FILE *out, const nqm_score_result *r) {
    if (has_interval(r))
        html(out, " <span class='interval'>(95&#160;%% interval %.2f to %.2f)</span>", r->jod_low, r->jod_high);
}

void put_strip(FILE *out, const nqm_score_result *r, double rendered_jod) {
    html(out,
         "<svg class='strip' viewBox='-4 0 108 14' width='135' height='17' role='img' aria-label='predicted %.2f, "
         "rendered %.2f of 10'><path d='M0 3V11M50 3V11M100 3V11M0 7H100'/>",
         r->jod, rendered_jod);
    if (has_interval(r))
        html(out, "<path class='interval' d='M%.2f 7H%.2f'/>", 10 * r->jod_low, 10 * r->jod_high);
    html(out, "<circle class='ring' cx='%.2f' cy='7' r='3.4'/><circle cx='%.2f' cy='7' r='2'/></svg>",
         10 * rendered_jod, 10 * r->jod);
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
    html(out, "</td><td class='graph'>");
    put_strip(out, &row->result, item->jod);
    html(out, "</td><td>%s</td><td class='n'>%s</td><td class='n'>%.2f</td><td class='n'>%.2f</td></tr>\n",
         verdict_words(&row->result, verdict), html_people(preference_share(&row->result)).text, item->jod,
         item->label.delta_e);
}

static void put_summary(const report_page *page) {
    FILE *out = page->out;
    html(out, "<section>\n<h2>Summary</h2>\n<div class='scroll' role='region' aria-label='Summary' "
              "tabindex='0'>\n<table class='summary'>\n<thead><tr>"
              "<th scope='col' class='n'>Rank</th><th scope='col'>Test</th><th scope='col' class='n'>JOD</th>"
              "<th scope='col' class='graph'>0 to 10</th><th scope='col'>In words</th>"
              "<th scope='col' class='n'>Prefer the reference</th><th scope='col' class='n'>JOD of pictures</th>"
              "<th scope='col' class='n'>\xce\x94"
              "E&#160;ITP</th></tr></thead>\n<tbody>\n");
    for (size_t i = 0; i < count_tests(page); ++i)
        put_summary_row(page, i);
    html(out,
         "</tbody>\n</table>\n</div>\n<p class='note'>JOD: predicted by the model <code>%s</code><span class='graph'>; "
         "dot in the graph</span>. "
         "JOD of pictures: from the mean \xce\x94"
         "E&#160;ITP of the renderings below<span class='graph'>; ring in the graph</span>.</p>\n"
         "</section>\n",
         nqm_model_get_info(page->run->scores.model).id);
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
    FILE *out = page->out;
    html(
        out,
        "<section class='guide'>\n<h2>How to read the numbers</h2>\n<div class='two'>\n<div>\n"
        "<p>JOD 10 means no visible difference. One JOD less means that 75&#160;%% of people who see both say that the "
        "reference looks better; without a visible difference, 50&#160;%% say so, because they guess. For a difference "
        "of d JOD, the percentage is \xce\xa6(0.6745&#160;d), with \xce\xa6 the normal distribution function.</p>\n"
        "<p>The network predicts the JOD from the BRDFs, for pictures in the scene of its training labels. The JOD of "
        "pictures is computed from the pictures on this page, by the published curve from \xce\x94"
        "E&#160;ITP (ITU-R BT.2124). If the two differ much, trust the pictures.</p>\n");
    if (*nqm_model_get_info(page->run->scores.model).calibration)
        html(out,
             "<p>The 95&#160;%% interval contains the JOD of rendered pictures for 95&#160;%% of pairs with materials "
             "that the model was not trained on.</p>\n");
    html(out, "</div>\n<table><thead><tr><th scope='col'>JOD</th><th scope='col'>In words</th>"
              "<th scope='col' class='n'>Prefer the reference</th></tr></thead>\n<tbody>\n");
    for (size_t i = 1; i < sizeof ends / sizeof *ends; ++i)
        put_range(out, ends[i], ends[i - 1]);
    html(out, "</tbody></table>\n</div>\n</section>\n");
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
         "<section class='provenance'>\n<h2>Provenance</h2>\n<p class='quote'>JOD predicted with nqm %s, model %s "
         "(SHA-256 %s), at %zu directions (%s); pictures: ",
         nqm_version(), info.id, prefix, scores->terms.n_directions, nqm_directions_id(info.directions));
    put_scene(page);
    html(out, "%s%s.</p>\n<dl>\n", page->run->date ? "; " : "", page->run->date ? page->run->date : "");
    put_material(page, "Reference", 0);
    for (size_t i = 0; i < count_tests(page); ++i)
        put_material(page, "Test", row_at(page, i)->order + 1);
    html(out,
         "<dt>Model</dt><dd>%s, recipe %s, %zu parameters, SHA-256 <span class='hash'>%s</span></dd>\n"
         "<dt>Directions without a value</dt><dd>%s</dd>\n</dl>\n"
         "<p class='note'>Method: Kavoosighafi, Mantiuk, Hajisharif, Miandji, Unger, A Neural Quality Metric for BRDF "
         "Models, 2025.</p>\n</section>\n",
         info.id, info.recipe, info.n_parameters, info.sha256, remedy[scores->options.invalid]);
}

/* ---- the page ---------------------------------------------------------------------------------------------------- */

void write_report(const report_run *run, FILE *out, char *figure) {
    report_page page = {.run = run, .out = out, .figure = figure};
    begin_figures(&page);
    put_head(&page);
    put_summary(&page);
    put_preferences(&page);
    for (size_t i = 0; i < count_tests(&page); ++i) {
        if (show_progress(NULL, "draw", (double)i, (double)count_tests(&page)))
            stop(EXIT_INTERRUPTED, "interrupted");
        put_test(&page, i);
    }
    put_guide(&page);
    put_provenance(&page);
    html(out, "</main>\n");
    html_json(out, "nqm-report", json_incref(run->json_scores));
    html_json(out, "nqm-label", json_labels(&run->labels));
    html(out, "</body>\n</html>\n");
    end_figures(&page);
}
