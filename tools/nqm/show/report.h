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

/** The page while it is written. Its parts report an error and exit. */
typedef struct report_page {
    const report_run *run;
    FILE *out;
    char *figure;  /* temporary file for a picture, a .png */
    canvas all;    /* frames of the scene, the pictures of the page */
    double *white; /* backdrop (height, width, 3) */
    size_t place;  /* from 0 in the ranking, of the test whose section is written */
    const scored_pair *row;
    const label_item *item;
} report_page;

/** What takes the place of a mark {{...}} of report.html. */
typedef struct report_part {
    const char *mark;
    void (*put)(const report_page *page);
} report_part;

/** The parts of the section of a test; the last mark is NULL. */
extern const report_part report_test_parts[];

/** The texts of report.html, report.css and web/charts.* (cmake/embed_text.cmake). */
extern const char report_html[], report_css[], report_charts_css[], report_charts_js[];

/** The whole page. figure: path of a temporary PNG. */
void write_report(const report_run *run, FILE *out, char *figure);

/** What a section has of textured materials: the map of Delta-E, near and far scores, blame, and pictures of the maps. */
void put_texture(const report_page *page);

/** The picture in the temporary file, at a size in CSS pixels; removes the file. */
void put_figure(const report_page *page, const char *alt, size_t width, size_t height);
/** Pictures of reference and test, the map of their differences, and the scale of its colours. */
void put_reference_picture(const report_page *page);
void put_test_picture(const report_page *page);
void put_map(const report_page *page);
void put_scale(const report_page *page);

/** Identical BRDFs have none. */
bool has_interval(const nqm_score_result *result);

#endif
