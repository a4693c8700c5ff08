/* SPDX-License-Identifier: MIT
 *
 * report.h - the data of `nqm report`, and the parts of its page.
 */
#ifndef NQM_TOOL_REPORT_H
#define NQM_TOOL_REPORT_H

#include "nqm/label/label.h"
#include "nqm/score/score.h"
#include "nqm/show/html.h"

enum { NAME_SIZE = 128 };

typedef struct report_run {
    const char *title, *date; /* NULL: automatic; none */
    score_run scores;         /* the tests, best first; `order` is the index of the test in the arguments */
    json_t *json_scores;
    label_run labels; /* item 0 is the reference, item i + 1 is the test with order i */
    nqm_brdf **brdfs; /* in the order of the label items */
    char (*short_names)[NAME_SIZE];
    const char **names; /* (n_items) of the labels' items: the argument, or a short form if it is long and the
                           short forms differ */
} report_run;

/** Write the page of fits or a translation of a reference, which it closes: scored by the model `metric`, with pictures of the standard scenes. */
void write_fit_page(const char *title, int n_arguments, char **arguments, const char *const *names, const char *metric,
                    output_file *out);
/** The page while it is written. Its functions report an error and exit. */
typedef struct report_page {
    const report_run *run;
    char *figure;  /* temporary file for a picture, a .png */
    canvas all;    /* frames of the scene, the pictures of the page */
    double *white; /* backdrop (height, width, 3) */
} report_page;

/** The texts of report.html, report.css and web/charts.* (cmake/embed_text.cmake). */
extern const char report_html[], report_css[], report_charts_css[], report_charts_js[];

/** The whole page. figure: path of a temporary PNG. */
void write_report(const report_run *run, FILE *out, char *figure);

/** What report.html shows in the section of a test, and of its textures. */
json_t *json_test(const report_page *page, const scored_pair *row);
json_t *json_report_texture(const report_page *page, const scored_pair *row);

/** Markup of the picture in the temporary file, which is removed, at a size in CSS pixels. */
json_t *take_figure(const report_page *page, const char *alt, size_t width, size_t height);

#endif
