/* SPDX-License-Identifier: MIT
 *
 * report.h - the data of `nqm report`, and the parts of its page.
 */
#ifndef NQM_TOOL_REPORT_H
#define NQM_TOOL_REPORT_H

#include "nqm/label/label.h"
#include "nqm/score/score.h"
#include "nqm/template.h"

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

/** Open the file of a page, which `name` is the option of; another output is a usage error. */
void open_page(const char *name, const char *path, output_file *out);
/** A BRDF of a page: the argument, and its name if that is not "". */
typedef struct page_item {
    const char *argument;
    char name[NAME_SIZE];
} page_item;
/** Write the page of fits or a translation of a reference, the first item, which it closes: scored by the model `metric`, with
 *  pictures of the standard scenes. */
void write_fit_page(const char *title, int n, const page_item *items, const char *metric, output_file *out);
/** The texts of report.html, report.css and web/charts.* (cmake/embed_text.cmake). */
extern const char report_html[], report_css[], report_charts_css[], report_charts_js[];

/** The whole page. figure: path of a temporary PNG. */
void write_report(const report_run *run, FILE *out, char *figure);

#endif
