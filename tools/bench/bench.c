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

static const char *const precision_words[] = {"f32", "bf16", "all", NULL}; /* nqm_precision, and its count */

/* clang-format off */
static const nqm_option options_rows[] = {
    {OPTION(precision), .kind = NQM_OPTION_ENUM, .metavar = "P", .words = precision_words, .values = {"all"},
     .help = "gemm, train: precision of the factors"},
    {OPTION(kernels), .kind = NQM_OPTION_TEXT, .metavar = "NAME",
     .help = "kernels by name, or `all` except `scalar`, which is slow [default: the best]"},
    {OPTION(rounds), .kind = NQM_OPTION_SIZE, .metavar = "N", .min = 1, .max = 1000, .values = {"7"},
     .help = "timings of each result"},
    {OPTION(recipe), .kind = NQM_OPTION_TEXT, .metavar = "NAME", .values = {"paper"},
     .help = "train: paper, notebook or nqm"},
    {OPTION(seeds), .kind = NQM_OPTION_SIZE, .metavar = "N", .min = 1, .max = 100, .values = {"1"},
     .help = "train: repeat with seeds 1 to N"},
    {OPTION(model), .kind = NQM_OPTION_TEXT, .metavar = "MODEL",
     .help = "score: a built-in model or a file [default: all built-in ones]"},
    {OPTION(quick), .kind = NQM_OPTION_BOOL, .off_name = "",
     .help = "fewer and smaller problems: tests the benchmarks, does not measure"},
};
/* clang-format on */

const nqm_option_table nqm_bench_option_table = {options_rows, sizeof options_rows / sizeof *options_rows, NULL};

nqm_bench_options nqm_bench_options_default(void) {
    nqm_bench_options options = {0};
    (void)!nqm_options_begin(&nqm_bench_option_table, NULL, &options, NULL); /* cannot fail without a recipe */
    return options;
}

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
    for (size_t threads = 1; threads <= (size_t)omp_get_max_threads(); threads *= 2)
        for (size_t i = 0; i < NQM_BENCH_LEVELS; ++i)
            if (nqm_bench_level_bytes(i, threads))
                nqm_bench_read_meter(bench, nqm_bench_level_bytes(i, threads), threads);
    *bench_ret = bench;
    return NQM_OK;
}

void nqm_bench_free(nqm_bench *bench) {
    if (!bench)
        return;
    nqm_bench_release_memory(bench);
    nqm_free(bench->entry);
    nqm_model_free(bench->model);
    nqm_free(bench);
}

/* ---- rows -------------------------------------------------------------------------------------------------------- */

