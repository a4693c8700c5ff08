/* SPDX-License-Identifier: MIT
 *
 * nqm batch - scores the pairs of a list in the order of the list. batch_print.c formats the rows; batch_output.c
 * writes them, so that an interrupted run can be resumed.
 */
#include "nqm/score/batch.h"

#include <stdlib.h>
#include <string.h>

typedef struct batch_run {
    nqm_score_options options;
    batch_form form;
    nqm_pair_list *list;
    nqm_scorer *scorer;
    batch_output out;
    bool keep_going;
    size_t n_before; /* rows that an earlier run wrote */
    double begin_s;
    nqm_score_result results[NQM_SCORE_BLOCK];
    nqm_error errors[NQM_SCORE_BLOCK];
} batch_run;

static bool ends_with(const char *text, const char *end) {
    size_t n = strlen(text), n_end = strlen(end);
    return n >= n_end && strcmp(text + n - n_end, end) == 0;
}

static batch_format choose_format(bool json, bool json_lines, const char *output) {
    if (json && json_lines)
        stop(EXIT_USAGE, "--json and --jsonl exclude each other");
    if (json || json_lines)
        return json ? BATCH_JSON : BATCH_JSON_LINES;
    if (output && (ends_with(output, ".jsonl") || ends_with(output, ".ndjson")))
        return BATCH_JSON_LINES;
    return output && ends_with(output, ".json") ? BATCH_JSON : BATCH_CSV;
}

/* Settings that a resumed run must have in common with the interrupted run. */
static json_t *make_terms(const batch_run *run, const char *metrics, const char *root) {
    static const char *const formats[] = {"csv", "jsonl", "json"};
    nqm_model_info info = nqm_model_get_info(run->form.model);
    char *folder = realpath(root ? root : ".", NULL);
    json_t *terms =
        json_pack("{s:s,s:s,s:s,s:s,s:o,s:s,s:f,s:s,s:o}", "version of nqm", nqm_version(), "list", run->list->sha256,
                  "model", info.sha256, "format", formats[run->form.format], "--root", json_name(folder ? folder : ""),
                  "--invalid", nqm_invalid_words[run->options.invalid], "--min-valid", run->options.min_valid_fraction,
                  "--precision", nqm_precision_name(run->options.precision), "--metrics", json_name(metrics));
    free(folder);
    return terms;
}

static int show_speed(const batch_run *run) {
    size_t n = run->out.done.n_rows - run->n_before;
    if (n)
        note_progress("%.0f pairs/s", (double)n / (nqm_clock_s() - run->begin_s));
    return show_progress(NULL, "batch", (double)n, (double)(run->list->n_rows - run->n_before));
}

/* Write the n rows of a block that begins at row `begin`, or those before the first failed row unless --keep-going is
 * given. */
static void write_block(batch_run *run, size_t begin, size_t n) {
    batch_progress done = run->out.done;
    for (size_t i = 0; i < n && (run->keep_going || run->results[i].status == NQM_OK); ++i) {
        print_batch_row(&run->form, run->out.rows, begin + i, &run->results[i], &run->errors[i]);
        done.n_failed += run->results[i].status != NQM_OK;
        ++done.n_rows;
    }
    append_batch_output(&run->out, &done);
}

static int score_rows(batch_run *run) {
    const size_t n_rows = run->list->n_rows;
    while (run->out.done.n_rows < n_rows) {
        if (show_speed(run) || interrupted())
            return EXIT_INTERRUPTED;
        const size_t begin = run->out.done.n_rows, n = nqm_smaller(n_rows - begin, NQM_SCORE_BLOCK);
        nqm_error err = {0};
        if (nqm_scorer_run_named(run->scorer, n, run->list->pair + begin, run->results, run->errors, &err) != NQM_OK)
            return report_error(&err);
        write_block(run, begin, n);
        const size_t failed = run->out.done.n_rows - begin;
        if (failed < n)
            return report(exit_code_of(run->results[failed].status), "row %zu: %s", begin + failed + 1,
                          run->errors[failed].message);
    }
    return EXIT_OK;
}

