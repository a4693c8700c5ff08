/* SPDX-License-Identifier: MIT
 *
 * nqm regress - fit the curve from Delta-E ITP to JOD to human scores.
 */
#include "io/io.h"
#include "nqm/tool.h"

/* The numbers of a column; free() them. */
static double *read_column(const char *path, const nqm_csv *csv, const char *name) {
    const int column = nqm_csv_column(csv, name);
    nqm_nearest nearest = nqm_nearest_begin(name);
    for (size_t i = 0; i < nqm_csv_columns(csv); ++i)
        nqm_nearest_add(&nearest, nqm_csv_header(csv, (int)i));
    if (column < 0)
        stop(EXIT_MALFORMED, "%s: the header has no column %s%s", path, name, nearest.advice);
    double *values = allocate(nqm_csv_rows(csv), sizeof *values);
    for (size_t row = 0; row < nqm_csv_rows(csv); ++row)
        must(nqm_csv_number(csv, row, column, &values[row], &fault));
    return values;
}

/* Fit the JOD curve to a CSV with the columns DeltaE and JOD (any order, any case; others are ignored). */
static nqm_regress_report regress_csv(const char *path) {
    nqm_csv *csv;
    nqm_regress_report result;
    must(nqm_csv_load(path, &csv, &fault));
    const size_t n = nqm_csv_rows(csv);
    double *delta_e = read_column(path, csv, "DeltaE"), *jod = read_column(path, csv, "JOD");
    if (n < 4)
        stop(EXIT_INCOMPATIBLE, "%s: %zu rows do not determine the curve, 4 are needed", path, n);
    must(nqm_regress(n, delta_e, jod, &result, &fault));
    free(delta_e);
    free(jod);
    nqm_csv_free(csv);
    return result;
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

/* ---- the verb ---------------------------------------------------------------------------------------------------- */

static bool json;

static const option options[] = {{"json", 0, OPTION_FLAG, &json, NULL, "print JSON", 0, 0}, {0}};

static const command cmd = {
    .usage = "LABELS.csv [options]",
    .about = "Fit the curve from Delta-E ITP to JOD to human scores by least squares (Levenberg-Marquardt, several "
             "starts). LABELS.csv needs a header with the columns DeltaE and JOD, in any order; other columns are "
             "ignored.",
    .example = "nqm regress labels_real.csv --json",
    .options = options,
    .min_arguments = 1,
};

int cmd_regress(int argc, char **argv) {
    parse_arguments(&cmd, argc, argv);
    const nqm_regress_report r = regress_csv(argv[0]);
    if (json)
        return print_document(json_row("b1:f b2:f b3:f rmse:f n:z spearman:f", r.curve.b1, r.curve.b2, r.curve.b3,
                                       r.rmse, r.n, r.spearman));
    print_report_text(&r);
    return EXIT_OK;
}
