/* SPDX-License-Identifier: MIT
 *
 * nqm-bench - measures the speed of this build and the limits of the machine. Not installed.
 */
#include "bench/bench.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

static const char usage[] =
    "usage: nqm-bench [gemm | train | score | load FILE...] [options]\n\n"
    "Measure this build together with the peaks of the machine's arithmetic and memory, which are sampled between the\n"
    "timings. Each result is the best of several rounds. Other programs make rounds longer, which the medians show.\n"
    "Without a name, run all benchmarks:\n\n"
    "  gemm   the forward matrix products of the networks\n"
    "  train  a training of the paper's size, on generated pairs\n"
    "  score  the network, and samples to JOD, for 1 to 512 pairs\n"
    "  load   files to samples\n\n"
    "  --json            print JSON\n"
    "  -o FILE.json      also write the JSON to a file\n";

static const struct {
    const char *name;
    nqm_bench_fn *run;
} benches[] = {
    {"gemm", nqm_bench_gemm}, {"train", nqm_bench_train}, {"score", nqm_bench_score}, {"load", nqm_bench_load}};
enum { N_BENCHES = sizeof benches / sizeof *benches, LOAD = N_BENCHES - 1 };
enum { EXIT_USAGE = 2, EXIT_FAILED = 3 };

__attribute__((noreturn, format(printf, 2, 3))) static void stop(int code, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    fputs("nqm-bench: ", stderr);
    vfprintf(stderr, format, arguments);
    fputs(code == EXIT_USAGE ? "\n(see nqm-bench --help)\n" : "\n", stderr);
    va_end(arguments);
    exit(code);
}

static void must(nqm_status status, const nqm_error *err) {
    if (status != NQM_OK)
        stop(status == NQM_ERR_ARG ? EXIT_USAGE : EXIT_FAILED, "%s", err->message);
}

static void print_help(void) {
    fputs(usage, stdout);
    for (size_t i = 0; i < nqm_bench_option_table.n; ++i) {
        const nqm_option *row = &nqm_bench_option_table.rows[i];
        char name[NQM_OPTION_TEXT_MAX];
        snprintf(name, sizeof name, "--%s %s", row->key, row->metavar ? row->metavar : "");
        printf("  %-17s %s%s%s%s\n", name, row->help, row->values[0] ? " [" : "", row->values[0] ? row->values[0] : "",
               row->values[0] ? "]" : "");
    }
}

/* ---- arguments --------------------------------------------------------------------------------------------------- */

typedef struct request {
    nqm_bench_options options;
    size_t which; /* N_BENCHES: all */
    bool json;
    const char *output;
} request;

/* Read argv; the files of `load` are moved to its begin. */
static request parse(int argc, char **argv) {
    request r = {.options = nqm_bench_options_default(), .which = N_BENCHES};
    size_t n = 0;
    nqm_error err = {0};
    bool is_off;
    for (int i = 1; i < argc; ++i) {
        const char *word = argv[i];
        const nqm_option *row = strncmp(word, "--", 2) == 0
                                    ? nqm_option_by_name(&nqm_bench_option_table, word + 2, strlen(word + 2), &is_off)
                                    : NULL;
        if (strcmp(word, "--help") == 0) {
            print_help();
            exit(EXIT_SUCCESS);
        }
        const bool is_flag = strcmp(word, "--json") == 0 || (row && nqm_option_is_flag(row));
        if (word[0] == '-' && !row && strcmp(word, "-o") != 0 && !is_flag)
            stop(EXIT_USAGE, "unknown option: %s", word);
        if (word[0] == '-' && !is_flag && ++i == argc)
            stop(EXIT_USAGE, "%s needs a value", word);
        if (word[0] != '-')
            argv[n++] = argv[i];
        else if (row)
            must(nqm_option_set(row, &r.options, is_flag ? "1" : argv[i], &err), &err);
        else if (is_flag)
            r.json = true;
        else
            r.output = argv[i];
    }
    for (r.which = n ? 0 : N_BENCHES; n && r.which < N_BENCHES && strcmp(benches[r.which].name, argv[0]) != 0;)
        ++r.which;
    if (n && r.which == N_BENCHES)
        stop(EXIT_USAGE, "no benchmark '%s': gemm, train, score or load", argv[0]);
    if (n > 1 && r.which != LOAD)
        stop(EXIT_USAGE, "%s: only `load` has file arguments", argv[1]);
    if (n == 1 && r.which == LOAD)
        stop(EXIT_USAGE, "load needs files: load FILE...");
    r.options.n_files = n ? n - 1 : 0;
    r.options.files = (const char *const *)argv + 1;
    return r;
}

/* ---- results ----------------------------------------------------------------------------------------------------- */

/* One line a row: texts and counts, then these numbers. */
static void print_row(const json_t *row) {
    static const char *const numbers[] = {"seconds",     "seconds_median", "ms_per_pair",   "gflops",      "gb_per_s",
                                          "peak_gflops", "peak_gb_per_s",  "floor_seconds", "times_floor", "cpu_share"};
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)(uintptr_t)row, key, value) if (json_is_string(value) && strcmp(key, "unit") != 0)
        printf("%s  ", json_string_value(value));
    json_object_foreach((json_t *)(uintptr_t)row, key, value) if (json_is_integer(value))
        printf("%s %lld  ", key, (long long)json_integer_value(value));
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; ++i) {
        const json_t *number = json_object_get(row, numbers[i]);
        if (number)
            printf("%s %.4g  ", numbers[i], json_real_value(number));
    }
    putchar('\n');
}

static void write_file(const char *path, const json_t *document) {
    nqm_outfile out;
    nqm_error err = {0};
    must(nqm_outfile_open(path, &out, &err), &err);
    json_dumpf(document, out.stream, JSON_INDENT(2) | JSON_REAL_PRECISION(9));
    fputc('\n', out.stream);
    must(nqm_outfile_commit(&out, &err), &err);
}

int main(int argc, char **argv) {
    const request r = parse(argc, argv);
    nqm_bench *bench;
    nqm_error err = {0};
    must(nqm_kernels_select(r.options.kernels, &err), &err);
    must(nqm_bench_create(&r.options, &bench, &err), &err);
    for (size_t i = 0; i < N_BENCHES; ++i)
        if (r.which == N_BENCHES || r.which == i)
            must(benches[i].run(bench, &err), &err);
    json_t *document = nqm_bench_finish(bench), *row;
    size_t i;
    if (!document)
        stop(EXIT_FAILED, "out of memory");
    if (r.output)
        write_file(r.output, document);
    if (r.json)
        json_dumpf(document, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(9));
    else
        json_array_foreach(json_object_get(document, "rows"), i, row) print_row(row);
    putchar('\n');
    json_decref(document);
    nqm_bench_free(bench);
    if (fclose(stdout) != 0)
        stop(EXIT_FAILED, "standard output: cannot write");
    return EXIT_SUCCESS;
}
