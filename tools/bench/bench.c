/* SPDX-License-Identifier: MIT
 *
 * Benchmarks in general: timing several ways in turns with samples of the machine's peaks between them, and rows, which
 * are settled at the end, when all samples of the peaks are there.
 */
#include "bench/inside.h"
#include "math/math.h"

#include <math.h>
#include <omp.h>
#include <string.h>
#include <time.h>

nqm_bench_options nqm_bench_options_default(void) {
    return (nqm_bench_options){
        .rounds = 7, .round_s = 0.01, .precisions = (1U << NQM_PRECISION_COUNT) - 1, .memory_mb = 256};
}

static nqm_status check_options(const nqm_bench_options *o, nqm_error *err) {
    if (o->rounds < 1 || o->rounds > 1000)
        return nqm_fail(err, NQM_ERR_ARG, -1, "rounds %zu: not 1 to 1000", o->rounds);
    if (!(o->round_s >= 1e-4 && o->round_s <= 10))
        return nqm_fail(err, NQM_ERR_ARG, -1, "seconds of a round %g: not 0.0001 to 10", o->round_s);
    if (!(o->memory_mb >= 1 && o->memory_mb <= 65536))
        return nqm_fail(err, NQM_ERR_ARG, -1, "megabytes of memory %g: not 1 to 65536", o->memory_mb);
    if (o->precisions == 0 || o->precisions >> NQM_PRECISION_COUNT)
        return nqm_fail(err, NQM_ERR_ARG, -1, "precisions: none, or an unknown one");
    return NQM_OK;
}

nqm_status nqm_bench_create(const nqm_bench_options *options, nqm_bench **bench_ret, nqm_error *err) {
    *bench_ret = NULL;
    const nqm_bench_options o = options ? *options : nqm_bench_options_default();
    nqm_status status = check_options(&o, err);
    if (status != NQM_OK)
        return status;
    nqm_bench *bench = nqm_alloc(1, sizeof *bench);
    if (!bench)
        return nqm_fail_nomem(err, sizeof *bench);
    bench->options = o;
    status = nqm_bench_take_memory(bench, err);
    if (status != NQM_OK) {
        nqm_bench_free(bench);
        return status;
    }
    for (int precision = 0; precision < NQM_PRECISION_COUNT; ++precision)
        nqm_bench_peak_meter(bench, (nqm_precision)precision);
    for (size_t threads = 1; threads <= (size_t)omp_get_max_threads(); threads *= 2)
        nqm_bench_read_meter(bench, bench->memory_bytes, threads);
    *bench_ret = bench;
    return NQM_OK;
}

void nqm_bench_free(nqm_bench *bench) {
    if (!bench)
        return;
    nqm_bench_release_memory(bench);
    nqm_free(bench->entry);
    for (size_t i = 0; i < bench->n_texts; ++i)
        nqm_free(bench->text[i]);
    nqm_free(bench->text);
    nqm_free(bench);
}

/* ---- rows -------------------------------------------------------------------------------------------------------- */

static const nqm_bench_row nothing = {.precision = -1,
                                      .seconds = NAN,
                                      .seconds_median = NAN,
                                      .seconds_worst = NAN,
                                      .ms_per_pair = NAN,
                                      .gflop = NAN,
                                      .gflops = NAN,
                                      .peak_gflops = NAN,
                                      .peak_median = NAN,
                                      .megabytes = NAN,
                                      .gb_per_s = NAN,
                                      .peak_gb_per_s = NAN,
                                      .floor_seconds = NAN,
                                      .floor_f32 = NAN,
                                      .ratio = NAN,
                                      .times_floor = NAN,
                                      .cpu_share = NAN,
                                      .max_rss_mb = NAN,
                                      .train_loss = NAN,
                                      .validation_loss = NAN,
                                      .seconds_100 = NAN,
                                      .best_epoch_seconds = NAN,
                                      .times_alternative = NAN};

