/* SPDX-License-Identifier: MIT
 *
 * nqm bench - measures the speed of this build and the limits of the machine.
 */
#include "nqm/bench/bench_print.h"

#include <stdlib.h>
#include <string.h>

typedef nqm_status run_fn(nqm_bench *bench, nqm_error *err);

static run_fn *const benches[] = {nqm_bench_gemm, nqm_bench_train, nqm_bench_score, nqm_bench_load};
enum { N_BENCHES = sizeof benches / sizeof *benches, LOAD = N_BENCHES - 1 };

/* Run with the best kernels, with those named, or with "all" except the scalar ones, which take minutes. */
static void run_with_kernels(nqm_bench *bench, run_fn *run) {
    const char *kernels = bench->options.kernels;
    const bool all = kernels && strcmp(kernels, "all") == 0;
    nqm_error err = {0};
    for (size_t i = 0; all ? nqm_kernels_name(i) != NULL : i == 0; ++i) {
        const char *name = all ? nqm_kernels_name(i) : kernels;
        if (all && strcmp(name, "scalar") == 0)
            continue;
        must(nqm_kernels_select(name, &err), &err);
        must(run(bench, &err), &err);
    }
    if (all)
        must(nqm_kernels_select(NULL, &err), &err);
}

/* Print JSON or tables to standard output, and write JSON to `output` if it is open. */
static void print_rows(const nqm_bench *bench, bool json, const char *path, output_file *output) {
    json_t *results = bench_json(bench);
    if (output->stream) {
        if (!results || json_dumpf(results, output->stream, JSON_INDENT(2) | JSON_REAL_PRECISION(9)) != 0)
            stop(EXIT_OPEN, "%s: cannot write", path);
        fputc('\n', output->stream);
    }
    if (json) {
        print_json(results);
        return;
    }
    print_bench_tables(bench, json_object_get(results, "machine"));
    json_decref(results);
}

/* Run the benchmark with the index `which`; N_BENCHES: all. */
static int run_benches(const nqm_bench_options *options, size_t which, bool json, const char *path) {
    nqm_bench *bench = NULL;
    nqm_error err = {0};
    output_file output = {0};
    if (path)
        open_output(path, &output);
    must(nqm_bench_create(options, &bench, &err), &err);
    for (size_t i = 0; i < N_BENCHES; ++i)
        if (which == N_BENCHES || which == i)
            run_with_kernels(bench, benches[i]);
    must(nqm_bench_finish(bench, &err), &err);
    print_rows(bench, json, path, &output);
    close_output(&output);
    nqm_bench_free(bench);
    return EXIT_OK;
}

/* ---- the verb ---------------------------------------------------------------------------------------------------- */

static nqm_bench_options o;
static const char *output, *folder;
static uint64_t epochs;
static bool json;

static const option options[] = {
    {"json", 0, OPTION_FLAG, &json, NULL, "print JSON", 0, 0},
    {"output", 'o', OPTION_TEXT, &output, "FILE.json", "also write the JSON to a file", 0, 0},
    {"epochs", 0, OPTION_COUNT, &epochs, "N", "train: epochs, instead of the recipe's", 1, 10000},
    {0}};
static const choice choices[] = {
    {"gemm", "", "the matrix products of the networks, and oneDNN's"},
    {"train", "", "a training of the paper's size, on generated pairs"},
    {"score", "", "the network, and samples to JOD, for 1 to 512 pairs"},
    {"load", "[FILE...]", "files to samples, with a MERL table, and the start of this program"},
    {0}};

static const command cmd = {
    .usage = "[gemm | train | score | load [FILE...]] [options]",
    .about = "Measure this build together with the peaks of the machine's arithmetic and memory, which are sampled\n"
             "between the timings. Each result is the best of several rounds. Other programs make rounds longer, which "
             "the\n"
             "medians show. Without a name, run all benchmarks:",
    .example = "nqm bench gemm\nnqm bench gemm --kernels all --json\nnqm bench train --precision bf16\n"
               "nqm bench train --recipe nqm --epochs 5\n"
               "nqm bench score --model default --json\nnqm bench load measured.bsdf network.h5",
    .options = options,
    .choices = choices,
    .table = &nqm_bench_option_table,
    .table_target = &o,
    .max_arguments = -1,
};

int cmd_bench(int argc, char **argv) {
    o = nqm_bench_options_default();
    folder = getenv("TMPDIR");
    const int n_arguments = parse_arguments(&cmd, argc, argv);
    const size_t which = n_arguments ? choose_first(&cmd, argv[0]) : N_BENCHES;
    if (n_arguments > 1 && which != LOAD)
        stop(EXIT_USAGE, "%s: only `load` has file arguments", argv[1]);
    o.epochs = (size_t)epochs;
    o.temporary = folder && *folder ? folder : "/tmp";
    o.n_files = n_arguments > 1 ? (size_t)n_arguments - 1 : 0;
    o.files = (const char *const *)argv + 1;
    o.progress = show_progress;
    return run_benches(&o, which, json, output);
}
