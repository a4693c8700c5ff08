/* SPDX-License-Identifier: MIT
 *
 * The results of `nqm score` as a table for people, as bare numbers, as JSON (doc/cli.md) and as CSV.
 */
#include "nqm/score/score.h"

#include <math.h>
#include <string.h>

/* ---- remarks ----------------------------------------------------------------------------------------------------- */

/* Print remarks on standard error; remarks about the reference are printed once. */
static void print_remarks(const score_run *run) {
    const remark_terms terms = {run->n_directions, run->options.invalid};
    json_t *remarks = json_array();
    bool reference_done = false;
    for (size_t i = 0; i < run->n_rows; ++i) {
        const score_row *row = &run->rows[i];
        if (row->err.status != NQM_OK)
            continue;
        if (!reference_done)
            remark_on_reference(&terms, run->ref_name, &row->result, remarks);
        reference_done = true;
        remark_on_test(&terms, row->name, &row->result, remarks);
    }
    for (size_t i = 0; i < json_array_size(remarks); ++i)
        fprintf(stderr, "nqm score: %s\n", json_string_value(json_array_get(remarks, i)));
    json_decref(remarks);
}

/* ---- text -------------------------------------------------------------------------------------------------------- */

double noticed_share(const nqm_score_result *result) {
    return result->identical ? 0.5 : nqm_jod_preference(fmax(10, result->jod), result->jod);
}

const char *verdict_words(const nqm_score_result *result) {
    return result->identical ? "identical" : jod_words(result->jod);
}

static int metric_width(int m) {
    int n = (int)strlen(nqm_metric_name((nqm_metric)m));
    return n > 9 ? n : 9;
}

static void print_jod(const score_row *row, bool calibrated) {
    char text[INTERVAL_TEXT];
    bool scored = row->err.status == NQM_OK;
    if (scored)
        printf("  %5.2f", row->result.jod);
    else
        printf("  %5s", "-");
    if (calibrated)
        printf("  %-*s", INTERVAL_WIDTH, scored ? interval_text(&row->result, text) : "-");
}

static void print_text(const score_run *run) {
    printf("reference  %s\nmodel      %s\n\n", run->ref_name, nqm_model_get_info(run->model).id);
    bool calibrated = *nqm_model_get_info(run->model).calibration;
    printf("  %5s", "JOD");
    if (calibrated)
        printf("  %-*s", INTERVAL_WIDTH, "[95 %]");
    printf("  %7s  %-20s", "noticed", "verdict");
    for (int m = 0; m < NQM_METRIC_COUNT; ++m)
        if (run->metrics[m])
            printf("  %*s", metric_width(m), nqm_metric_name((nqm_metric)m));
    puts("  test");
    for (size_t i = 0; i < run->n_rows; ++i) {
        const score_row *row = &run->rows[i];
        const nqm_score_result *r = &row->result;
        bool scored = row->err.status == NQM_OK;
        print_jod(row, calibrated);
        if (scored)
            printf("  %5.0f %%  %-20s", 100 * noticed_share(r), verdict_words(r));
        else
            printf("  %7s  %-20s", "-", "no score");
        for (int m = 0; m < NQM_METRIC_COUNT; ++m) {
            if (run->metrics[m] && scored)
                printf("  %*.4g", metric_width(m), r->metrics[m]);
            else if (run->metrics[m])
                printf("  %*s", metric_width(m), "-");
        }
        printf("  %s\n", row->name);
    }
    puts("\nJOD 10: no visible difference; above 9.5: practically the same; one JOD less: 75 % of people notice.\n"
         "noticed: people who would say that the reference looks better (50 % is guessing).");
    if (calibrated)
        puts("[95 %]: where the JOD of rendered pictures lies for 95 % of pairs, if the material is new to the model "
             "and\n"
             "the kind of distortion is not.");
}

static void print_quiet(const score_run *run) {
    for (size_t i = 0; i < run->n_rows; ++i) {
        if (run->rows[i].err.status == NQM_OK)
            printf("%.4f\n", run->rows[i].result.jod);
        else
            puts("nan");
    }
}