nqm_bench_entry nqm_bench_entry_make(const char *bench_name, const char *name) {
    nqm_bench_entry entry = {nothing, NQM_METER_NONE, NQM_METER_NONE, NQM_METER_NONE, 0};
    entry.row.bench = bench_name;
    entry.row.name = name;
    entry.row.by = "nqm";
    entry.row.kernels = nqm_kernels_selected();
    entry.row.threads = (size_t)omp_get_max_threads();
    return entry;
}

void nqm_bench_entry_work(nqm_bench *bench, nqm_bench_entry *entry, nqm_precision precision, double flop) {
    entry->row.precision = (int)precision;
    entry->row.gflop = 1e-9 * flop;
    entry->peak = nqm_bench_peak_meter(bench, precision);
    entry->peak_f32 = nqm_bench_peak_meter(bench, NQM_PRECISION_F32);
}

void nqm_bench_entry_reading(nqm_bench *bench, nqm_bench_entry *entry, size_t n_bytes) {
    entry->row.megabytes = 1e-6 * (double)n_bytes;
    entry->read = nqm_bench_read_meter(bench, n_bytes, (size_t)omp_get_max_threads());
}

/* Room for one more at the end of an array of n, which begins as NULL; the array doubles. NULL: out of memory. */
static void *grow(void *array, size_t n, size_t size) {
    if (n & (n - 1) || (n == 0 && array)) /* there is room up to the next power of two */
        return array;
    void *larger = nqm_alloc(n ? 2 * n : 1, size);
    if (!larger)
        return NULL;
    if (n)
        memcpy(larger, array, n * size);
    nqm_free(array);
    return larger;
}

nqm_status nqm_bench_add(nqm_bench *bench, const nqm_bench_entry *entry, nqm_error *err) {
    void *entries = grow(bench->entry, bench->n_entries, sizeof *entry);
    if (!entries)
        return nqm_fail_nomem(err, 2 * bench->n_entries * sizeof *entry);
    bench->entry = entries;
    bench->entry[bench->n_entries++] = *entry;
    return NQM_OK;
}

const char *nqm_bench_keep_text(nqm_bench *bench, const char *text) {
    char *copy = nqm_strdup(text);
    void *texts = copy ? grow(bench->text, bench->n_texts, sizeof *bench->text) : NULL;
    if (!texts) {
        nqm_free(copy);
        return NULL;
    }
    bench->text = texts;
    return bench->text[bench->n_texts++] = copy;
}

/* What follows from the times, the work and the peaks. */
static void settle(const nqm_bench *bench, nqm_bench_entry *entry) {
    nqm_bench_row *row = &entry->row;
    double arithmetic = NAN, reading = NAN;
    if (row->batch && strcmp(row->bench, "score") == 0)
        row->ms_per_pair = 1e3 * row->seconds / (double)row->batch;
    row->gflops = row->gflop / row->seconds;
    row->gb_per_s = row->megabytes / row->seconds / 1000;
    if (entry->peak != NQM_METER_NONE) {
        row->peak_gflops = nqm_bench_meter_peak(&bench->meter[entry->peak]);
        row->peak_median = nqm_bench_meter_median(&bench->meter[entry->peak]);
        arithmetic = row->gflop / row->peak_gflops;
    }
    if (entry->peak_f32 != NQM_METER_NONE && entry->row.precision == NQM_PRECISION_BF16)
        row->floor_f32 = row->gflop / nqm_bench_meter_peak(&bench->meter[entry->peak_f32]);
    if (entry->read != NQM_METER_NONE) {
        row->peak_gb_per_s = nqm_bench_meter_peak(&bench->meter[entry->read]);
        reading = row->megabytes / row->peak_gb_per_s / 1000;
    }
    row->floor_seconds = fmax(arithmetic, reading); /* fmax() leaves NaN out */
    row->ratio = row->floor_seconds / row->seconds;
    row->times_floor = row->seconds / row->floor_seconds;
}

