/* SPDX-License-Identifier: MIT
 *
 * Shared by all benchmarks: timing in turns with samples of the machine's peaks in between, and the rows, which are
 * completed at the end, when all samples of the peaks exist.
 */
#include "bench/bench.h"
#include "math/math.h"

#include <math.h>
#include <omp.h>
#include <string.h>
#include <time.h>

/* ---- options ----------------------------------------------------------------------------------------------------- */

#define OPTION(name) .key = #name, .offset = offsetof(nqm_bench_options, name)

static const char *const precision_words[] = {"f32", "bf16", "all", NULL}; /* nqm_precision, and both */

/* clang-format off */
static const nqm_option options_rows[] = {
    {OPTION(precision), .kind = NQM_OPTION_ENUM, .metavar = "P", .words = precision_words, .values = {"all"},
     .help = "gemm, train: precision of the arithmetic"},
    {OPTION(kernels), .kind = NQM_OPTION_TEXT, .metavar = "NAME",
     .help = "kernels [default: the best]"},
    {OPTION(rounds), .kind = NQM_OPTION_SIZE, .metavar = "N", .min = 1, .max = 1000, .values = {"7"},
     .help = "timings of each result"},
    {OPTION(recipe), .kind = NQM_OPTION_TEXT, .metavar = "NAME", .values = {"paper"},
     .help = "train: paper, notebook or nqm"},
    {OPTION(seeds), .kind = NQM_OPTION_SIZE, .metavar = "N", .min = 1, .max = 100, .values = {"1"},
     .help = "train: repeat with seeds 1 to N"},
    {OPTION(epochs), .kind = NQM_OPTION_SIZE, .metavar = "N", .max = 10000, .values = {"0"},
     .help = "train: epochs; 0: the recipe's"},
    {OPTION(model), .kind = NQM_OPTION_TEXT, .metavar = "MODEL",
     .help = "score: a built-in model or a file [default: all built-in ones]"},
    {OPTION(quick), .kind = NQM_OPTION_BOOL, .off_name = "",
     .help = "fewer and smaller problems: tests the benchmarks, does not measure"},
};
/* clang-format on */

const nqm_option_table nqm_bench_option_table = {options_rows, sizeof options_rows / sizeof *options_rows, NULL};

NQM_OPTIONS_DEFAULT(nqm_bench_option, 0)

nqm_status nqm_bench_create(const nqm_bench_options *options, nqm_bench **bench_ret, nqm_error *err) {
    *bench_ret = NULL;
    nqm_status status = nqm_options_check(&nqm_bench_option_table, options, err);
    if (status != NQM_OK)
        return status;
    nqm_bench *bench = nqm_alloc(1, sizeof *bench);
    if (!bench)
        return nqm_fail_nomem(err, sizeof *bench);
    bench->options = *options;
    if (options->quick)
        bench->options.rounds = nqm_smaller(options->rounds, 2);
    status = nqm_bench_take_memory(bench, err);
    if (status != NQM_OK) {
        nqm_bench_free(bench);
        return status;
    }
    nqm_bench_add_units(bench);
    nqm_bench_read_meter(bench, bench->memory_bytes);
    *bench_ret = bench;
    return NQM_OK;
}

void nqm_bench_free(nqm_bench *bench) {
    if (!bench)
        return;
    nqm_bench_release_memory(bench);
    for (size_t i = 0; i < bench->n_entries; ++i)
        json_decref(bench->entry[i].row);
    nqm_free(bench->entry);
    nqm_free(bench);
}

/* ---- rows -------------------------------------------------------------------------------------------------------- */

nqm_bench_entry nqm_bench_entry_make(const char *bench_name, const char *name, void (*run)(void *user), void *user) {
    return (nqm_bench_entry){.run = run,
                             .user = user,
                             .row = json_pack("{s:s,s:s,s:s,s:s,s:i}", "bench", bench_name, "name", name, "by", "nqm",
                                              "kernels", nqm_kernels_get()->name, "threads", omp_get_max_threads()),
                             .peak = NQM_METER_NONE,
                             .read = NQM_METER_NONE};
}

