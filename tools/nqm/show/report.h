/* SPDX-License-Identifier: MIT
 *
 * report.h - the data of `nqm report`, and the parts of its page.
 */
#ifndef NQM_TOOL_REPORT_H
#define NQM_TOOL_REPORT_H

#include "figures/plot.h"
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
    char *figure;          /* temporary file for a figure, a .png */
    canvas all;            /* frames of the scene, the pictures of the page */
    double *white;         /* backdrop (height, width, 3) */
    double *picture, *map; /* (height, width, 3), (height, width) */
    double *delta_e;       /* (tests, points) */
    double delta_e_max;    /* upper end of the scale of all maps */
} report_page;

/** The CSS of the page. */
extern const char report_style[];

/** The whole page. figure: path of a temporary PNG. */
void write_report(const report_run *run, FILE *out, char *figure);

/** The section of the test at a place (from 0) in the ranking. */
void put_test(const report_page *page, size_t place);

/** What a section has of textured materials: the map of Delta-E, near and far scores, blame, and pictures of the maps. */
void put_texture(const report_page *page, const scored_pair *row);

/** Allocate the buffers for drawing, and free them. */
void begin_figures(report_page *page);
void end_figures(report_page *page);
/** The rendered picture of a label item, with all frames. */
void put_picture(const report_page *page, size_t item, const char *alt);
/** Map of the differences between the pictures of a test and the reference; the colour scale of all such maps. */
void put_map(const report_page *page, size_t test, const char *alt);
void put_scale(const report_page *page, const char *alt);
/** Map of the differences of the BRDFs over angles; slices of both. */
void put_attribution(const report_page *page, size_t test, const char *alt);
void put_slices(const report_page *page, size_t test, const char *alt);

/** The predicted JOD on a scale from 0 to 10, with its interval, and a ring at the JOD of the rendered pictures. */
void put_strip(FILE *out, const nqm_score_result *result, double rendered_jod);
/** " (95 % interval 8.9 to 9.6)", or nothing if there is none. */
void put_interval(FILE *out, const nqm_score_result *result);

#endif