/* ---- JSON and CSV ------------------------------------------------------------------------------------------------ */

/* `value`, or NaN when the test has no score; NaN is printed as null in JSON and as an empty field in CSV. */
static double number_of(const score_row *row, double value) {
    return row->err.status == NQM_OK ? value : (double)NAN;
}

static json_t *row_json(const score_run *run, const score_row *row) {
    const nqm_score_result *r = &row->result;
    bool scored = row->err.status == NQM_OK;
    json_t *metrics = json_object(), *warnings = json_array();
    for (int m = 0; m < NQM_METRIC_COUNT; ++m)
        if (run->metrics[m])
            json_object_set_new(metrics, nqm_metric_name((nqm_metric)m), json_number(number_of(row, r->metrics[m])));
    if (scored) {
        const remark_terms terms = {run->n_directions, run->options.invalid};
        remark_on_reference(&terms, "reference", r, warnings);
        remark_on_test(&terms, "test", r, warnings);
    }
    json_t *object =
        json_pack("{s:o,s:o,s:o,s:o,s:o,s:o,s:b,s:I,s:o,s:o}", "test", json_name(row->name), "jod",
                  json_number(number_of(row, r->jod)), "jod_low", json_number(number_of(row, r->jod_low)), "jod_high",
                  json_number(number_of(row, r->jod_high)), "delta_e_itp", json_number(number_of(row, r->delta_e)),
                  "novelty", json_number(number_of(row, r->novelty)), "identical", scored && r->identical, "n_valid",
                  (json_int_t)r->n_valid, "metrics", metrics, "warnings", warnings);
    if (!scored)
        json_object_set_new(object, "error", json_name(row->err.message));
    return object;
}

json_t *json_scores(const score_run *run) {
    json_t *results = json_array();
    for (size_t i = 0; i < run->n_rows; ++i)
        json_array_append_new(results, row_json(run, &run->rows[i]));
    return json_pack("{s:i,s:o,s:o,s:o,s:o}", "schema", 1, "tool", json_tool(), "model",
                     model_json(run->model, run->options.precision), "reference", json_name(run->ref_name), "results",
                     results);
}

static void print_scores_csv(const score_run *run) {
    printf("reference,test,jod,jod_low,jod_high,delta_e_itp,identical,n_valid");
    for (int m = 0; m < NQM_METRIC_COUNT; ++m)
        if (run->metrics[m])
            printf(",%s", nqm_metric_name((nqm_metric)m));
    puts(",error");
    for (size_t i = 0; i < run->n_rows; ++i) {
        const score_row *row = &run->rows[i];
        const nqm_score_result *r = &row->result;
        print_csv_text(stdout, run->ref_name);
        putchar(',');
        print_csv_text(stdout, row->name);
        const double numbers[] = {r->jod, r->jod_low, r->jod_high, r->delta_e};
        for (size_t k = 0; k < sizeof numbers / sizeof *numbers; ++k) {
            putchar(',');
            print_csv_number(stdout, number_of(row, numbers[k]));
        }
        printf(",%d,%zu", row->err.status == NQM_OK && r->identical, r->n_valid);
        for (int m = 0; m < NQM_METRIC_COUNT; ++m)
            if (run->metrics[m]) {
                putchar(',');
                print_csv_number(stdout, number_of(row, r->metrics[m]));
            }
        putchar(',');
        print_csv_text(stdout, row->err.status == NQM_OK ? "" : row->err.message);
        putchar('\n');
    }
}

int print_scores(const score_run *run) {
    switch (run->format) {
    case FORMAT_JSON: /* the document contains the remarks */
        return print_json(json_scores(run));
    case FORMAT_CSV:
        print_scores_csv(run);
        break;
    case FORMAT_QUIET:
        print_quiet(run);
        break;
    case FORMAT_TEXT:
        print_text(run);
        break;
    }
    bool bad = fflush(stdout) != 0;
    print_remarks(run);
    return bad ? report("score", EXIT_OPEN, "standard output: cannot write") : EXIT_OK;
}
