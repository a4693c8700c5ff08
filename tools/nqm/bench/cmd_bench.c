/* SPDX-License-Identifier: MIT
 *
 * nqm bench - measures the speed of this build and the limits of the machine.
 */
#include "nqm/bench/bench_print.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct bench_arguments {
    bool json, quick;
    const char *kernels, *precision, *recipe, *output;
    const char *model;
    uint64_t rounds, epochs, seeds;
    size_t n_files;
    const char *const *files;
} bench_arguments;

static const choice precisions[] = {
    {"f32", NQM_PRECISION_F32}, {"bf16", NQM_PRECISION_BF16}, {"int8", NQM_PRECISION_INT8}, {0}};

/* A benchmark with the selected kernels. */
typedef nqm_status run_fn(nqm_bench *bench, const bench_arguments *a, nqm_error *err);

static nqm_status run_gemm(nqm_bench *bench, const bench_arguments *a, nqm_error *err) {
    (void)a;
    return nqm_bench_gemm(bench, err);
}

static nqm_status run_train(nqm_bench *bench, const bench_arguments *a, nqm_error *err) {
    return nqm_bench_train(bench, a->recipe, (size_t)a->epochs, (size_t)a->seeds, err);
}

/* Time whole commands: the start of the program, and a first score. */
static nqm_status run_commands(nqm_bench *bench, nqm_error *err) {
    char self[4096];
    ssize_t n = readlink("/proc/self/exe", self, sizeof self - 1);
    if (n < 0) /* a system without this path */
        return NQM_OK;
    self[n] = '\0';
    const char *version[] = {self, "--version", NULL};
    const char *score[] = {self, "score", "sgd:nickel", "ward:nickel", "-q", NULL};
    nqm_status status = nqm_bench_command(bench, "nqm --version", version, err);
    return status == NQM_OK ? nqm_bench_command(bench, "nqm score sgd:nickel ward:nickel", score, err) : status;
}

static nqm_status run_score(nqm_bench *bench, const bench_arguments *a, nqm_error *err) {
    nqm_status status = NQM_OK;
    for (size_t i = 0; i < (a->model ? 1 : nqm_model_builtin_count()) && status == NQM_OK; ++i) {
        nqm_model *model;
        if (a->model && strchr(a->model, '.'))
            status = nqm_model_load(a->model, &model, err);
        else
            status = nqm_model_builtin(a->model ? a->model : nqm_model_builtin_name(i), &model, err);
        if (status == NQM_OK)
            status = nqm_bench_score(bench, model, err);
        nqm_model_free(model);
    }
    return status;
}

static nqm_status run_load(nqm_bench *bench, const bench_arguments *a, nqm_error *err) {
    const char *folder = getenv("TMPDIR");
    nqm_directions *directions;
    nqm_status status = nqm_directions_create(NULL, 0, NULL, &directions, err);
    if (status != NQM_OK)
        return status;
    status = nqm_bench_load(bench, directions, folder && *folder ? folder : "/tmp", a->n_files, a->files, err);
    nqm_directions_free(directions);
    return status == NQM_OK ? run_commands(bench, err) : status;
}

static const struct {
    const char *name;
    run_fn *run;
} benches[] = {{"gemm", run_gemm}, {"train", run_train}, {"score", run_score}, {"load", run_load}};
enum { N_BENCHES = sizeof benches / sizeof *benches };

/* Run with the best kernels, with those called a->kernels, or with "all" except the scalar ones, which take minutes. */
static nqm_status run_with_kernels(nqm_bench *bench, const bench_arguments *a, run_fn *run, nqm_error *err) {
    nqm_status status = NQM_OK;
    if (!a->kernels || strcmp(a->kernels, "all") != 0) {
        status = nqm_kernels_select(a->kernels, err);
        return status == NQM_OK ? run(bench, a, err) : status;
    }
    for (size_t i = 0; nqm_kernels_name(i) && status == NQM_OK; ++i) {
        if (strcmp(nqm_kernels_name(i), "scalar") == 0)
            continue;
        status = nqm_kernels_select(nqm_kernels_name(i), err);
        if (status == NQM_OK)
            status = run(bench, a, err);
    }
    return status == NQM_OK ? nqm_kernels_select(NULL, err) : status;
}

static int set_options(const bench_arguments *a, nqm_bench_options *options) {
    *options = nqm_bench_options_default();
    options->progress = show_progress;
    options->rounds = (size_t)a->rounds;
    options->quick = a->quick;
    if (a->quick) {
        options->rounds = 2;
        options->round_s = 0.001;
        options->memory_mb = 16;
    }
    int precision;
    if (a->precision) {
        if (choose("bench", "precision", precisions, a->precision, &precision) != EXIT_OK)
            return EXIT_USAGE;
        options->precisions = 1U << precision;
    }
    return EXIT_OK;
}

