/* SPDX-License-Identifier: MIT
 *
 * nqm regress - fit the curve from Delta-E ITP to JOD to human scores.
 */
#include "nqm/tool.h"

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
            "starts). LABELS.csv needs a header with the columns DeltaE and JOD, in any order; others are ignored.",
        .example = "nqm regress labels_real.csv --json",
        .options = options,
        .min_arguments = 1,
        .max_arguments = 1,
    };
    int n_arguments, exit_code;
    if (!parse_arguments(&cmd, argc, argv, &n_arguments, &exit_code))
        return exit_code;
    nqm_regress_report regression;
    nqm_error err = {0};
    if (nqm_regress_csv(argv[0], &regression, &err) != NQM_OK)
        return report_error("regress", &err);
    if (json)
        return print_report_json(&regression);
    print_report_text(&regression);
    return EXIT_OK;
}
