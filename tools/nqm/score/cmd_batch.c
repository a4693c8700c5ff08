/* SPDX-License-Identifier: MIT
 *
 * nqm batch - scores the pairs of a list in the order of the list. batch_print.c formats the rows; batch_output.c
 * writes them, so that an interrupted run can be resumed.
 */
#include "nqm/score/batch.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

typedef struct batch_run {
    const char *list_path, *output, *model_name, *metrics, *root;
    bool keep_going, resume, json, json_lines;
    uint64_t cache_mb;
    nqm_score_options options;
    batch_form form;
    nqm_model *model;
    nqm_pair_list *list;
    nqm_scorer *scorer;
    batch_output *out;
    batch_progress done;
    size_t n_before; /* rows that an earlier run wrote */
    double begin_s;
    nqm_score_result results[NQM_SCORE_BLOCK];
    nqm_error errors[NQM_SCORE_BLOCK];
} batch_run;

static double now_s(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static bool ends_with(const char *text, const char *end) {
    size_t n = strlen(text), n_end = strlen(end);
    return n >= n_end && strcmp(text + n - n_end, end) == 0;
}

static batch_format choose_format(const batch_run *run) {
    if (run->json || run->json_lines)
        return run->json ? BATCH_JSON : BATCH_JSON_LINES;
    if (run->output && (ends_with(run->output, ".jsonl") || ends_with(run->output, ".ndjson")))
        return BATCH_JSON_LINES;
    return run->output && ends_with(run->output, ".json") ? BATCH_JSON : BATCH_CSV;
}

/* Settings that a resumed run must have in common with the interrupted run. */
static json_t *make_terms(const batch_run *run) {
    static const char *const formats[] = {"csv", "jsonl", "json"};
    nqm_model_info info = nqm_model_get_info(run->model);
    return json_pack("{s:s,s:s,s:s,s:s,s:s,s:f,s:s,s:o}", "version of nqm", nqm_version(), "list",
                     nqm_pair_list_sha256(run->list), "model", info.sha256, "format", formats[run->form.format],
                     "--invalid", nqm_invalid_words[run->options.invalid], "--min-valid",
                     run->options.min_valid_fraction, "--precision", nqm_precision_name(run->options.precision),
                     "--metrics", json_name(run->metrics));
}

static int show_speed(const batch_run *run) {
    double seconds = now_s() - run->begin_s;
    size_t n = run->done.n_rows - run->n_before;
    if (n)
        note_progress("%.0f pairs/s", (double)n / seconds);
    return show_progress(NULL, "batch", (double)n, (double)(nqm_pair_list_count(run->list) - run->n_before));
}

/* Write the rows [done, begin + n) of a block that begins at row `begin`; it stops before the first failed row unless
 * --keep-going is given. */
static int write_block(batch_run *run, size_t begin, size_t n) {
    char *text = NULL;
    size_t n_bytes = 0;
    batch_progress done = run->done;
    FILE *stream = open_memstream(&text, &n_bytes);
    if (!stream)
        return report("batch", EXIT_LIMIT, "out of memory");
    for (size_t i = done.n_rows - begin; i < n; ++i) {
        bool failed = run->results[i].status != NQM_OK;
        if (failed && !run->keep_going)
            break;
        print_batch_row(&run->form, stream, begin + i, &run->results[i], &run->errors[i]);
        done.n_failed += failed;
        done.n_rows = begin + i + 1;
    }
    bool bad = ferror(stream) != 0;
    bad = fclose(stream) != 0 || bad;
    int exit_code =
        bad ? report("batch", EXIT_LIMIT, "out of memory") : append_batch_output(run->out, text, n_bytes, &done);
    free(text);
    if (exit_code == EXIT_OK)
        run->done = done;
    return exit_code;
}

/* Blocks begin at the same rows in every run, because the last bits of a score depend on its position in the block. */
static int score_rows(batch_run *run) {
    size_t n_rows = nqm_pair_list_count(run->list);
    size_t begin = run->done.n_rows - run->done.n_rows % NQM_SCORE_BLOCK;
    for (; begin < n_rows; begin += NQM_SCORE_BLOCK) {
        if (show_speed(run) || interrupted())
            return EXIT_INTERRUPTED;
        size_t n = n_rows - begin < NQM_SCORE_BLOCK ? n_rows - begin : NQM_SCORE_BLOCK;
        nqm_error err = {0};
        if (nqm_scorer_run_named(run->scorer, n, nqm_pair_list_pairs(run->list) + begin, run->results, run->errors,
                                 &err) != NQM_OK)
            return report_error("batch", &err);
        int exit_code = write_block(run, begin, n);
        if (exit_code != EXIT_OK)
            return exit_code;
        size_t failed = run->done.n_rows - begin;
        if (failed < n)
            return report("batch", exit_code_of(run->results[failed].status), "row %zu: %s", begin + failed + 1,
                          run->errors[failed].message);
    }
    return EXIT_OK;
}

/* The text before the first row or after the last; free() it. NULL: out of memory. */
static char *frame(const batch_form *form, void (*print)(const batch_form *, FILE *), size_t *n_bytes_ret) {
    char *text = NULL;
    FILE *stream = open_memstream(&text, n_bytes_ret);
    if (!stream)
        return NULL;
    print(form, stream);
    if (fclose(stream) == 0)
        return text;
    free(text);
    return NULL;
}

static int write_head(batch_run *run) {
    size_t n_bytes;
    char *text = frame(&run->form, print_batch_head, &n_bytes);
    if (!text)
        return report("batch", EXIT_LIMIT, "out of memory");
    int exit_code = append_batch_output(run->out, text, n_bytes, &run->done);
    free(text);
    return exit_code;
}

/* Close the output, report how many rows are written or failed, and return the exit code. */
static int settle(batch_run *run, int exit_code) {
    size_t n_rows = nqm_pair_list_count(run->list), n_bytes = 0;
    bool complete = exit_code == EXIT_OK;
    const char *part = batch_output_part(run->out);
    end_progress();
    if (!complete && part)
        report("batch", exit_code, "%zu of %zu rows are in %s; --resume goes on with them", run->done.n_rows, n_rows,
               part);
    char *tail = frame(&run->form, print_batch_tail, &n_bytes);
    bool close_document = complete || !part; /* output to a pipe must be valid JSON even when the run ends early */
    int closed = close_batch_output(run->out, close_document && tail, tail, n_bytes);
    free(tail);
    run->out = NULL;
    if (exit_code == EXIT_OK)
        exit_code = tail ? closed : report("batch", EXIT_LIMIT, "out of memory");
    if (exit_code == EXIT_OK && run->done.n_failed)
        return report("batch", EXIT_PARTIAL, "%zu of %zu rows have no score", run->done.n_failed, n_rows);
    return exit_code;
}

/* Open everything. Paths of list and output are relative to the working folder, paths of BRDFs to --root: the output is
 * opened before chdir(). */
static int open_all(batch_run *run) {
    nqm_error err = {0};
    int exit_code = open_model("batch", run->model_name, &run->model);
    if (exit_code != EXIT_OK)
        return exit_code;
    if (nqm_pair_list_load(run->list_path, &run->list, &err) != NQM_OK ||
        nqm_scorer_create(run->model, &run->options, &run->scorer, &err) != NQM_OK)
        return report_error("batch", &err);
    run->form.list = run->list;
    run->form.model = run->model;
    run->form.precision = run->options.precision;
    run->form.terms =
        (remark_terms){nqm_directions_count(nqm_model_get_info(run->model).directions), run->options.invalid};
    exit_code = check_batch_columns(&run->form);
    if (exit_code != EXIT_OK)
        return exit_code;
    struct stat st;
    if (run->root && (stat(run->root, &st) != 0 || !S_ISDIR(st.st_mode)))
        return report("batch", EXIT_OPEN, "--root: there is no folder '%s'", run->root);
    json_t *terms = make_terms(run);
    exit_code = terms ? open_batch_output(run->output, terms, run->resume, &run->out, &run->done)
                      : report("batch", EXIT_LIMIT, "out of memory");
    json_decref(terms);
    if (exit_code == EXIT_OK && run->root && chdir(run->root) != 0)
        return report("batch", EXIT_OPEN, "--root: '%s' cannot be entered", run->root);
    return exit_code;
}

static int run_batch(batch_run *run) {
    int exit_code = open_all(run);
    if (exit_code == EXIT_OK) {
        run->n_before = run->done.n_rows;
        run->begin_s = now_s();
        exit_code = run->done.begun ? EXIT_OK : write_head(run);
        if (exit_code == EXIT_OK)
            exit_code = score_rows(run);
        exit_code = settle(run, exit_code);
    }
    close_batch_output(run->out, false, NULL, 0);
    nqm_scorer_free(run->scorer);
    nqm_pair_list_free(run->list);
    nqm_model_free(run->model);
    return exit_code;
}

static int check_options(batch_run *run) {
    if (run->json && run->json_lines)
        return report("batch", EXIT_USAGE, "--json and --jsonl exclude each other");
    run->form.format = choose_format(run);
    run->options.cache_bytes = (size_t)run->cache_mb << 20;
    int exit_code = choose_metrics("batch", run->metrics, run->form.metrics);
    run->options.metrics = *run->metrics != 0;
    return exit_code;
}

int cmd_batch(int argc, char **argv) {
    static batch_run run;
    run = (batch_run){.model_name = "default",
                      .metrics = "",
                      .options = nqm_score_options_default(),
                      .cache_mb = nqm_score_options_default().cache_bytes >> 20};
    const option options[] = {
        {"output", 'o', OPTION_TEXT, &run.output, "FILE", "write .csv, .jsonl or .json instead of standard output", 0,
         0},
        {"resume", 0, OPTION_FLAG, &run.resume, NULL, "go on with what a stopped run has left of FILE", 0, 0},
        {"keep-going", 'k', OPTION_FLAG, &run.keep_going, NULL, "rows that fail do not end the run", 0, 0},
        {"model", 'm', OPTION_TEXT, &run.model_name, "MODEL", "a built-in model's name or a model file", 0, 0},
        {"metrics", 0, OPTION_TEXT, &run.metrics, "LIST", "scalar metrics to add: all, or names with commas", 0, 0},
        {"root", 0, OPTION_TEXT, &run.root, "DIR", "folder at which relative paths of the list start", 0, 0},
        {"cache", 0, OPTION_COUNT, &run.cache_mb, "MB", "memory for BRDFs that may come again", 0, 1 << 20},
        {"json", 0, OPTION_FLAG, &run.json, NULL, "write one JSON document", 0, 0},
        {"jsonl", 0, OPTION_FLAG, &run.json_lines, NULL, "write JSON Lines", 0, 0},
        {0}};
    const command cmd = {
        .name = "batch",
        .usage = "LIST [options]",
        .about = "Score the pairs of LIST, in its order: CSV with the columns reference and test, or JSON Lines with\n"
                 "these members, or - for standard input; further columns go along. Results are written while they\n"
                 "are made. The first row that fails ends the run, unless --keep-going. A run that was stopped, by\n"
                 "whatever, goes on under --resume, and ends with the same file.",
        .example =
            "nqm batch pairs.csv -o scores.csv\nnqm batch pairs.csv -o scores.csv --resume --keep-going\n"
            "find fits -name '*.binary' | awk 'BEGIN{print \"reference,test\"} {print \"nickel.binary,\" $0}' |\n"
            "    nqm batch - --jsonl",
        .options = options,
        .table = &nqm_score_option_table,
        .table_target = &run.options,
        .min_arguments = 1,
        .max_arguments = 1,
    };
    int n_arguments, exit_code;
    if (!parse_arguments(&cmd, argc, argv, &n_arguments, &exit_code))
        return exit_code;
    run.list_path = argv[0];
    exit_code = check_options(&run);
    return exit_code == EXIT_OK ? run_batch(&run) : exit_code;
}