/* Close the output, report how many rows are written or failed, and return the exit code. */
static int settle(batch_run *run, int exit_code) {
    const batch_progress done = run->out.done;
    end_progress();
    if (exit_code != EXIT_OK && run->out.part)
        report(exit_code, "%zu of %zu rows are in %s; --resume continues with them", done.n_rows, run->list->n_rows,
               run->out.part);
    print_batch_tail(&run->form, run->out.rows);
    bool is_complete = exit_code == EXIT_OK || !run->out.part; /* a pipe gets valid JSON even when the run ends early */
    close_batch_output(&run->out, is_complete);
    if (exit_code == EXIT_OK && done.n_failed)
        return report(EXIT_PARTIAL, "%zu of %zu rows have no score", done.n_failed, run->list->n_rows);
    return exit_code;
}

int cmd_batch(int argc, char **argv) {
    static batch_run run;
    const char *output = NULL, *model_name = "default", *metrics = "", *root = NULL;
    bool resume = false, json = false, json_lines = false;
    nqm_error err = {0};
    run.options = nqm_score_options_default();
    uint64_t cache_mb = run.options.cache_bytes >> 20;
    const option options[] = {
        {"output", 'o', OPTION_TEXT, &output, "FILE", "write .csv, .jsonl or .json instead of standard output", 0, 0},
        {"resume", 0, OPTION_FLAG, &resume, NULL, "continue what a stopped run has left of FILE", 0, 0},
        {"keep-going", 'k', OPTION_FLAG, &run.keep_going, NULL, "rows that fail do not end the run", 0, 0},
        OPTION_ROWS_MODEL(&model_name),
        {"metrics", 0, OPTION_TEXT, &metrics, "LIST", "scalar metrics to add: all, or names with commas", 0, 0},
        {"root", 0, OPTION_TEXT, &root, "DIR", "folder of relative paths in the list (default: the list's folder)", 0,
         0},
        {"cache", 0, OPTION_COUNT, &cache_mb, "MB", "memory for BRDFs that may be needed again", 0, 1 << 20},
        {"json", 0, OPTION_FLAG, &json, NULL, "write one JSON document", 0, 0},
        {"jsonl", 0, OPTION_FLAG, &json_lines, NULL, "write JSON Lines", 0, 0},
        {0}};
    const command cmd = {
        .usage = "LIST [options]",
        .about = "Score the pairs of LIST, in its order: CSV with the columns reference and test, or JSON Lines with\n"
                 "these members, or - for standard input; further columns are copied. Results are written\n"
                 "while they are made. The first row that fails ends the run, unless --keep-going is given. --resume\n"
                 "continues a run that was stopped, for whatever reason; the file is the same in the end.",
        .example =
            "nqm batch pairs.csv -o scores.csv\nnqm batch pairs.csv -o scores.csv --resume --keep-going\n"
            "find fits -name '*.binary' | awk 'BEGIN{print \"reference,test\"} {print \"nickel.binary,\" $0}' |\n"
            "    nqm batch - --jsonl",
        .options = options,
        .table = &nqm_score_option_table,
        .table_target = &run.options,
        .min_arguments = 1,
    };
    parse_arguments(&cmd, argc, argv);
    run.form.format = choose_format(json, json_lines, output);
    run.options.cache_bytes = (size_t)cache_mb << 20;
    choose_metrics(metrics, run.form.metrics);
    run.options.metrics = *metrics != 0;
    nqm_model *model = open_model(model_name);
    must(nqm_pair_list_load(argv[0], &run.list, &err), &err);
    must(nqm_scorer_create(model, &run.options, &run.scorer, &err), &err);
    run.form.list = run.list;
    run.form.model = model;
    run.form.precision = run.options.precision;
    run.form.terms = (remark_terms){nqm_directions_count(nqm_model_get_info(model).directions), run.options.invalid};
    check_batch_columns(&run.form);
    root = list_root(root, argv[0]);
    /* Paths of list and output are relative to the working folder, paths of BRDFs to the root. */
    json_t *terms = make_terms(&run, metrics, root);
    open_batch_output(output, terms, resume, &run.out);
    json_decref(terms);
    enter_list_root(root, argv[0]);
    run.n_before = run.out.done.n_rows;
    run.begin_s = nqm_clock_s();
    if (!run.out.done.begun) {
        print_batch_head(&run.form, run.out.rows);
        append_batch_output(&run.out, &run.out.done);
    }
    const int exit_code = settle(&run, score_rows(&run));
    nqm_scorer_free(run.scorer);
    nqm_pair_list_free(run.list);
    nqm_model_free(model);
    return exit_code;
}
