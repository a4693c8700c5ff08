/* SPDX-License-Identifier: MIT
 *
 * nqm score - predicts how good approximations look compared with their reference. score_run.c computes the scores,
 * score_print.c prints them.
 */
#include "nqm/score/score.h"

#include <math.h>
#include <stdlib.h>

/* The exit code of the first test without a score; else EXIT_GATE when a JOD is below --fail-under. */
static int settle_exit_code(const score_run *run, double fail_under) {
    for (size_t i = 0; i < run->n_rows; ++i)
        if (run->rows[i].err.status != NQM_OK)
            return exit_code_of(run->rows[i].err.status);
    for (size_t i = 0; i < run->n_rows; ++i)
        if (run->rows[i].result.jod < fail_under)
            return EXIT_GATE;
    return EXIT_OK;
}

static int run_score(score_run *run, const char *model_name, double fail_under) {
    int exit_code = make_scores("score", run, model_name);
    if (exit_code == EXIT_OK) {
        exit_code = print_scores(run);
        for (size_t i = 0; i < run->n_rows; ++i)
            if (run->rows[i].err.status != NQM_OK)
                report_error("score", &run->rows[i].err);
        if (exit_code == EXIT_OK)
            exit_code = settle_exit_code(run, fail_under);
    }
    free_scores(run);
    return exit_code;
}

int cmd_score(int argc, char **argv) {
    bool json = false, csv = false, quiet = false;
    const char *metrics = NULL, *model = "default";
    double fail_under = (double)-INFINITY;
    score_run run = {.options = nqm_score_options_default()};
    const option options[] = {
        {"model", 'm', OPTION_TEXT, &model, "MODEL", "a built-in model's name or a model file", 0, 0},
        {"metrics", 0, OPTION_TEXT, &metrics, "LIST",
         "scalar metrics to add: all, or names with commas (rmse,log_diff)", 0, 0},
        {"fail-under", 0, OPTION_NUMBER, &fail_under, "JOD", "exit with 1 when a score is below this", 0, 10},
        {"json", 0, OPTION_FLAG, &json, NULL, "print JSON", 0, 0},
        {"csv", 0, OPTION_FLAG, &csv, NULL, "print CSV", 0, 0},
        {"quiet", 'q', OPTION_FLAG, &quiet, NULL, "print the JODs only, one a line", 0, 0},
        {0}};
    const command cmd = {
        .name = "score",
        .usage = "REF TEST... [options]",
        .about =
            "Predict how good each TEST looks beside REF, in JOD: 10 is no visible difference, and one less means "
            "that\n"
            "75 % of people see that it is worse. REF and TEST are BRDF files (MERL, RGL, NBRDF), specs or presets.\n"
            "A TEST that cannot be scored does not stop the others; the exit code is that of the first fault.",
        .example = "nqm score sgd:nickel ward:nickel\nnqm score nickel.binary fit1.binary fit2.binary --json\n"
                   "nqm score old.binary new.binary --fail-under 9.5 -q",
        .options = options,
        .table = &nqm_score_option_table,
        .table_target = &run.options,
        .min_arguments = 2,
        .max_arguments = -1,
    };
    int n_arguments, exit_code;
    if (!parse_arguments(&cmd, argc, argv, &n_arguments, &exit_code))
        return exit_code;
    exit_code = choose_result_format("score", json, csv, quiet, &run.format);
    if (exit_code != EXIT_OK)
        return exit_code;
    exit_code = choose_metrics("score", metrics ? metrics : json || csv ? "all" : "", run.metrics);
    if (exit_code != EXIT_OK)
        return exit_code;
    run.ref_name = argv[0];
    run.n_rows = (size_t)n_arguments - 1;
    run.test_names = argv + 1;
    return run_score(&run, model, fail_under);
}
