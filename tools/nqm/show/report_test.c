/* SPDX-License-Identifier: MIT
 *
 * The section of a report about one test: its score in words, pictures, metrics, differences over angle, warnings.
 */
#include "nqm/show/report.h"

#include <math.h>
#include <string.h>

static const label_item *item_of(const report_page *page, size_t test) {
    return &page->run->labels.items[test + 1];
}

static void put_verdict(const report_page *page, const scored_pair *row, const label_item *item) {
    const nqm_score_result *r = &row->result;
    char verdict[VERDICT_TEXT];
    html(page->out, "<p class='verdict'><strong>JOD %.2f</strong>", r->jod);
    put_interval(page->out, r);
    html(page->out, ": %s. ", verdict_words(r, verdict));
    if (r->identical)
        html(page->out, "Both BRDFs are equal at all directions that were compared.");
    else
        html(page->out,
             "When people see it next to the reference, an expected %s of them say that the reference looks better; "
             "50&#160;%% would be guessing.",
             html_people(preference_share(r)).text);
    html(page->out,
         " The mean colour difference of the pictures below is \xce\x94"
         "E&#160;ITP %.2f, which corresponds to JOD %.2f.</p>\n",
         item->label.delta_e, item->jod);
}

/* What differs in words, as predicted and in the pictures. */
static void put_words(FILE *out, const nqm_score_result *r, const nqm_label *rendered) {
    char words[NQM_LABEL_TEXT];
    html(out, "<p class='words'>");
    if (!isnan(r->parts.structure))
        html(out, "Predicted: <strong>%s</strong>. ", nqm_label_describe(&r->parts, words));
    html(out, "In the pictures: <strong>%s</strong>.</p>\n", nqm_label_describe(rendered, words));
}

static void put_parts_row(FILE *out, const char *name, const nqm_label *l) {
    html(out,
         "<tr><th scope='row'>%s</th><td class='n'>%.2f</td><td class='n'>%.2f</td><td class='n'>%.2f</td>"
         "<td class='n'>%.3f</td><td class='n'>%.2f</td><td class='n'>%.2f</td></tr>\n",
         name, l->shift[0], l->shift[1], l->shift[2], l->contrast, l->structure, nqm_label_adapted_jod(l));
}

/* The same as numbers. */
static void put_parts(FILE *out, const nqm_score_result *r, const nqm_label *rendered) {
    html(out, "<div class='scroll' role='region' aria-label='Parts of the difference' tabindex='0'>\n"
              "<table class='parts'><caption>Parts of the difference, test minus reference</caption>\n<thead><tr><th "
              "scope='col'>Label</th><th scope='col' class='n'>brighter</th>"
              "<th scope='col' class='n'>bluer</th><th scope='col' class='n'>redder</th>"
              "<th scope='col' class='n'>contrast</th><th scope='col' class='n'>structure</th>"
              "<th scope='col' class='n'>adapted</th></tr></thead>\n<tbody>\n");
    if (!isnan(r->parts.structure))
        put_parts_row(out, "Predicted", &r->parts);
    put_parts_row(out, "Pictures", rendered);
    html(out, "</tbody></table>\n</div>\n<p class='note'>In units of \xce\x94"
              "E&#160;ITP; contrast: logarithm of a ratio; structure: what remains without the mean shift; adapted: "
              "JOD of people who do not notice 85&#160;%% of the shift.</p>\n");
}

/* ---- numbers ----------------------------------------------------------------------------------------------------- */

static void put_metrics(FILE *out, const nqm_score_result *r) {
    html(out, "<table class='metrics'><caption>Scalar metrics of the BRDFs; 0 means equal</caption>\n<thead><tr>"
              "<th scope='col'>Metric</th><th scope='col' class='n'>Value</th>"
              "<th scope='col'>Over directions and channels</th></tr></thead>\n<tbody>\n");
    for (int m = 0; m < NQM_METRIC_COUNT; ++m) {
        const nqm_metric_info info = nqm_metric_get_info((nqm_metric)m);
        html(out, "<tr><th scope='row'><code>%s</code></th><td class='n'>%#.4g</td><td>%s</td></tr>\n", info.name,
             r->metrics[m], info.description);
    }
    html(out,
         "</tbody></table>\n<p class='note'>f: BRDF in 1/sr; c: product of the cosines of light and viewer.</p>\n");
}

static void put_counts(FILE *out, const char *who, const nqm_score_result *r, size_t k) {
    html(out, "<tr><th scope='row'>%s</th><td class='n'>%zu</td><td class='n'>%zu</td><td class='n'>%zu</td></tr>\n",
         who, r->n_clamped[k], r->n_invalid[k], r->n_unusual[k]);
}

static void put_values(const report_page *page, const scored_pair *row) {
    const score_run *scores = &page->run->scores;
    const nqm_score_result *r = &row->result;
    FILE *out = page->out;
    html(out,
         "<table class='values'><caption>Both BRDFs have a value at %zu of %zu directions</caption>\n"
         "<thead><tr><th scope='col'>Number of directions where</th><th scope='col' class='n'>a channel is negative "
         "and set to 0"
         "</th><th scope='col' class='n'>there is no value</th>"
         "<th scope='col' class='n'>the value is much brighter than in training</th></tr></thead>\n<tbody>\n",
         r->n_valid, scores->terms.n_directions);
    put_counts(out, "Reference", r, 0);
    put_counts(out, "Test", r, 1);
    html(out, "</tbody></table>\n");
    json_t *remarks = json_remarks(&scores->terms, &row->pair, "reference", "test", r);
    if (json_array_size(remarks))
        html(out, "<ul class='warnings'>\n");
    for (size_t i = 0; i < json_array_size(remarks); ++i)
        html(out, "<li>%s</li>\n", json_string_value(json_array_get(remarks, i)));
    if (json_array_size(remarks))
        html(out, "</ul>\n");
    json_decref(remarks);
}

/* ---- the section ------------------------------------------------------------------------------------------------- */

static void put_differences(const report_page *page, size_t place, const scored_pair *row) {
    html(page->out,
         "<div class='two'>\n<figure class='map'><figcaption>Directions where the BRDFs differ; at large "
         "\xce\xb8<sub>d</sub>, light and viewer are at grazing angles</figcaption>\n<div "
         "id='map-%zu'></div></figure>\n<div>\n",
         place + 1);
    put_metrics(page->out, &row->result);
    html(page->out, "</div>\n</div>\n");
    put_values(page, row);
    html(page->out,
         "<p class='note'>f<sub>r</sub> in 1/sr over the angle of the viewer; solid: reference; dashed: test</p>\n"
         "<div class='slices' id='slices-%zu'></div>\n",
         place + 1);
}

void put_test(const report_page *page, size_t place) {
    const scored_pair *row = &page->run->scores.rows[place];
    const char *name = page->run->names[row->order + 1];
    html(page->out,
         "<section class='test' id='test-%zu'>\n<h2><span class='rank'>%zu</span> <span class='name'>%s</span></h2>\n",
         place + 1, row->rank, name);
    if (strcmp(name, row->pair.test) != 0)
        html(page->out, "<p class='argument'><code>%s</code></p>\n", row->pair.test);
    put_verdict(page, row, item_of(page, row->order));
    html(page->out, "<div class='jod' id='jod-%zu'></div>\n", place + 1);
    put_words(page->out, &row->result, &item_of(page, row->order)->label);
    put_pictures(page, row);
    put_parts(page->out, &row->result, &item_of(page, row->order)->label);
    if (row->texture)
        put_texture(page, row);
    else
        put_differences(page, place, row);
    html(page->out, "</section>\n");
}