void nqm_bench_number(nqm_bench_entry *entry, const char *key, double number) {
    if (isfinite(number) && number > 0)
        json_object_set_new(entry->row, key, json_real(number));
}

/* A count of the row, 0 if it has none. */
static size_t count_of(const nqm_bench_entry *entry, const char *key) {
    return (size_t)json_integer_value(json_object_get(entry->row, key));
}

void nqm_bench_entry_work(nqm_bench *bench, nqm_bench_entry *entry, nqm_precision precision, double flop) {
    nqm_bench_text(entry, "precision", nqm_precision_words[precision]);
    entry->gflop = 1e-9 * flop;
    entry->peak = nqm_bench_peak_meter(bench, precision);
}

void nqm_bench_entry_reading(nqm_bench *bench, nqm_bench_entry *entry, size_t n_bytes) {
    entry->megabytes = 1e-6 * (double)n_bytes;
    entry->read = nqm_bench_read_meter(bench, n_bytes);
}

nqm_status nqm_bench_add(nqm_bench *bench, const nqm_bench_entry *entry, nqm_error *err) {
    nqm_bench_entry *larger = nqm_grow(bench->entry, &bench->max_entries, bench->n_entries + 1, sizeof *entry);
    if (!larger) {
        json_decref(entry->row);
        return nqm_fail_nomem(err, sizeof *entry);
    }
    bench->entry = larger;
    bench->entry[bench->n_entries++] = *entry;
    return NQM_OK;
}

/* Add the times, and the rates, limits and ratios that follow from them, the work and the peaks. */
static void complete(const nqm_bench *bench, nqm_bench_entry *e) {
    double arithmetic = NAN, reading = NAN;
    nqm_bench_number(e, "seconds", e->best);
    nqm_bench_number(e, "seconds_median", e->median);
    if (strcmp(json_string_value(json_object_get(e->row, "bench")), "score") == 0)
        nqm_bench_number(e, "ms_per_pair", 1e3 * e->best / (double)count_of(e, "batch"));
    nqm_bench_number(e, "gflop", e->gflop);
    nqm_bench_number(e, "gflops", e->gflop / e->best);
    nqm_bench_number(e, "megabytes", e->megabytes);
    nqm_bench_number(e, "gb_per_s", e->megabytes / e->best / 1000);
    if (e->peak != NQM_METER_NONE) {
        const nqm_bench_meter *meter = &bench->meter[e->peak];
        nqm_bench_text(e, "unit", meter->unit->name);
        nqm_bench_number(e, "peak_gflops", nqm_bench_meter_peak(meter));
        arithmetic = e->gflop / nqm_bench_meter_peak(meter);
    }
    if (e->read != NQM_METER_NONE) {
        const double peak = nqm_bench_meter_peak(&bench->meter[e->read]);
        nqm_bench_number(e, "peak_gb_per_s", peak);
        reading = e->megabytes / peak / 1000;
    }
    const double floor_s = fmax(arithmetic, reading); /* fmax() ignores NaN */
    nqm_bench_number(e, "floor_seconds", floor_s);
    nqm_bench_number(e, "ratio", floor_s / e->best);
    nqm_bench_number(e, "times_floor", e->best / floor_s);
    nqm_bench_number(e, "cpu_share", e->cpu_share);
    nqm_bench_number(e, "cpu_seconds", e->cpu);
    nqm_bench_number(e, "ratio_cpu", floor_s / e->cpu);
}

static json_t *peak_row(const nqm_bench_meter *meter) {
    const nqm_bench_unit *unit = meter->unit;
    nqm_bench_entry e = {.row = json_pack("{s:s,s:s}", "bench", "peak", "name", unit ? "arithmetic" : "reading")};
    if (unit) {
        nqm_bench_text(&e, "unit", unit->name);
        nqm_bench_text(&e, "precision", nqm_precision_words[unit->precision]);
    }
    nqm_bench_count(&e, "threads", (size_t)omp_get_max_threads());
    nqm_bench_count(&e, "rounds", meter->n_samples);
    nqm_bench_number(&e, "megabytes", 1e-6 * (double)meter->bytes);
    nqm_bench_number(&e, unit ? "peak_gflops" : "peak_gb_per_s", nqm_bench_meter_peak(meter));
    return e.row;
}

