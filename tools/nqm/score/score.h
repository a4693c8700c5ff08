/* SPDX-License-Identifier: MIT
 *
 * score.h - computing and printing of the scores of `nqm score`, and functions that `nqm batch` and `nqm rank` use too.
 */
#ifndef NQM_TOOL_SCORE_H
#define NQM_TOOL_SCORE_H

#include "metric/metric.h"
#include "nqm/tool.h"

/** A test and its score, or the error when it has none. */
typedef struct score_row {
    const char *name;
    nqm_brdf *brdf; /* NULL: it could not be opened */
    nqm_error err;  /* status NQM_OK: scored */
    nqm_score_result result;
} score_row;

typedef struct score_run {
    const char *ref_name;
    char **test_names; /* (n_rows) */
    nqm_brdf *ref;
    nqm_model *model;
    size_t n_directions;
    nqm_score_options options;
    bool metrics[NQM_METRIC_COUNT]; /* which to print */
    result_format format;
    size_t n_rows;
    score_row *rows; /* (n_rows) in the order of the arguments */
} score_run;

/** Settings that remarks refer to. */
typedef struct remark_terms {
    size_t n_directions;
    nqm_invalid_policy invalid;
} remark_terms;

/** Append remarks on negative, missing and unusual values of a scored pair to a JSON array; `who` names the BRDF. */
void remark_on_reference(const remark_terms *terms, const char *who, const nqm_score_result *r, json_t *remarks);
void remark_on_test(const remark_terms *terms, const char *who, const nqm_score_result *r, json_t *remarks);

/** Parse --metrics: "all" or names separated by commas. EXIT_OK, or a usage error that lists the names. chosen:
 *  (NQM_METRIC_COUNT) */
int choose_metrics(const char *verb, const char *text, bool *chosen);
/** The "model" member of results: id, sha256, parameters, and the precision when it is not f32. */
json_t *model_json(const nqm_model *model, nqm_precision precision);

/** Open the model, the reference and the tests that run->ref_name and run->test_names name, and score them; errors of
 *  single tests are stored in their rows. Returns EXIT_OK; on failure, reports the error and returns its exit code.
 *  Call free_scores() in both cases. */
int make_scores(const char *verb, score_run *run, const char *model_name);
/** Free the results of make_scores(). */
void free_scores(score_run *run);

/** The JSON document of `nqm score --json`. */
json_t *json_scores(const score_run *run);
/** Fraction of people who would say that the reference looks better; 0.5 is guessing. */
double noticed_share(const nqm_score_result *result);
/** What a score means, in words. */
const char *verdict_words(const nqm_score_result *result);
/** Print the results on standard output, remarks on standard error. EXIT_OK or EXIT_OPEN. */
int print_scores(const score_run *run);

#endif