static nqm_bench_entry meter_entry(const nqm_meter *meter) {
    nqm_bench_entry entry = nqm_bench_entry_make("peak", meter->bytes ? "reading" : "arithmetic");
    nqm_bench_row *row = &entry.row;
    row->by = NULL;
    row->kernels = meter->kernels;
    row->threads = meter->threads;
    row->rounds = meter->n_samples;
    if (meter->bytes) {
        row->megabytes = 1e-6 * (double)meter->bytes;
        row->gb_per_s = row->peak_gb_per_s = nqm_bench_meter_peak(meter);
        row->seconds = row->megabytes / 1000 / nqm_bench_meter_peak(meter);
        row->seconds_median = row->megabytes / 1000 / nqm_bench_meter_median(meter);
    } else {
        row->precision = (int)meter->precision;
        row->gflops = row->peak_gflops = nqm_bench_meter_peak(meter);
        row->peak_median = nqm_bench_meter_median(meter);
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
    nqm_bench_release_memory(bench);
    for (size_t i = 0; i < n_timed; ++i) {
        nqm_bench_entry *entry = &bench->entry[i];
        settle(bench, entry);
        if (entry->alternative)
            entry->row.times_alternative = bench->entry[i - entry->alternative].row.seconds / entry->row.seconds;
    }
    return status;
}

size_t nqm_bench_count(const nqm_bench *bench) {
    return bench->n_entries;
}

nqm_bench_row nqm_bench_get_row(const nqm_bench *bench, size_t i) {
    return bench->entry[i].row;
}

/* ---- timing ------------------------------------------------------------------------------------------------------ */

nqm_status nqm_bench_step(nqm_bench *bench, const char *stage, nqm_error *err) {
    const nqm_bench_options *o = &bench->options;
    bench->done += 1;
    if (o->progress && o->progress(o->progress_user, stage, bench->done, bench->total) != 0)
        return nqm_fail(err, NQM_ERR_CANCELLED, -1, "interrupted: nothing is printed of what was measured");
    return NQM_OK;
}

double nqm_process_clock_s(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Seconds of one call, from as many as fill a round. */
static double time_calls(const nqm_contender *c, double round_s, double *cpu_s) {
    size_t n = 0;
    double cpu_begin = nqm_process_clock_s(), begin = nqm_clock_s(), now;
    do {
        c->run(c->user);
        ++n;
        now = nqm_clock_s();
    } while (now - begin < round_s);
    *cpu_s += (nqm_process_clock_s() - cpu_begin) / (double)n;
    return (now - begin) / (double)n;
}

nqm_status nqm_bench_add_times(nqm_bench *bench, const nqm_bench_entry *entry, size_t n, double *seconds, double cpu_s,
                               nqm_error *err) {
    nqm_bench_entry timed = *entry;
    nqm_bench_row *row = &timed.row;
    row->rounds = n;
    row->seconds_median = nqm_quantile(n, seconds, 0.5);
    row->seconds = seconds[0]; /* sorted now */
    row->seconds_worst = seconds[n - 1];
    row->cpu_share = cpu_s / (double)n / nqm_mean(n, seconds) / (double)row->threads;
    return nqm_bench_add(bench, &timed, err);
}

nqm_status nqm_bench_race(nqm_bench *bench, size_t n, const nqm_contender *contenders, const nqm_bench_entry *entries,
                          nqm_error *err) {
    const size_t rounds = bench->options.rounds;
    double *seconds = nqm_alloc(n * (rounds + 1), sizeof *seconds);
    if (!seconds)
        return nqm_fail_nomem(err, n * rounds * sizeof *seconds);
    double *cpu_s = seconds + n * rounds;
    nqm_status status = NQM_OK;
    for (size_t i = 0; i < n; ++i)
        contenders[i].run(contenders[i].user); /* warm */
    for (size_t round = 0; round < rounds && status == NQM_OK; ++round) {
        for (size_t i = 0; i < n; ++i) {
            seconds[i * rounds + round] = time_calls(&contenders[i], bench->options.round_s, &cpu_s[i]);
            nqm_bench_sample(bench, entries[i].peak);
            nqm_bench_sample(bench, entries[i].read);
        }
        status = nqm_bench_step(bench, entries[0].row.bench, err);
    }
    for (size_t i = 0; i < n && status == NQM_OK; ++i)
        status = nqm_bench_add_times(bench, &entries[i], rounds, seconds + i * rounds, cpu_s[i], err);
    nqm_free(seconds);
    return status;
}