json_t *nqm_bench_finish(nqm_bench *bench) {
    json_t *rows = json_array();
    if (nqm_bench_take_memory(bench, NULL) == NQM_OK)
        for (int i = 0; i < bench->n_meters; ++i)
            nqm_bench_sample(bench, i);
    nqm_bench_release_memory(bench);
    for (size_t i = 0; i < bench->n_entries; ++i) {
        complete(bench, &bench->entry[i]);
        json_array_append(rows, bench->entry[i].row);
    }
    for (int i = 0; i < bench->n_meters; ++i)
        json_array_append_new(rows, peak_row(&bench->meter[i]));
    return json_pack("{s:i,s:s,s:o,s:o}", "schema", 1, "version", nqm_version(), "machine", nqm_bench_machine(), "rows",
                     rows);
}

/* ---- timing ------------------------------------------------------------------------------------------------------ */

double nqm_bench_process_clock_s(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Mean seconds of a call, by the clock and by the processor time of all threads. */
typedef struct duration {
    double clock, cpu;
} duration;

static duration time_calls(const nqm_bench_entry *e, bool quick) {
    const double round_s = quick ? 1e-3 : 1e-2; /* shortest time of a round */
    size_t n = 0;
    double cpu_begin = nqm_bench_process_clock_s(), begin = nqm_clock_s(), now;
    do {
        e->run(e->user);
        ++n;
        now = nqm_clock_s();
    } while (now - begin < round_s);
    return (duration){(now - begin) / (double)n, (nqm_bench_process_clock_s() - cpu_begin) / (double)n};
}

/* Add an entry with the seconds (n) of its rounds by the clock and by processor time, both of which are sorted. */
static nqm_status add_times(nqm_bench *bench, const nqm_bench_entry *entry, size_t n, double *seconds, double *cpu_s,
                            nqm_error *err) {
    nqm_bench_entry timed = *entry;
    const double threads = (double)count_of(entry, "threads");
    nqm_bench_count(&timed, "rounds", n);
    timed.median = nqm_quantile(n, seconds, 0.5);
    timed.best = seconds[0]; /* sorted now */
    timed.cpu_share = nqm_mean(n, cpu_s) / nqm_mean(n, seconds) / threads;
    timed.cpu = nqm_quantile(n, cpu_s, 0) / threads;
    return nqm_bench_add(bench, &timed, err);
}

nqm_status nqm_bench_race(nqm_bench *bench, size_t n, const nqm_bench_entry *entries, nqm_error *err) {
    const size_t rounds = bench->options.rounds;
    double *seconds = nqm_alloc(2 * n * rounds, sizeof *seconds);
    if (!seconds)
        return nqm_fail_nomem(err, 2 * n * rounds * sizeof *seconds);
    double *cpu_s = seconds + n * rounds;
    for (size_t i = 0; i < n; ++i)
        entries[i].run(entries[i].user); /* warm up */
    for (size_t round = 0; round < rounds; ++round)
        for (size_t i = 0; i < n; ++i) {
            const duration d = time_calls(&entries[i], bench->options.quick);
            seconds[i * rounds + round] = d.clock;
            cpu_s[i * rounds + round] = d.cpu;
            nqm_bench_sample(bench, entries[i].peak);
            nqm_bench_sample(bench, entries[i].read);
        }
    nqm_status status = NQM_OK;
    for (size_t i = 0; i < n && status == NQM_OK; ++i)
        status = add_times(bench, &entries[i], rounds, seconds + i * rounds, cpu_s + i * rounds, err);
    nqm_free(seconds);
    return status;
}
