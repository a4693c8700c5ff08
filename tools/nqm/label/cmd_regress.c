/* SPDX-License-Identifier: MIT
 *
 * nqm regress - fit the curve from Delta-E ITP to JOD to human scores.
 */
#include "io/io.h"
#include "nqm/tool.h"

#include <stdlib.h>

static nqm_status read_column(const nqm_csv *csv, const char *path, const char *name, double *value, nqm_error *err) {
    int column = nqm_csv_column(csv, name);
    if (column < 0)
        return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: the header has no column %s", path, name);
    nqm_status status = NQM_OK;
    for (size_t row = 0; status == NQM_OK && row < nqm_csv_rows(csv); ++row)
        status = nqm_csv_number(csv, row, column, &value[row], err);
    return status;
}

int regress_csv(const char *verb, const char *path, nqm_regress_report *report_ret) {
    nqm_error err = {0};
    nqm_csv *csv;
    nqm_status status = nqm_csv_load(path, &csv, &err);
    if (status != NQM_OK)
        return report_error(verb, &err);
    size_t n = nqm_csv_rows(csv);
    double *values = calloc(n + 1, 2 * sizeof *values);
    if (!values)
        status = nqm_fail_nomem(&err, n * 2 * sizeof *values);
    else if (n < 4)
        status =
            nqm_fail(&err, NQM_ERR_INCOMPATIBLE, -1, "%s: %zu rows do not determine the curve, 4 are needed", path, n);
    if (status == NQM_OK)
        status = read_column(csv, path, "DeltaE", values, &err);
    if (status == NQM_OK)
        status = read_column(csv, path, "JOD", values + n, &err);
    if (status == NQM_OK)
        status = nqm_regress(n, values, values + n, report_ret, &err);
    free(values);
    nqm_csv_free(csv);
    return status == NQM_OK ? EXIT_OK : report_error(verb, &err);
}

static int print_report_json(const nqm_regress_report *r) {
    json_t *root = json_pack("{s:i,s:o}", "schema", 1, "tool", json_tool());
    json_object_set_new(root, "b1", json_number(r->curve.b1));
    json_object_set_new(root, "b2", json_number(r->curve.b2));
    json_object_set_new(root, "b3", json_number(r->curve.b3));
    json_object_set_new(root, "rmse", json_number(r->rmse));
    json_object_set_new(root, "n", json_integer((json_int_t)r->n));
    json_object_set_new(root, "spearman", json_number(r->spearman));
    return print_json(root);
}

static void print_report_text(const nqm_regress_report *r) {
    printf("JOD = 10 (1 - 1 / (1 + exp(b1 (-(dE^b3) - b2))))\n\n");
    printf("  b1        %10.5f\n  b2        %10.5f\n  b3        %10.5f\n", r->curve.b1, r->curve.b2, r->curve.b3);
    printf("  RMSE      %10.4f  JOD, over %zu scores\n", r->rmse, r->n);
    printf("  Spearman  %10.4f  of Delta-E with JOD\n\n", r->spearman);
    printf("  Delta-E   JOD by the curve\n");
    static const double delta_e[] = {1, 2, 5, 10, 20, 50, 100};
    for (size_t i = 0; i < sizeof delta_e / sizeof *delta_e; ++i)
        printf("  %7g   %5.2f\n", delta_e[i], nqm_curve_jod(&r->curve, delta_e[i]));
}

int cmd_regress(int argc, char **argv) {
    bool json = false;
    const option options[] = {
        {.name = "json", .kind = OPTION_FLAG, .target = &json, .help = "print the result as JSON"}, {0}};
    const command cmd = {
        .name = "regress",
        .usage = "LABELS.csv [options]",
        .about =
            "Fit the curve from Delta-E ITP to JOD to human scores by least squares (Levenberg-Marquardt, several\n"
            "starts). LABELS.csv needs a header with the columns DeltaE and JOD, in any order; other columns are "
            "ignored.",
        .example = "nqm regress labels_real.csv --json",
        .options = options,
        .min_arguments = 1,
        .max_arguments = 1,
    };
    int n_arguments, exit_code;
    if (!parse_arguments(&cmd, argc, argv, &n_arguments, &exit_code))
        return exit_code;
    nqm_regress_report regression;
    exit_code = regress_csv("regress", argv[0], &regression);
    if (exit_code != EXIT_OK)
        return exit_code;
    if (json)
        return print_report_json(&regression);
    print_report_text(&regression);
    return EXIT_OK;
}
