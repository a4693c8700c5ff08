/* SPDX-License-Identifier: MIT
 *
 * fit_tool.h - shared by the files of `nqm fit`: the models and bounds of the command line, and the result of each model.
 */
#ifndef NQM_FIT_TOOL_H
#define NQM_FIT_TOOL_H

#include "nqm/tool.h"

enum { FIT_MAX_MODELS = 32, FIT_MAX_BOUNDS = 8, FIT_MAX_PATH = 4096 };

/** The models to fit, in the order of the command line. */
typedef struct fit_request {
    const char *models[FIT_MAX_MODELS]; /* names of the library */
    size_t n_models;
    char bound_keys[FIT_MAX_BOUNDS][16];
    nqm_fit_bound bounds[FIT_MAX_BOUNDS]; /* their keys are the texts above */
    size_t n_bounds;
} fit_request;

/** "all", "encodings", or names separated by commas. */
void choose_models(const char *text, fit_request *request);
/** "KEY=LOW:HIGH,..."; NULL: none. Each key must belong to one of the models. */
void choose_bounds(const char *text, fit_request *request);

/** The result of one model. */
typedef struct fitted {
    const char *model;
    nqm_error err; /* status NQM_OK, or the error of the model: then the fields below are not set */
    nqm_fit_report fit;
    double metrics[NQM_METRIC_COUNT];
    double seconds;
    char path[FIT_MAX_PATH]; /* of the file written; "" if the result is a spec or was not written */
} fitted;

/** The BRDF argument of the result; NULL if the model failed, or its result is a network or table that was not written. */
const char *fitted_argument(const fitted *f);

void print_fits_as_json(size_t n, const fitted *f, nqm_fit_loss loss);
/** A table with one row per model. */
void print_fits_as_table(size_t n, const fitted *f);
/** All results of each model. */
void print_fit_report(size_t n, const fitted *f, nqm_fit_loss loss);

#endif
