/* SPDX-License-Identifier: MIT
 *
 * report.h - what `nqm report` gathers, and the parts of its page.
 */
#ifndef NQM_TOOL_REPORT_H
#define NQM_TOOL_REPORT_H

#include "figures/plot.h"
#include "nqm/label/label.h"
#include "nqm/score/rank.h"
#include "nqm/show/html.h"

enum { NAME_SIZE = 128 };

typedef struct report_run {
    const char *title, *date; /* NULL: what is compared; none */
    score_run scores;
    label_run labels; /* item 0 is the reference, item i + 1 is test i */
    ranking ranking;  /* the tests, best first; `order` is the index of the test */
    char (*short_names)[NAME_SIZE];
    const char **names; /* (n_items) of the labels' items: the argument, or a short form where it is long and
                           that tells them apart */
} report_run;

/** A page that is being written. Parts return EXIT_OK, or the fault is reported and its exit code returned. */
typedef struct report_page {
    const report_run *run;
    FILE *out;
    char *figure;          /* where a figure is drawn, before the page takes it in: a .png */
    double *white;         /* backdrop (height, width, 3) */
    double *picture, *map; /* (height, width, 3), (height, width) */
    double *delta_e;       /* (tests, points) */
    double delta_e_max;    /* upper end of the scale of all maps */
} report_page;

/** The CSS of the page. */
extern const char report_style[];

/** The whole page. figure: path of a PNG that may be written and removed. */
int write_report(const report_run *run, FILE *out, char *figure);

/** The section of the test at a place of the ranking. */
int put_test(const report_page *page, size_t place);

/** What is needed to draw; end_figures() in any case. */
int begin_figures(report_page *page);
void end_figures(report_page *page);
/** A label item as it was rendered, in the first frame. */
int put_picture(const report_page *page, size_t item, const char *alt);
/** Where the pictures of a test and the reference differ, and the scale of all such maps. */
int put_map(const report_page *page, size_t test, const char *alt);
int put_scale(const report_page *page, const char *alt);
/** Where the BRDFs differ, over angles; cuts through both. */
int put_attribution(const report_page *page, size_t test, const char *alt);
int put_slices(const report_page *page, size_t test, const char *alt);

/** A number on the scale from 0 to 10, with its interval and, as a ring, the JOD of the rendered pictures. */
void put_strip(FILE *out, const nqm_score_result *result, double rendered_jod);
/** " (95 % interval 8.9 to 9.6)", or nothing where the model gives none. */
void put_interval(FILE *out, const nqm_score_result *result);

#endif
