/* SPDX-License-Identifier: MIT
 *
 * Opens a reference and its tests by name and scores them, for the commands that score one reference.
 */
#include "nqm/score/score.h"

#include <math.h>
#include <stdlib.h>

/* Set the error of a test that was opened but has no score. */
static void explain(const score_run *run, score_row *row) {
    const nqm_score_result *r = &row->result;
    row->err.status = r->status;
    if (r->status == NQM_ERR_INCOMPATIBLE && run->options.invalid == NQM_INVALID_ERROR && r->n_invalid_test)
        snprintf(row->err.message, sizeof row->err.message, "%s: no value at %zu of %zu directions", row->name,
                 r->n_invalid_test, run->n_directions);
    else if (r->status == NQM_ERR_INCOMPATIBLE)
        snprintf(row->err.message, sizeof row->err.message,
                 "%s: only at %zu of %zu directions have both BRDFs a value (--min-valid asks for %.0f)", row->name,
                 r->n_valid, run->n_directions, ceil(run->options.min_valid_fraction * (double)run->n_directions));
    else
        snprintf(row->err.message, sizeof row->err.message, "%s: %s", row->name, nqm_status_text(r->status));
}

/* Open every test and score those that can be opened; the rows of the others receive the error. */
static nqm_status score_tests(score_run *run, nqm_error *err) {
    const nqm_brdf **tests = calloc(run->n_rows, sizeof *tests);
    nqm_score_result *results = calloc(run->n_rows, sizeof *results);
    nqm_status status = NQM_OK;
    if (!tests || !results) {
        status = err->status = NQM_ERR_NOMEM;
        goto done;
    }
    size_t n = 0;
    for (size_t i = 0; i < run->n_rows && !interrupted(); ++i)
        if (nqm_brdf_open(run->rows[i].name, &run->rows[i].brdf, &run->rows[i].err) == NQM_OK)
            tests[n++] = run->rows[i].brdf;
    if (interrupted()) {
        status = err->status = NQM_ERR_CANCELLED;
        goto done;
    }
    status = nqm_score(run->model, run->ref, n, tests, &run->options, results, err);
    n = 0;
    for (size_t i = 0; status == NQM_OK && i < run->n_rows; ++i) {
        score_row *row = &run->rows[i];
        if (!row->brdf)
            continue;
        row->result = results[n++];
        if (row->result.status != NQM_OK)
            explain(run, row);
    }
done:
    free(tests);
    free(results);
    return status;
}

int make_scores(const char *verb, score_run *run, const char *model_name) {
    nqm_error err = {0};
    run->rows = calloc(run->n_rows, sizeof *run->rows);
    if (!run->rows)
        return report(verb, EXIT_LIMIT, "out of memory");
    for (size_t i = 0; i < run->n_rows; ++i)
        run->rows[i].name = run->test_names[i];
    int exit_code = open_model(verb, model_name, &run->model);
    if (exit_code != EXIT_OK)
        return exit_code;
    run->n_directions = nqm_directions_count(nqm_model_get_info(run->model).directions);
    if (nqm_brdf_open(run->ref_name, &run->ref, &err) != NQM_OK || score_tests(run, &err) != NQM_OK)
        return report_error(verb, &err);
    return EXIT_OK;
}

void free_scores(score_run *run) {
    for (size_t i = 0; run->rows && i < run->n_rows; ++i)
        nqm_brdf_free(run->rows[i].brdf);
    free(run->rows);
    nqm_brdf_free(run->ref);
    nqm_model_free(run->model);
}
