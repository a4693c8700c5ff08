/* SPDX-License-Identifier: MIT
 *
 * nqm rank - sorts approximations by their JOD. rank.c sorts and prints.
 */
#include "nqm/score/rank.h"

#include <stdlib.h>
#include <unistd.h>

typedef struct rank_run {
    const char *model_name, *list_path, *root;
    nqm_score_options options;
    ranking ranking;
    nqm_model *model;
    nqm_pair_list *list;
    nqm_scorer *scorer;
    nqm_named_pair *pairs; /* (n) in the order of the arguments, like results and errors */
    nqm_score_result *results;
    nqm_error *errors;
} rank_run;

/* Score in blocks, so that Ctrl-C is noticed between them. */
static int score_pairs(rank_run *run, size_t n) {
    nqm_error err = {0};
    for (size_t begin = 0; begin < n; begin += NQM_SCORE_BLOCK) {
        if (show_progress(NULL, "rank", (double)begin, (double)n))
            return EXIT_INTERRUPTED;
        size_t n_now = n - begin < NQM_SCORE_BLOCK ? n - begin : NQM_SCORE_BLOCK;
        if (nqm_scorer_run_named(run->scorer, n_now, run->pairs + begin, run->results + begin, run->errors + begin,
                                 &err) != NQM_OK)
            return report_error("rank", &err);
    }
    end_progress();
    return interrupted() ? EXIT_INTERRUPTED : EXIT_OK;
}

/* Report the errors of tests without a score, in the order of the arguments. Returns the exit code of the first. */
static int report_faults(const rank_run *run, size_t n) {
    int exit_code = EXIT_OK;
    for (size_t i = 0; i < n; ++i)
        if (run->results[i].status != NQM_OK) {
            nqm_error err = run->errors[i];
            err.status = run->results[i].status;
            int code = report_error("rank", &err);
            exit_code = exit_code == EXIT_OK ? code : exit_code;
        }
    return exit_code;
}

static int rank_pairs(rank_run *run, size_t n) {
    ranking *r = &run->ranking;
    r->model = run->model;
    r->precision = run->options.precision;
    r->n_rows = n;
    r->rows = calloc(n + 1, sizeof *r->rows);
    run->results = calloc(n + 1, sizeof *run->results);
    run->errors = calloc(n + 1, sizeof *run->errors);
    if (!r->rows || !run->results || !run->errors)
        return report("rank", EXIT_LIMIT, "out of memory");
    int exit_code = score_pairs(run, n);
    if (exit_code != EXIT_OK)
        return exit_code;
    for (size_t i = 0; i < n; ++i)
        r->rows[i] = (rank_row){.order = i, .pair = run->pairs[i], .result = run->results[i], .err = &run->errors[i]};
    rank_rows(r);
    exit_code = print_ranking(r);
    return exit_code == EXIT_OK ? report_faults(run, n) : exit_code;
}

/* Take the pairs from the arguments REF TEST..., or from the list. */
static int gather_pairs(rank_run *run, int n_arguments, char **arguments, size_t *n_ret) {
    nqm_error err = {0};
    if (run->list_path && nqm_pair_list_load(input_path(run->list_path), &run->list, &err) != NQM_OK)
        return report_error("rank", &err);
    size_t n = run->list ? nqm_pair_list_count(run->list) : (size_t)n_arguments - 1;
    run->pairs = calloc(n + 1, sizeof *run->pairs);
    if (!run->pairs)
        return report("rank", EXIT_LIMIT, "out of memory");
    for (size_t i = 0; i < n; ++i)
        run->pairs[i] =
            run->list ? nqm_pair_list_pairs(run->list)[i] : (nqm_named_pair){arguments[0], arguments[i + 1]};
    *n_ret = n;
    return EXIT_OK;
}

static int run_rank(rank_run *run, int n_arguments, char **arguments) {
    nqm_error err = {0};
    size_t n = 0;
    int exit_code = open_model("rank", run->model_name, &run->model);
    if (exit_code == EXIT_OK && nqm_scorer_create(run->model, &run->options, &run->scorer, &err) != NQM_OK)
        exit_code = report_error("rank", &err);
    if (exit_code == EXIT_OK)
        exit_code = gather_pairs(run, n_arguments, arguments, &n);
    if (exit_code == EXIT_OK && run->root && chdir(run->root) != 0)
        exit_code = report("rank", EXIT_OPEN, "--root: there is no folder '%s'", run->root);
    if (exit_code == EXIT_OK)
        exit_code = rank_pairs(run, n);
    free(run->ranking.rows);
    free(run->pairs);
    free(run->results);
    free(run->errors);
    nqm_scorer_free(run->scorer);
    nqm_pair_list_free(run->list);
    nqm_model_free(run->model);
    return exit_code;
}

int cmd_rank(int argc, char **argv) {
    bool json = false, csv = false, quiet = false;
    rank_run run = {.model_name = "default", .options = nqm_score_options_default()};
    run.options.metrics = 0;
    const option options[] = {
        {"list", 'l', OPTION_TEXT, &run.list_path, "LIST", "pairs from a list as `nqm batch` takes it, - for stdin", 0,
         0},
        {"model", 'm', OPTION_TEXT, &run.model_name, "MODEL", "a built-in model's name or a model file", 0, 0},
        {"root", 0, OPTION_TEXT, &run.root, "DIR", "folder at which relative paths of BRDFs start", 0, 0},
        {"json", 0, OPTION_FLAG, &json, NULL, "print JSON", 0, 0},
        {"csv", 0, OPTION_FLAG, &csv, NULL, "print CSV", 0, 0},
        {"quiet", 'q', OPTION_FLAG, &quiet, NULL, "print the names only, best first", 0, 0},
        {0}};
    const command cmd = {
        .name = "rank",
        .usage = "REF TEST... | --list LIST [options]",
        .about = "Order approximations of a reference by their JOD, best first, and say how many people would prefer\n"
                 "each to the next, and the best to each. Scores within 0.0001 JOD share a rank. A list may hold\n"
                 "several references: each gets a ranking of its own.",
        .example = "nqm rank sgd:nickel ward:nickel 'perturb:gloss=0.9;of=sgd:nickel'\nnqm rank nickel.binary "
                   "fits/*.binary -q | head -1",
        .options = options,
        .table = &nqm_score_option_table,
        .table_target = &run.options,
        .min_arguments = 0,
        .max_arguments = -1,
    };
    int n_arguments, exit_code;
    if (!parse_arguments(&cmd, argc, argv, &n_arguments, &exit_code))
        return exit_code;
    exit_code = choose_result_format("rank", json, csv, quiet, &run.ranking.format);
    if (exit_code != EXIT_OK)
        return exit_code;
    if (run.list_path ? n_arguments > 0 : n_arguments < 2)
        return report("rank", EXIT_USAGE, "give a reference and its tests, or --list LIST");
    return run_rank(&run, n_arguments, argv);
}
