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

/** Score and render the arguments, a reference and its tests, and write the page to `out`, which it closes. The
 *  caller sets model and options of the scores, scene and shrink of the labels, title and date first. names:
 *  (n_arguments) shown instead of automatic ones where not NULL; NULL: none. Errors end the program. */
void make_report(report_run *run, int n_arguments, char **arguments, const char *const *names, output_file *out);
/** The same for fits or a translation of a reference: scored by the model `metric`, with pictures of the standard scenes. */
void write_fit_page(const char *title, int n_arguments, char **arguments, const char *const *names, const char *metric,
                    output_file *out);
/** Free the results and the model. */
void free_report(report_run *run);

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
/** Markup of the picture of an item, of the map of its difference from the reference, and of the scale of its colours. */
json_t *draw_item(const report_page *page, size_t item, const char *alt);
json_t *draw_difference(const report_page *page, size_t item);
json_t *draw_scale(const report_page *page);

#endif
