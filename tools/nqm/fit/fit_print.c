/* SPDX-License-Identifier: MIT
 *
 * Results of nqm fit as a table, in full, as JSON, or as arguments of other verbs.
 */
#include "nqm/fit/fit_run.h"

#include <math.h>
#include <stdlib.h>

const char *fitted_argument(const fitted *f) {
    if (f->err.status != NQM_OK)
        return NULL;
    return f->match.fit.spec[0] ? f->match.fit.spec : f->path[0] ? f->path : NULL;
}

/* The loss of analytic models is an option; the other models have their own. */
static const char *loss_name(const fitted *f, const char *loss) {
    return f->match.fit.spec[0] ? loss : "own";
}

/* ---- JSON -------------------------------------------------------------------------------------------------------- */

static json_t *to_json(const fitted *f, const char *loss) {
    if (f->err.status != NQM_OK)
        return json_pack("{s:n,s:s,s:o}", "spec", "model", f->model, "error", json_name(f->err.message));
    const nqm_fit_report *fit = &f->match.fit;
    json_t *metrics = json_object();
    for (int m = 0; m < NQM_METRIC_COUNT; ++m)
        json_object_set_new(metrics, nqm_metric_name((nqm_metric)m), json_number(f->metrics[m]));
    const char *argument = fitted_argument(f);
    json_t *row = json_pack("{s:o,s:s,s:o,s:o,s:I,s:I,s:o,s:o}", "spec", argument ? json_name(argument) : json_null(),
                            "model", f->model, "loss_name", json_name(loss_name(f, loss)), "loss",
                            json_number(fit->loss), "numbers", (json_int_t)fit->n_numbers, "directions",
                            (json_int_t)fit->n_directions, "seconds", json_number(f->seconds), "metrics", metrics);
    json_object_set_new(row, "jod", json_number(f->score.jod));
    json_object_set_new(row, "jod_low", json_number(f->score.jod_low));
    json_object_set_new(row, "jod_high", json_number(f->score.jod_high));
    json_object_set_new(row, "delta_e_itp", json_number(f->score.delta_e));
    if (f->match.selected[0])
        json_object_set_new(row, "selected", json_name(f->match.selected));
    if (!argument)
        json_object_set_new(row, "note", json_string("the result is a file: write it with -o FILE"));
    return row;
}

static void print_fits_as_json(size_t n, const fitted *f, const char *loss) {
    json_t *results = json_array();
    for (size_t i = 0; i < n; ++i)
        json_array_append_new(results, to_json(&f[i], loss));
    print_document(n == 1 ? json_incref(json_array_get(results, 0)) : json_pack("{s:O}", "results", results));
    json_decref(results);
}

/* ---- tables ------------------------------------------------------------------------------------------------------ */

/* Best JOD first, those without one last, otherwise in the order of the models. */
static int compare_fits(const void *a, const void *b) {
    const fitted *const *x = a, *const *y = b;
    double jod_x = (*x)->err.status == NQM_OK ? (*x)->score.jod : (double)NAN;
    double jod_y = (*y)->err.status == NQM_OK ? (*y)->score.jod : (double)NAN;
    if (isnan(jod_x) || isnan(jod_y) || jod_x == jod_y)
        return isnan(jod_x) != isnan(jod_y) ? isnan(jod_x) - isnan(jod_y) : (*x > *y) - (*x < *y);
    return jod_x < jod_y ? 1 : -1;
}

static void print_table_row(const fitted *f, bool calibrated) {
    const scored_pair score = {.result = f->score, .err = {.status = f->score.status}};
    const char *argument = fitted_argument(f);
    printf("%-18s ", f->model);
    if (f->err.status != NQM_OK) {
        printf("%7s  %9s  %5s  failed\n", "-", "-", "-");
        return;
    }
    printf("%7zu  %9.5f", f->match.fit.n_numbers, f->match.fit.loss);
    print_jod(&score, calibrated);
    printf("  %s\n", argument ? shown(argument) : "(not written: use -o)");
}

static void print_verbose(const fitted *f, const char *loss) {
    const nqm_fit_report *fit = &f->match.fit;
    const char *argument = fitted_argument(f);
    puts(f->model);
    if (f->err.status != NQM_OK) {
        printf("  %-10s %s\n", "failed", shown(f->err.message));
        return;
    }
    printf("  %-10s %s\n", "result", argument ? shown(argument) : "(not written: use -o)");
    printf("  %-10s %zu\n", "numbers", fit->n_numbers);
    printf("  %-10s %.5f (%s), %zu directions, start %zu, %.2f s\n", "loss", fit->loss, loss_name(f, loss),
           fit->n_directions, fit->best_start, f->seconds);
    if (f->match.selected[0])
        printf("  %-10s %s\n", "selected", f->match.selected);
    printf("  %-10s %.2f", "JOD", f->score.jod);
    if (!isnan(f->score.jod_low))
        printf(" [%.2f, %.2f]", f->score.jod_low, f->score.jod_high);
    putchar('\n');
    for (int m = 0; m < NQM_METRIC_COUNT; ++m)
        printf("  %-10s %.5g\n", nqm_metric_name((nqm_metric)m), f->metrics[m]);
}

static void print_sorted(size_t n, const fitted *f, bool verbose, const char *loss, bool calibrated) {
    const fitted **order = allocate(n, sizeof *order);
    for (size_t i = 0; i < n; ++i)
        order[i] = &f[i];
    qsort(order, n, sizeof *order, compare_fits);
    if (!verbose)
        printf("%-18s %7s  %9s  %5s%s  spec or file\n", "model", "numbers", "loss", "JOD",
               calibrated ? "  [95 %]        " : "");
    for (size_t i = 0; i < n; ++i) {
        if (verbose && i)
            putchar('\n');
        if (verbose)
            print_verbose(order[i], loss);
        else
            print_table_row(order[i], calibrated);
    }
    free(order);
}

void print_fits(size_t n, const fitted *f, fit_view view, const char *loss, const nqm_model *metric) {
    if (view == FIT_JSON)
        print_fits_as_json(n, f, loss);
    else if (view != FIT_QUIET)
        print_sorted(n, f, view == FIT_VERBOSE, loss, *nqm_model_get_info(metric).calibration);
    for (size_t i = 0; view == FIT_QUIET && i < n; ++i)
        if (fitted_argument(&f[i]))
            puts(fitted_argument(&f[i]));
}
