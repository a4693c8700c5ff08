/* SPDX-License-Identifier: MIT
 *
 * fit_run.h - the results of nqm fit, and how they are printed.
 */
#ifndef NQM_TOOL_FIT_RUN_H
#define NQM_TOOL_FIT_RUN_H

#include "nqm/score/score.h"
#include <nqm/match.h>

enum { FIT_MAX_PATH = 4096 };

/** The result of one model. */
typedef struct fitted {
    const char *model;
    nqm_error err; /* status NQM_OK, or the error of the model: then the fields below are not set */
    nqm_match_report match;
    double metrics[NQM_METRIC_COUNT];
    nqm_score_result score; /* by --metric */
    double seconds;
    char path[FIT_MAX_PATH]; /* path of the file; "" if the result is a spec or was not written */
    char before[2048];       /* spec of the fit under the loss "log", which the report shows; "": none */
} fitted;

/** What print_fits() shows. */
typedef enum fit_view { FIT_TABLE, FIT_VERBOSE, FIT_JSON, FIT_QUIET } fit_view;

/** The BRDF argument of the result; NULL if the model failed, or its result is a network or table that was not written. */
const char *fitted_argument(const fitted *f);
/** Print n results: tables with the best JOD first, JSON and arguments in the order of the models. loss: of analytic models;
 *  metric: gave the scores. */
void print_fits(size_t n, const fitted *f, fit_view view, const char *loss, const nqm_model *metric);

#endif
