/* SPDX-License-Identifier: MIT
 *
 * Meters of the machine: its current rate of operations or bytes per nanosecond. Samples last milliseconds, so that on
 * a busy machine some are taken while no other program runs.
 */
#include "bench/bench.h"
#include "math/math.h"

#include <math.h>
#include <omp.h>
#include <sched.h>
#include <stdatomic.h>
#include <string.h>
#include <time.h>

enum {
    TIMINGS_A_SAMPLE = 3,
    READ_BYTES = 512, /* per step of the loops */
    MAX_STEPS = 1 << 30
};
#define TIMING_S 0.001

static volatile float float_sink;
static volatile uint64_t integer_sink;

/* Processor time of the calling thread, s: excludes other programs. */
static double thread_clock_s(void) {
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static size_t thread_count(void) {
    return (size_t)omp_get_max_threads();
}

/* The work of one thread in a timing. */
static void work(const nqm_bench *bench, const nqm_bench_meter *meter, size_t thread) {
    if (meter->bytes) {
        const size_t n_lines = meter->bytes / READ_BYTES;
        const size_t first = thread * n_lines / thread_count(), last = (thread + 1) * n_lines / thread_count();
        for (size_t i = 0; i < meter->steps; ++i)
            integer_sink = nqm_bench_read((last - first) * READ_BYTES, bench->memory + first * READ_BYTES);
        return;
    }
    uint32_t seed[64];
    const float factor = 0.999F, offset = 1e-3F; /* accumulators converge to 1 */
    for (size_t i = 0; i < 64; ++i)
        memcpy(&seed[i], i < 16 ? &factor : &offset, sizeof factor);
    float_sink = meter->unit->run(meter->steps, seed);
}

/* Operations or bytes of a timing, all threads together, 1e9. */
static double amount(const nqm_bench_meter *meter) {
    const double steps = 1e-9 * (double)meter->steps;
    if (meter->bytes)
        return steps * (double)meter->bytes;
    return steps * (double)thread_count() * meter->unit->flop;
}

/* A barrier. It spins, because sleeping threads wake up at different times. */
static void meet(atomic_size_t *n_arrived, size_t n_threads) {
    atomic_fetch_add(n_arrived, 1);
    while (atomic_load(n_arrived) < n_threads)
        sched_yield();
}

/* The rate of all threads together. Arithmetic: by processor time, which excludes other programs. Reading: by the
 * clock, because threads share the memory. */
static double measure(const nqm_bench *bench, const nqm_bench_meter *meter) {
    double begin = INFINITY, end = 0, rate = 0;
    const double share = amount(meter) / (double)thread_count();
    atomic_size_t n_arrived = 0;
#pragma omp parallel reduction(min : begin) reduction(max : end) reduction(+ : rate)
    {
        meet(&n_arrived, (size_t)omp_get_num_threads());
        const double cpu_begin = thread_clock_s();
        begin = nqm_clock_s();
        work(bench, meter, (size_t)omp_get_thread_num());
        end = nqm_clock_s();
        rate = share / (thread_clock_s() - cpu_begin);
    }
    return meter->bytes ? amount(meter) / (end - begin) : rate;
}

/* Find the number of steps that fills a timing. */
static void calibrate(const nqm_bench *bench, nqm_bench_meter *meter) {
    double seconds = 0;
    for (meter->steps = 1; seconds < TIMING_S && meter->steps < MAX_STEPS; meter->steps *= 2) {
        double begin = thread_clock_s();
        work(bench, meter, 0);
        seconds = thread_clock_s() - begin;
    }
}

void nqm_bench_sample(nqm_bench *bench, int which) {
    if (which == NQM_METER_NONE)
        return;
    nqm_bench_meter *meter = &bench->meter[which];
    for (int i = 0; i < TIMINGS_A_SAMPLE && (!meter->bytes || bench->memory); ++i) {
        double rate = measure(bench, meter);
        meter->best = fmax(meter->best, rate);
        meter->sample[meter->n_samples++ % NQM_METER_SAMPLES] = rate;
    }
}

static int new_meter(nqm_bench *bench, const nqm_bench_unit *unit, size_t n_bytes) {
    for (int i = 0; i < bench->n_meters; ++i)
        if (bench->meter[i].unit == unit && bench->meter[i].bytes == n_bytes)
            return i;
    if (bench->n_meters == NQM_MAX_METERS)
        return NQM_METER_NONE;
    nqm_bench_meter *meter = &bench->meter[bench->n_meters];
    *meter = (nqm_bench_meter){.unit = unit, .bytes = n_bytes};
    calibrate(bench, meter);
    nqm_bench_sample(bench, bench->n_meters);
    return bench->n_meters++;
}

void nqm_bench_add_units(nqm_bench *bench) {
    for (const nqm_bench_unit *unit = nqm_bench_units; unit->name; ++unit)
        if (nqm_bench_has_unit(unit))
            new_meter(bench, unit, 0);
}

int nqm_bench_peak_meter(const nqm_bench *bench, nqm_precision precision) {
    int best = NQM_METER_NONE;
    for (int i = 0; i < bench->n_meters; ++i) {
        const nqm_bench_unit *unit = bench->meter[i].unit;
        if (unit && unit->precision <= precision &&
            (best == NQM_METER_NONE ||
             nqm_bench_meter_peak(&bench->meter[i]) > nqm_bench_meter_peak(&bench->meter[best])))
            best = i;
    }
    return best;
}

int nqm_bench_read_meter(nqm_bench *bench, size_t n_bytes) {
    n_bytes = nqm_smaller(n_bytes, bench->memory_bytes) / READ_BYTES * READ_BYTES;
    return n_bytes < READ_BYTES * thread_count() ? NQM_METER_NONE : new_meter(bench, NULL, n_bytes);
}

/* Other programs can only lower rates by the clock. Rates by processor time have errors of both signs, because a
 * hypervisor books stolen time inaccurately. */
double nqm_bench_meter_peak(const nqm_bench_meter *meter) {
    double sorted[NQM_METER_SAMPLES];
    const size_t n = nqm_smaller(meter->n_samples, NQM_METER_SAMPLES);
    if (meter->bytes)
        return meter->best;
    memcpy(sorted, meter->sample, n * sizeof *sorted);
    return nqm_quantile(n, sorted, 0.9);
}

nqm_status nqm_bench_take_memory(nqm_bench *bench, nqm_error *err) {
    if (bench->memory)
        return NQM_OK;
    bench->memory_bytes = bench->options.quick ? 16000000 : 256000000; /* more than the caches */
    bench->memory = nqm_alloc(bench->memory_bytes, 1);
    if (!bench->memory)
        return nqm_fail_nomem(err, bench->memory_bytes);
    return NQM_OK;
}

void nqm_bench_release_memory(nqm_bench *bench) {
    nqm_free(bench->memory);
    bench->memory = NULL;
}
