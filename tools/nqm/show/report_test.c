/* SPDX-License-Identifier: MIT
 *
 * The section of a report about one test: its score in words, pictures, metrics, warnings.
 */
#include "nqm/show/report.h"

#include <math.h>
#include <string.h>

static const char *name_of(const report_page *page) {
    return page->run->names[page->row->order + 1];
}

/* ---- words ------------------------------------------------------------------------------------------------------- */

static void put_place(const report_page *page) {
    html(page->out, "%zu", page->place + 1);
}

static void put_rank(const report_page *page) {
    html(page->out, "%zu", page->row->rank);
}

static void put_name(const report_page *page) {
    html(page->out, "%s", name_of(page));
}

static void put_reference(const report_page *page) {
    html(page->out, "%s", page->run->names[0]);
}

static void put_argument(const report_page *page) {
    if (strcmp(name_of(page), page->row->pair.test) != 0)
        html(page->out, "<p class='argument'><code>%s</code></p>\n", page->row->pair.test);
}

static void put_verdict(const report_page *page) {
    const nqm_score_result *r = &page->row->result;
    char verdict[VERDICT_TEXT];
    html(page->out, "<strong>JOD %.2f</strong>", r->jod);
    if (has_interval(r))
        html(page->out, " <span class='interval'>(95&#160;%% interval %.2f to %.2f)</span>", r->jod_low, r->jod_high);
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
         "E&#160;ITP %.2f, which corresponds to JOD %.2f.",
         page->item->label.delta_e, page->item->jod);
}

/* What differs, as predicted and in the pictures. */
static void put_words(const report_page *page) {
    const nqm_label *predicted = &page->row->result.parts;
    char words[NQM_LABEL_TEXT];
    if (!isnan(predicted->structure))
        html(page->out, "Predicted: <strong>%s</strong>. ", nqm_label_describe(predicted, words));
    html(page->out, "In the pictures: <strong>%s</strong>.", nqm_label_describe(&page->item->label, words));
}

/* ---- numbers ----------------------------------------------------------------------------------------------------- */

static void put_ticks(const report_page *page) {
    const double end = page->run->labels.delta_e_max;
    html(page->out, "<span>0</span><span>%.3g</span><span>\xe2\x89\xa5&#160;%.3g</span>", end / 2, end);
}

static void put_parts_row(FILE *out, const char *name, const nqm_label *l) {
    html(out,
         "<tr><th scope='row'>%s</th><td class='n'>%.2f</td><td class='n'>%.2f</td><td class='n'>%.2f</td>"
         "<td class='n'>%.3f</td><td class='n'>%.2f</td><td class='n'>%.2f</td></tr>\n",
         name, l->shift[0], l->shift[1], l->shift[2], l->contrast, l->structure, nqm_label_adapted_jod(l));
}

static void put_parts(const report_page *page) {
    if (!isnan(page->row->result.parts.structure))
        put_parts_row(page->out, "Predicted", &page->row->result.parts);
    put_parts_row(page->out, "Pictures", &page->item->label);
}

static void put_metrics(const report_page *page) {
    for (int m = 0; m < NQM_METRIC_COUNT; ++m) {
        const nqm_metric_info info = nqm_metric_get_info((nqm_metric)m);
        html(page->out, "<tr><th scope='row'><code>%s</code></th><td class='n'>%#.4g</td><td>%s</td></tr>\n", info.name,
             page->row->result.metrics[m], info.description);
    }
}

static void put_valid(const report_page *page) {
    html(page->out, "%zu of %zu", page->row->result.n_valid, page->run->scores.terms.n_directions);
}

static void put_counts(const report_page *page) {
    const nqm_score_result *r = &page->row->result;
    for (size_t k = 0; k < 2; ++k)
        html(page->out,
             "<tr><th scope='row'>%s</th><td class='n'>%zu</td><td class='n'>%zu</td><td class='n'>%zu</td></tr>\n",
             k ? "Test" : "Reference", r->n_clamped[k], r->n_invalid[k], r->n_unusual[k]);
}

static void put_remarks(const report_page *page) {
    json_t *remarks = json_remarks(&page->run->scores.terms, &page->row->pair, "reference", "test", &page->row->result);
    const size_t n = json_array_size(remarks);
    for (size_t i = 0; i < n; ++i) {
        html(page->out, i ? "" : "<ul class='warnings'>\n");
        html(page->out, "<li>%s</li>\n", json_string_value(json_array_get(remarks, i)));
    }
    html(page->out, n ? "</ul>\n" : "");
    json_decref(remarks);
}

const report_part report_test_parts[] = {{"{{place}}", put_place},
                                         {"{{rank}}", put_rank},
                                         {"{{name}}", put_name},
                                         {"{{reference}}", put_reference},
                                         {"{{argument}}", put_argument},
                                         {"{{verdict}}", put_verdict},
                                         {"{{words}}", put_words},
                                         {"{{reference picture}}", put_reference_picture},
                                         {"{{test picture}}", put_test_picture},
                                         {"{{map}}", put_map},
                                         {"{{scale}}", put_scale},
                                         {"{{ticks}}", put_ticks},
                                         {"{{parts}}", put_parts},
                                         {"{{texture}}", put_texture},
                                         {"{{metrics}}", put_metrics},
                                         {"{{valid}}", put_valid},
                                         {"{{counts}}", put_counts},
                                         {"{{remarks}}", put_remarks},
                                         {NULL, NULL}};
