/* SPDX-License-Identifier: MIT
 *
 * The results of `nqm fit` as a table, as a report and as JSON (doc/cli.md).
 */
#include "fit/fit.h"
#include "nqm/fit/fit_tool.h"

#include <string.h>

const char *fitted_argument(const fitted *f) {
    if (f->err.status != NQM_OK)
        return NULL;
    return f->fit.spec[0] ? f->fit.spec : f->path[0] ? f->path : NULL;
}

/* The loss of analytic models is an option; the other models have their own. */
static const char *loss_name(const fitted *f, nqm_fit_loss loss) {
    return f->fit.spec[0] ? nqm_fit_loss_words[loss] : "own";
}

static json_t *to_json(const fitted *f, nqm_fit_loss loss) {
    if (f->err.status != NQM_OK)
        return json_pack("{s:n,s:s,s:o}", "spec", "model", f->model, "error", json_name(f->err.message));
    json_t *metrics = json_object();
    for (int m = 0; m < NQM_METRIC_COUNT; ++m)
        json_object_set_new(metrics, nqm_metric_name((nqm_metric)m), json_number(f->metrics[m]));
    const char *argument = fitted_argument(f);
    json_t *row = json_pack("{s:o,s:s,s:s,s:o,s:I,s:I,s:o,s:o}", "spec", argument ? json_name(argument) : json_null(),
                            "model", f->model, "loss_name", loss_name(f, loss), "loss", json_number(f->fit.loss),
                            "numbers", (json_int_t)f->fit.n_numbers, "directions", (json_int_t)f->fit.n_directions,
                            "seconds", json_number(f->seconds), "metrics", metrics);
    if (!argument)
        json_object_set_new(row, "note", json_string("the result is a file: write it with -o FILE"));
    return row;
}

void print_fits_as_json(size_t n, const fitted *f, nqm_fit_loss loss) {
    json_t *results = json_array();
    for (size_t i = 0; i < n; ++i)
        json_array_append_new(results, to_json(&f[i], loss));
    print_document(n == 1 ? json_incref(json_array_get(results, 0)) : json_pack("{s:O}", "results", results));
    json_decref(results);
}

void print_fits_as_table(size_t n, const fitted *f) {
    printf("%-18s %8s %9s %9s  %s\n", "model", "numbers", "loss", "ma_crwe", "spec or file");
    for (size_t i = 0; i < n; ++i) {
        const char *argument = fitted_argument(&f[i]);
        if (f[i].err.status != NQM_OK)
            printf("%-18s %8s %9s %9s  failed\n", f[i].model, "-", "-", "-");
        else
            printf("%-18s %8zu %9.5f %9.5f  %s\n", f[i].model, f[i].fit.n_numbers, f[i].fit.loss,
                   f[i].metrics[NQM_METRIC_MA_CRWE], argument ? argument : "(not written: use -o)");
    }
}

void print_fit_report(size_t n, const fitted *f, nqm_fit_loss loss) {
    for (size_t i = 0; i < n; ++i) {
        const fitted *one = &f[i];
        const char *argument = fitted_argument(one);
        printf("%s%s\n", i ? "\n" : "", one->model);
        if (one->err.status != NQM_OK) {
            printf("  %-10s %s\n", "failed", one->err.message);
            continue;
        }
        printf("  %-10s %s\n", "result", argument ? argument : "(not written: use -o)");
        printf("  %-10s %zu\n", "numbers", one->fit.n_numbers);
        printf("  %-10s %.5f (%s), %zu directions, start %zu, %.2f s\n", "loss", one->fit.loss, loss_name(one, loss),
               one->fit.n_directions, one->fit.best_start, one->seconds);
        for (int m = 0; m < NQM_METRIC_COUNT; ++m)
            printf("  %-10s %.5g\n", nqm_metric_name((nqm_metric)m), one->metrics[m]);
    }
}
