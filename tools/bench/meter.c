/* SPDX-License-Identifier: MIT
 *
 * Meters of the machine: how many operations or bytes a nanosecond it manages right now. Samples last milliseconds, so
 * that on a busy machine some fall between the others' turns; the best of all is the peak.
 */
#include "bench/inside.h"
#include "math/math.h"

#include <math.h>
#include <omp.h>
#include <sched.h>
#include <stdatomic.h>
#include <string.h>
#include <time.h>

enum {
    TIMINGS_A_SAMPLE = 3,
    READ_BYTES = 512, /* the loops read so much at once */
    MAX_STEPS = 1 << 30
};
#define TIMING_S 0.001

static volatile float float_sink;
static volatile uint64_t integer_sink;

/* What a thread of a meter does `steps` times. */
static void work(const nqm_bench *bench, const nqm_meter *meter, size_t thread) {
    if (meter->bytes) {
        const nqm_read_loop loop = nqm_read_loop_find(meter->kernels);
        const size_t n_lines = meter->bytes / READ_BYTES;
        const size_t first = thread * n_lines / meter->threads, last = (thread + 1) * n_lines / meter->threads;
        for (size_t i = 0; i < meter->steps; ++i)
            integer_sink = loop((last - first) * READ_BYTES, bench->memory + first * READ_BYTES);
        return;
    }
    uint32_t seed[64];
    const float factor = 0.999F, offset = 1e-3F; /* sums tend to 1 */
    for (size_t i = 0; i < 64; ++i)
        memcpy(&seed[i], i < 16 ? &factor : &offset, sizeof factor);
    float_sink = nqm_peak_loop_find(meter->kernels, meter->precision).run(meter->steps, seed);
}

/* Operations or bytes of `steps` steps of all threads, 1e9. */
static double amount(const nqm_meter *meter) {
    const double steps = 1e-9 * (double)meter->steps;
    if (meter->bytes)
        return steps * (double)meter->bytes;
    return steps * (double)meter->threads * nqm_peak_loop_find(meter->kernels, meter->precision).flop;
}

static double thread_clock_s(void) {
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Returns when all threads are here: spinning, because sleeping ones wake up at different times. */
static void meet(atomic_size_t *n_here, size_t n_threads) {
    atomic_fetch_add(n_here, 1);
    while (atomic_load(n_here) < n_threads)
        sched_yield();
}

/* The rate of all threads together. Arithmetic: what each did in its processor time, so that others on the machine are
 * left out. Reading: by the clock, because threads share the memory. */
static double measure(const nqm_bench *bench, const nqm_meter *meter) {
    double begin = INFINITY, end = 0, rate = 0;
    const double share = amount(meter) / (double)meter->threads;
    atomic_size_t n_here = 0;
#pragma omp parallel num_threads((int)meter->threads) reduction(min : begin) reduction(max : end) reduction(+ : rate)
    {
        meet(&n_here, (size_t)omp_get_num_threads());
        const double cpu_begin = thread_clock_s();
        begin = nqm_clock_s();
        work(bench, meter, (size_t)omp_get_thread_num());
        end = nqm_clock_s();
        rate = share / (thread_clock_s() - cpu_begin);
    }
    return meter->bytes ? amount(meter) / (end - begin) : rate;
}

/* As many steps as fill a timing. */
static void calibrate(const nqm_bench *bench, nqm_meter *meter) {
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
    nqm_meter *meter = &bench->meter[which];
    for (int i = 0; i < TIMINGS_A_SAMPLE && (!meter->bytes || bench->memory); ++i) {
        double rate = measure(bench, meter);
        meter->best = fmax(meter->best, rate);
        meter->sample[meter->n_samples++ % NQM_METER_SAMPLES] = rate;
    }
}

static int new_meter(nqm_bench *bench, const nqm_meter *facts) {
    for (int i = 0; i < bench->n_meters; ++i) {
        const nqm_meter *old = &bench->meter[i];
        if (strcmp(old->kernels, facts->kernels) == 0 && old->precision == facts->precision &&
            old->bytes == facts->bytes && old->threads == facts->threads)
            return i;
    }
    if (bench->n_meters == NQM_MAX_METERS)
        return NQM_METER_NONE;
    nqm_meter *meter = &bench->meter[bench->n_meters];
    *meter = *facts;
    calibrate(bench, meter);
    nqm_bench_sample(bench, bench->n_meters);
    return bench->n_meters++;
}

int nqm_bench_peak_meter(nqm_bench *bench, nqm_precision precision) {
    nqm_meter facts = {
        .kernels = nqm_kernels_selected(), .precision = precision, .threads = (size_t)omp_get_max_threads()};
    if (precision == NQM_PRECISION_BF16 && !nqm_peak_loop_find(facts.kernels, precision).run)
        facts.precision = NQM_PRECISION_F32;
    return nqm_peak_loop_find(facts.kernels, facts.precision).run ? new_meter(bench, &facts) : NQM_METER_NONE;
}

int nqm_bench_read_meter(nqm_bench *bench, size_t n_bytes, size_t threads) {
    if (n_bytes > bench->memory_bytes)
        n_bytes = bench->memory_bytes;
    if (n_bytes < READ_BYTES * threads)
        return NQM_METER_NONE;
    const nqm_meter facts = {
        .kernels = nqm_kernels_selected(), .bytes = n_bytes / READ_BYTES * READ_BYTES, .threads = threads};
    return new_meter(bench, &facts);
}

static double quantile(const nqm_meter *meter, double q) {
    double sorted[NQM_METER_SAMPLES];
    size_t n = meter->n_samples < NQM_METER_SAMPLES ? meter->n_samples : NQM_METER_SAMPLES;
    memcpy(sorted, meter->sample, n * sizeof *sorted);
    return nqm_quantile(n, sorted, q);
}

double nqm_bench_meter_median(const nqm_meter *meter) {
    return quantile(meter, 0.5);
}

/* Rates by the clock err to one side only. Those by processor time err to both: some of what a hypervisor took away is
 * subtracted in the wrong place. */
double nqm_bench_meter_peak(const nqm_meter *meter) {
    return meter->bytes ? meter->best : quantile(meter, 0.9);
}

nqm_status nqm_bench_take_memory(nqm_bench *bench, nqm_error *err) {
    if (bench->memory)
        return NQM_OK;
    bench->memory_bytes = (size_t)(1e6 * bench->options.memory_mb);
    bench->memory = nqm_alloc(bench->memory_bytes, 1);
    if (!bench->memory)
        return nqm_fail_nomem(err, bench->memory_bytes);
    return NQM_OK;
}

void nqm_bench_release_memory(nqm_bench *bench) {
    nqm_free(bench->memory);
    bench->memory = NULL;
}