/* Print JSON or tables to standard output, and write JSON to `output` if it is open. */
static int print_rows(const nqm_bench *bench, const bench_arguments *a, output_file *output) {
    if (output->stream) {
        json_t *json = bench_json(bench);
        bool bad = !json || json_dumpf(json, output->stream, JSON_INDENT(2) | JSON_REAL_PRECISION(9)) != 0;
        json_decref(json);
        if (bad)
            return report("bench", EXIT_OPEN, "%s: cannot write", a->output);
        fputc('\n', output->stream);
    }
    if (a->json)
        return print_json(bench_json(bench));
    print_bench_tables(bench);
    return EXIT_OK;
}

/* which: name of the benchmark; NULL: all. */
static int run_benches(const bench_arguments *a, const char *which) {
    nqm_bench_options options;
    nqm_bench *bench = NULL;
    nqm_error err = {0};
    output_file output = {0};
    int exit_code = set_options(a, &options);
    if (exit_code == EXIT_OK && a->output)
        exit_code = open_output("bench", a->output, &output);
    if (exit_code != EXIT_OK)
        return exit_code;
    nqm_status status = nqm_bench_create(&options, &bench, &err);
    for (size_t i = 0; i < N_BENCHES && status == NQM_OK; ++i)
        if (!which || strcmp(which, benches[i].name) == 0)
            status = run_with_kernels(bench, a, benches[i].run, &err);
    if (status == NQM_OK)
        status = nqm_bench_finish(bench, &err);
    if (status != NQM_OK)
        exit_code = report_error("bench", &err);
    else
        exit_code = print_rows(bench, a, &output);
    int closed = close_output("bench", &output, exit_code == EXIT_OK);
    if (exit_code == EXIT_OK)
        exit_code = closed;
    nqm_bench_free(bench);
    return exit_code;
}

int cmd_bench(int argc, char **argv) {
    bench_arguments a = {.recipe = "paper", .rounds = 7, .seeds = 1};
    const option options[] = {
        {"json", 0, OPTION_FLAG, &a.json, NULL, "print JSON", 0, 0},
        {"output", 'o', OPTION_TEXT, &a.output, "FILE", "also write the JSON to a file", 0, 0},
        {"precision", 0, OPTION_TEXT, &a.precision, "P", "f32, bf16 or int8 [default: all]", 0, 0},
        {"kernels", 0, OPTION_TEXT, &a.kernels, "NAME",
         "kernels by name, or `all` except `scalar`, which is slow [default: the best]", 0, 0},
        {"rounds", 0, OPTION_COUNT, &a.rounds, "N", "timings of each result", 1, 1000},
        {"recipe", 0, OPTION_TEXT, &a.recipe, "NAME", "train: paper, notebook or nqm", 0, 0},
        {"epochs", 0, OPTION_COUNT, &a.epochs, "N", "train: epochs, instead of the recipe's", 1, 10000},
        {"seeds", 0, OPTION_COUNT, &a.seeds, "N", "train: repeat with seeds 1 to N", 1, 100},
        {"model", 0, OPTION_TEXT, &a.model, "MODEL", "score: a built-in model or a file [default: all built-in ones]",
         0, 0},
        {"quick", 0, OPTION_FLAG, &a.quick, NULL, "fewer and smaller problems: tests the benchmarks, does not measure",
         0, 0},
        {0}};
    const command cmd = {
        .name = "bench",
        .usage = "[gemm | train | score | load [FILE...]] [options]",
        .about =
            "Measure this build together with the peaks of the machine's arithmetic and memory, which are sampled\n"
            "between the timings. Without a name, run all benchmarks.\n"
            "  gemm     the matrix products of the networks, and oneDNN's\n"
            "  train    a training of the paper's size, on generated pairs\n"
            "  score    the network, and samples to JOD, for 1 to 512 pairs in each precision\n"
            "  load     files to samples, with a MERL table, and the start of this program\n"
            "Each result is the best of several rounds. Other programs make rounds longer, which the medians show.",
        .example = "nqm bench gemm\nnqm bench gemm --kernels all --json\nnqm bench train --precision bf16\n"
                   "nqm bench train --recipe nqm --epochs 5\n"
                   "nqm bench score --model default --json\nnqm bench load measured.bsdf network.h5",
        .options = options,
        .min_arguments = 0,
        .max_arguments = -1,
    };
    int n_arguments, exit_code;
    if (!parse_arguments(&cmd, argc, argv, &n_arguments, &exit_code))
        return exit_code;
    if (n_arguments > 1 && strcmp(argv[0], "load") != 0)
        return report("bench", EXIT_USAGE, "%s: only `load` has file arguments", argv[1]);
    a.n_files = n_arguments > 1 ? (size_t)n_arguments - 1 : 0;
    a.files = (const char *const *)argv + 1;
    for (size_t i = 0; i < N_BENCHES; ++i)
        if (n_arguments == 0 || strcmp(argv[0], benches[i].name) == 0)
            return run_benches(&a, n_arguments ? argv[0] : NULL);
    return report("bench", EXIT_USAGE, "there is no benchmark '%s'; choose gemm, train, score or load", argv[0]);
}
