/* SPDX-License-Identifier: MIT
 *
 * The part of a report about one test: what its score means, pictures, metrics, where it differs, what its values gave
 * cause to remark.
 */
#include "nqm/show/report.h"

#include <string.h>

/* What the metrics of nqm_metric are, in their order. */
static const char *const metric_words[NQM_METRIC_COUNT] = {"root mean square difference of f",
                                                           "mean absolute difference of f",
                                                           "RMS difference of \xe2\x88\x9b(c f)",
                                                           "mean absolute difference of \xe2\x88\x9b(c f)",
                                                           "RMS difference of log(1 + f)",
                                                           "mean absolute difference of log(1 + f)",
                                                           "RMS difference of log(1 + c f)",
                                                           "mean absolute difference of log(1 + c f)",
                                                           "mean absolute difference of log(f + 0.003)"};

static const label_item *item_of(const report_page *page, size_t test) {
    return &page->run->labels.items[test + 1];
}

static void put_verdict(const report_page *page, const score_row *row, const label_item *item) {
    const nqm_score_result *r = &row->result;
    html(page->out, "<p class='verdict'><strong>JOD %s</strong>", html_fixed(r->jod, 2).text);
    put_interval(page->out, r);
    html(page->out, ": %s. ", verdict_words(r));
    if (r->identical)
        html(page->out, "Both BRDFs are equal at every direction that was compared.");
    else
        html(page->out,
             "Shown beside the reference, it would be called the worse one by an expected %s of people; "
             "50&#160;%% is guessing.",
             html_share(noticed_share(r)).text);
    html(page->out,
         " The pictures below differ by a mean \xce\x94"
         "E&#160;ITP of %s, which stands for JOD %s.</p>\n",
         html_fixed(item->delta_e, 2).text, html_fixed(item->jod, 2).text);
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

static int put_pictures(const report_page *page, size_t test) {
    FILE *out = page->out;
    const label_item *item = item_of(page, test);
    char alt[200];
    html(out, "<div class='triple'>\n<figure>");
    int exit_code = put_picture(page, 0, "Rendered picture of the reference");
    html(out, "<figcaption>Reference: <span class='name'>%s</span></figcaption></figure>\n<figure>",
         page->run->names[0]);
    if (exit_code == EXIT_OK)
        exit_code = put_picture(page, test + 1, "Rendered picture of the test");
    html(out, "<figcaption>Test: <span class='name'>%s</span></figcaption></figure>\n<figure>",
         page->run->names[test + 1]);
    snprintf(alt, sizeof alt, "Map of the colour difference of the two pictures, on average %s",
             html_fixed(item->delta_e, 2).text);
    if (exit_code == EXIT_OK)
        exit_code = put_map(page, test, alt);
    html(out, "<figcaption>\xce\x94"
              "E&#160;ITP of each pixel; 1 is just visible at best\n<span class='scale'>");
    if (exit_code == EXIT_OK)
        exit_code = put_scale(page, "Colours from dark, equal, to bright, different");
    html(out,
         "<span class='ticks'><span>0</span><span>%s</span><span>\xe2\x89\xa5&#160;%s</span></span></span>"
         "</figcaption></figure>\n</div>\n",
         html_digits(page->delta_e_max / 2, 3).text, html_digits(page->delta_e_max, 3).text);
    return exit_code;
}

/* ---- numbers ----------------------------------------------------------------------------------------------------- */

static void put_metrics(FILE *out, const nqm_score_result *r) {
    html(out, "<table class='metrics'><caption>Scalar metrics of the BRDFs; 0 is equal</caption>\n<thead><tr>"
              "<th scope='col'>Metric</th><th scope='col' class='n'>Value</th>"
              "<th scope='col'>Over directions and channels</th></tr></thead>\n<tbody>\n");
    for (int m = 0; m < NQM_METRIC_COUNT; ++m)
        html(out, "<tr><th scope='row'><code>%s</code></th><td class='n'>%s</td><td>%s</td></tr>\n",
             nqm_metric_name((nqm_metric)m), html_all_digits(r->metrics[m], 4).text, metric_words[m]);
    html(out,
         "</tbody></table>\n<p class='note'>f: BRDF in 1/sr; c: product of the cosines of light and viewer.</p>\n");
}

static void put_counts(FILE *out, const char *who, size_t clamped, size_t invalid, size_t unusual) {
    html(out, "<tr><th scope='row'>%s</th><td class='n'>%s</td><td class='n'>%s</td><td class='n'>%s</td></tr>\n", who,
         html_count(clamped).text, html_count(invalid).text, html_count(unusual).text);
}

static void put_values(const report_page *page, const score_row *row) {
    const score_run *scores = &page->run->scores;
    const nqm_score_result *r = &row->result;
    FILE *out = page->out;
    html(
        out,
        "<table class='values'><caption>Directions: %s of %s hold a value in both BRDFs</caption>\n"
        "<thead><tr><th scope='col'>Directions at which</th><th scope='col' class='n'>a channel is negative, taken as 0"
        "</th><th scope='col' class='n'>there is no value</th>"
        "<th scope='col' class='n'>it is far brighter than in training</th></tr></thead>\n<tbody>\n",
        html_count(r->n_valid).text, html_count(scores->n_directions).text);
    put_counts(out, "Reference", r->n_clamped_ref, r->n_invalid_ref, r->n_unusual_ref);
    put_counts(out, "Test", r->n_clamped_test, r->n_invalid_test, r->n_unusual_test);
    html(out, "</tbody></table>\n");
    const remark_terms terms = {scores->n_directions, scores->options.invalid};
    json_t *remarks = json_array();
    remark_on_reference(&terms, "reference", r, remarks);
    remark_on_test(&terms, "test", r, remarks);
    if (json_array_size(remarks))
        html(out, "<ul class='warnings'>\n");
    for (size_t i = 0; i < json_array_size(remarks); ++i)
        html(out, "<li>%s</li>\n", json_string_value(json_array_get(remarks, i)));
    if (json_array_size(remarks))
        html(out, "</ul>\n");
    json_decref(remarks);
}

/* ---- the section ------------------------------------------------------------------------------------------------- */

static int put_differences(const report_page *page, size_t test, const score_row *row) {
    FILE *out = page->out;
    html(out, "<div class='two'>\n<figure>");
    int exit_code = put_attribution(
        page, test, "Map over theta_h and theta_d of the difference of the logarithms of the two BRDFs");
    html(out, "<figcaption>Where in angle the BRDFs differ: \xce\xb8<sub>h</sub> 0 is the mirror direction, large "
              "\xce\xb8<sub>d</sub> is grazing light.</figcaption></figure>\n<div>\n");
    put_metrics(out, &row->result);
    html(out, "</div>\n</div>\n");
    put_values(page, row);
    html(out, "<figure class='wide' tabindex='0'>");
    if (exit_code == EXIT_OK)
        exit_code = put_slices(page, test, "Cuts through both BRDFs over angles, and polar lobes");
    html(out, "</figure>\n");
    return exit_code;
}

int put_test(const report_page *page, size_t place) {
    const rank_row *ranked = &page->run->ranking.rows[place];
    const score_row *row = &page->run->scores.rows[ranked->order];
    const char *name = page->run->names[ranked->order + 1];
    html(page->out,
         "<section class='test' id='test-%s'>\n<h2><span class='rank'>%s</span> <span class='name'>%s</span></h2>\n",
         html_count(place + 1).text, html_count(ranked->rank).text, name);
    if (strcmp(name, row->name) != 0)
        html(page->out, "<p class='argument'><code>%s</code></p>\n", row->name);
    put_verdict(page, row, item_of(page, ranked->order));
    int exit_code = put_pictures(page, ranked->order);
    if (exit_code == EXIT_OK)
        exit_code = put_differences(page, ranked->order, row);
    html(page->out, "</section>\n");
    return exit_code;
}