#define FIELD(key, kind, member)                                                                                       \
    { key, NQM_BENCH_##kind, offsetof(nqm_bench_row, member) }
const nqm_bench_field nqm_bench_fields[] = {
    FIELD("bench", TEXT, bench),
    FIELD("name", TEXT, name),
    FIELD("subject", TEXT, subject),
    FIELD("model", TEXT, model),
    FIELD("by", TEXT, by),
    FIELD("kernels", TEXT, kernels),
    FIELD("unit", TEXT, unit),
    FIELD("precision", PRECISION, precision),
    FIELD("batch", COUNT, size.batch),
    FIELD("threads", COUNT, size.threads),
    FIELD("epochs", COUNT, size.epochs),
    FIELD("seed", COUNT, size.seed),
    FIELD("pairs", COUNT, size.pairs),
    FIELD("layer", COUNT, size.layer),
    FIELD("m", COUNT, size.m),
    FIELD("n", COUNT, size.n),
    FIELD("k", COUNT, size.k),
    FIELD("rounds", COUNT, size.rounds),
    FIELD("seconds", NUMBER, times.best),
    FIELD("seconds_median", NUMBER, times.median),
    FIELD("seconds_worst", NUMBER, times.worst),
    FIELD("best_epoch_seconds", NUMBER, times.best_epoch),
    FIELD("seconds_100_epochs", NUMBER, times.epochs_100),
    FIELD("ms_per_pair", NUMBER, times.ms_per_pair),
    FIELD("gflop", NUMBER, work.gflop),
    FIELD("gflops", NUMBER, work.gflops),
    FIELD("peak_gflops", NUMBER, limits.peak_gflops),
    FIELD("peak_median_gflops", NUMBER, limits.peak_median_gflops),
    FIELD("megabytes", NUMBER, work.megabytes),
    FIELD("gb_per_s", NUMBER, work.gb_per_s),
    FIELD("peak_gb_per_s", NUMBER, limits.peak_gb_per_s),
    FIELD("floor_seconds", NUMBER, limits.floor_seconds),
    FIELD("floor_f32_seconds", NUMBER, limits.floor_f32_seconds),
    FIELD("ratio", NUMBER, limits.ratio),
    FIELD("times_floor", NUMBER, limits.times_floor),
    FIELD("times_alternative", NUMBER, times.times_alternative),
    FIELD("cpu_share", NUMBER, times.cpu_share),
    FIELD("cpu_seconds", NUMBER, times.cpu),
    FIELD("ratio_cpu", NUMBER, limits.ratio_cpu),
    FIELD("max_rss_mb", NUMBER, work.max_rss_mb),
    FIELD("train_loss", NUMBER, work.train_loss),
    FIELD("validation_loss", NUMBER, work.validation_loss),
    {0},
};

double nqm_bench_number(const nqm_bench_row *row, const nqm_bench_field *field) {
    const void *at = (const char *)row + field->offset;
    return field->kind == NQM_BENCH_COUNT ? (double)*(const size_t *)at : *(const double *)at;
}

const char *nqm_bench_text(const nqm_bench_row *row, const nqm_bench_field *field) {
    if (field->kind == NQM_BENCH_PRECISION)
        return row->precision < 0 ? NULL : nqm_precision_name((nqm_precision)row->precision);
    return *(const char *const *)(const void *)((const char *)row + field->offset);
}

nqm_bench_entry nqm_bench_entry_make(const char *bench_name, const char *name) {
    nqm_bench_entry entry = {{.precision = -1}, NQM_METER_NONE, NQM_METER_NONE, NQM_METER_NONE, 0};
    for (const nqm_bench_field *f = nqm_bench_fields; f->key; ++f)
        if (f->kind == NQM_BENCH_NUMBER)
            *(double *)(void *)((char *)&entry.row + f->offset) = NAN;
    entry.row.bench = bench_name;
    entry.row.name = name;
    entry.row.by = "nqm";
    entry.row.kernels = nqm_kernels_selected();
    entry.row.size.threads = (size_t)omp_get_max_threads();
    return entry;
}

void nqm_bench_entry_work(nqm_bench *bench, nqm_bench_entry *entry, nqm_precision precision, double flop) {
    entry->row.precision = (int)precision;
    entry->row.work.gflop = 1e-9 * flop;
    entry->peak = nqm_bench_peak_meter(bench, precision);
    entry->peak_f32 = nqm_bench_peak_meter(bench, NQM_PRECISION_F32);
}

void nqm_bench_entry_reading(nqm_bench *bench, nqm_bench_entry *entry, size_t n_bytes) {
    entry->row.work.megabytes = 1e-6 * (double)n_bytes;
    entry->read = nqm_bench_read_meter(bench, n_bytes, (size_t)omp_get_max_threads());
}

nqm_status nqm_bench_add(nqm_bench *bench, const nqm_bench_entry *entry, nqm_error *err) {
    const size_t n = bench->n_entries;
    if ((n & (n - 1)) == 0) { /* full: double the size */
        nqm_bench_entry *larger = nqm_alloc(nqm_larger(1, 2 * n), sizeof *entry);
        if (!larger)
            return nqm_fail_nomem(err, 2 * n * sizeof *entry);
        if (n)
            memcpy(larger, bench->entry, n * sizeof *entry);
        nqm_free(bench->entry);
        bench->entry = larger;
    }
    bench->entry[bench->n_entries++] = *entry;
    return NQM_OK;
}

/* Derive rates, limits and ratios from the times, the work and the peaks. */
static void complete(const nqm_bench *bench, nqm_bench_entry *entry) {
    nqm_bench_row *row = &entry->row;
    double arithmetic = NAN, reading = NAN;
    if (row->size.batch && strcmp(row->bench, "score") == 0)
        row->times.ms_per_pair = 1e3 * row->times.best / (double)row->size.batch;
    row->work.gflops = row->work.gflop / row->times.best;
    row->work.gb_per_s = row->work.megabytes / row->times.best / 1000;
    if (entry->peak != NQM_METER_NONE) {
        row->unit = bench->meter[entry->peak].unit->name;
        row->limits.peak_gflops = nqm_bench_meter_peak(&bench->meter[entry->peak]);
        row->limits.peak_median_gflops = nqm_bench_meter_median(&bench->meter[entry->peak]);
        arithmetic = row->work.gflop / row->limits.peak_gflops;
    }
    if (entry->peak_f32 != NQM_METER_NONE && entry->row.precision == NQM_PRECISION_BF16)
        row->limits.floor_f32_seconds = row->work.gflop / nqm_bench_meter_peak(&bench->meter[entry->peak_f32]);
    if (entry->read != NQM_METER_NONE) {
        row->limits.peak_gb_per_s = nqm_bench_meter_peak(&bench->meter[entry->read]);
        reading = row->work.megabytes / row->limits.peak_gb_per_s / 1000;
    }
    row->limits.floor_seconds = fmax(arithmetic, reading); /* fmax() ignores NaN */
    row->limits.ratio = row->limits.floor_seconds / row->times.best;
    row->limits.times_floor = row->times.best / row->limits.floor_seconds;
    row->limits.ratio_cpu = row->limits.floor_seconds / row->times.cpu;
}

static nqm_bench_entry unit_entry(const nqm_bench_unit *unit) {
    nqm_bench_entry entry = nqm_bench_entry_make("peak", "absent");
    entry.row.by = entry.row.kernels = NULL;
    entry.row.unit = unit->name;
    entry.row.precision = (int)unit->precision;
    return entry;
}

static nqm_bench_entry meter_entry(const nqm_bench_meter *meter) {
    nqm_bench_entry entry = meter->unit ? unit_entry(meter->unit) : nqm_bench_entry_make("peak", "reading");
    nqm_bench_row *row = &entry.row;
    row->by = row->kernels = NULL;
    row->size.threads = meter->threads;
    row->size.rounds = meter->n_samples;
    if (meter->unit) {
        row->name = "arithmetic";
        row->work.gflops = row->limits.peak_gflops = nqm_bench_meter_peak(meter);
        row->limits.peak_median_gflops = nqm_bench_meter_median(meter);
    } else {
        row->work.megabytes = 1e-6 * (double)meter->bytes;
        row->work.gb_per_s = row->limits.peak_gb_per_s = nqm_bench_meter_peak(meter);
        row->times.best = row->work.megabytes / 1000 / nqm_bench_meter_peak(meter);
        row->times.median = row->work.megabytes / 1000 / nqm_bench_meter_median(meter);
    }
    return entry;
}

nqm_status nqm_bench_finish(nqm_bench *bench, nqm_error *err) {
    const size_t n_timed = bench->n_entries;
    nqm_status status = nqm_bench_take_memory(bench, err);
    for (size_t i = 0; i < (size_t)bench->n_meters && status == NQM_OK; ++i) {
        nqm_bench_sample(bench, (int)i);
        const nqm_bench_entry entry = meter_entry(&bench->meter[i]);
        status = nqm_bench_add(bench, &entry, err);
    }
    for (const nqm_bench_unit *unit = nqm_bench_units; unit->name && status == NQM_OK; ++unit) {
        const nqm_bench_entry entry = unit_entry(unit);
        if (!unit->is_available())
            status = nqm_bench_add(bench, &entry, err);
    }
    nqm_bench_release_memory(bench);
    for (size_t i = 0; i < n_timed; ++i) {
        nqm_bench_entry *entry = &bench->entry[i];
        complete(bench, entry);
        if (entry->alternative)
            entry->row.times.times_alternative =
                bench->entry[i - entry->alternative].row.times.best / entry->row.times.best;
    }
    return status;
}

/* ---- timing ------------------------------------------------------------------------------------------------------ */

nqm_status nqm_bench_step(nqm_bench *bench, const char *stage, nqm_error *err) {
    const nqm_bench_options *o = &bench->options;
    bench->done += 1;
    if (o->progress && o->progress(o->progress_user, stage, bench->done, bench->total) != 0)
        return nqm_fail(err, NQM_ERR_CANCELLED, -1, "interrupted; the results so far are discarded");
    return NQM_OK;
}

double nqm_bench_process_clock_s(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Mean seconds of a call, by the clock and by the processor time of all threads. */
typedef struct duration {
    double clock, cpu;
} duration;

static duration time_calls(const nqm_bench_contender *c, bool quick) {
    const double round_s = c->prepare ? 0 : quick ? 1e-3 : 1e-2; /* shortest time of a round */
    size_t n = 0;
    if (c->prepare)
        c->prepare(c->user);
    double cpu_begin = nqm_bench_process_clock_s(), begin = nqm_clock_s(), now;
    do {
        c->run(c->user);
        ++n;
        now = nqm_clock_s();
    } while (now - begin < round_s);
    return (duration){(now - begin) / (double)n, (nqm_bench_process_clock_s() - cpu_begin) / (double)n};
}

/* Add an entry with the seconds (n) of its rounds by the clock and by processor time, both of which are sorted. */
static nqm_status add_times(nqm_bench *bench, const nqm_bench_entry *entry, size_t n, double *seconds, double *cpu_s,
                            nqm_error *err) {
    nqm_bench_entry timed = *entry;
    nqm_bench_row *row = &timed.row;
    row->size.rounds = n;
    row->times.median = nqm_quantile(n, seconds, 0.5);
    row->times.best = seconds[0]; /* sorted now */
    row->times.worst = seconds[n - 1];
    row->times.cpu_share = nqm_mean(n, cpu_s) / nqm_mean(n, seconds) / (double)row->size.threads;
    row->times.cpu = nqm_quantile(n, cpu_s, 0) / (double)row->size.threads;
    return nqm_bench_add(bench, &timed, err);
}

nqm_status nqm_bench_race(nqm_bench *bench, size_t n, const nqm_bench_contender *contenders,
                          const nqm_bench_entry *entries, nqm_error *err) {
    const size_t rounds = bench->options.rounds;
    double *seconds = nqm_alloc(2 * n * rounds, sizeof *seconds);
    if (!seconds)
        return nqm_fail_nomem(err, 2 * n * rounds * sizeof *seconds);
    double *cpu_s = seconds + n * rounds;
    nqm_status status = NQM_OK;
    for (size_t i = 0; i < n; ++i)
        contenders[i].run(contenders[i].user); /* warm up */
    for (size_t round = 0; round < rounds && status == NQM_OK; ++round) {
        for (size_t i = 0; i < n; ++i) {
            const duration d = time_calls(&contenders[i], bench->options.quick);
            seconds[i * rounds + round] = d.clock;
            cpu_s[i * rounds + round] = d.cpu;
            nqm_bench_sample(bench, entries[i].peak);
            nqm_bench_sample(bench, entries[i].read);
        }
        status = nqm_bench_step(bench, entries[0].row.bench, err);
    }
    for (size_t i = 0; i < n && status == NQM_OK; ++i)
        status = add_times(bench, &entries[i], rounds, seconds + i * rounds, cpu_s + i * rounds, err);
    nqm_free(seconds);
    return status;
}
