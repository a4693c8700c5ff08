/* SPDX-License-Identifier: MIT
 *
 * bench.h - inside the bench module: meters of what the machine can do, timing of several ways in turns, and rows that
 * are settled when all peaks are known. nqm/bench.h says what the figures mean.
 */
#ifndef NQM_SRC_BENCH_H
#define NQM_SRC_BENCH_H

#include "base/base.h"
#include "bench/bench.h"
#include "kernel/kernel.h"

/* ---- loops that reach the peaks (loops.c) ------------------------------------------------------------------------ */

/** A loop that does nothing but one kind of instruction, on enough independent sums. */
typedef struct nqm_peak_loop {
    float (*run)(size_t n, const uint32_t *seed); /**< seed (64); NULL: this processor has no such instruction */
    double flop;                                  /**< operations of one step of n */
} nqm_peak_loop;
/** The one for the instruction set of a table of kernels. */
nqm_peak_loop nqm_peak_loop_find(const char *kernels, nqm_precision precision);
/** A loop that reads memory: n_bytes, a multiple of 512, at an address aligned to 64 bytes. Returns a sum of it. */
typedef uint64_t (*nqm_read_loop)(size_t n_bytes, const void *data);
nqm_read_loop nqm_read_loop_find(const char *kernels);

/* ---- meters (meter.c) -------------------------------------------------------------------------------------------- */

enum { NQM_METER_NONE = -1, NQM_MAX_METERS = 128, NQM_METER_SAMPLES = 512 };

/** A rate of the machine that is measured again and again: operations, or bytes, a nanosecond. */
typedef struct nqm_meter {
    const char *kernels;     /**< whose instructions */
    nqm_precision precision; /**< of arithmetic */
    size_t bytes;            /**< of reading: the array's size; 0: a meter of arithmetic */
    size_t threads;
    size_t steps; /**< of one timing */
    double best;
    double sample[NQM_METER_SAMPLES]; /**< the last ones */
    size_t n_samples;                 /**< ever taken */
} nqm_meter;

/** A timed figure, before it is settled. */
typedef struct nqm_bench_entry {
    nqm_bench_row row;
    int peak, peak_f32, read; /**< meters, or NQM_METER_NONE */
    size_t alternative;       /**< how many entries before stands the other way to the same result; 0: there is none */
} nqm_bench_entry;

struct nqm_bench {
    nqm_bench_options options;
    nqm_meter meter[NQM_MAX_METERS];
    int n_meters;
    unsigned char *memory; /**< what reading is measured on */
    size_t memory_bytes;
    nqm_bench_entry *entry;
    size_t n_entries;
    char **text; /**< strings of rows */
    size_t n_texts;
    double done, total; /**< of the benchmark that runs, for the progress */
};

/** The meter of arithmetic on all threads with the kernels in use. Without bfloat16 instructions its kernels work in
 *  float: then float's. NQM_METER_NONE: there is none. */
int nqm_bench_peak_meter(nqm_bench *bench, nqm_precision precision);
/** The meter of reading an array of n_bytes again and again. */
int nqm_bench_read_meter(nqm_bench *bench, size_t n_bytes, size_t threads);
/** Take a few milliseconds' samples of a meter; NQM_METER_NONE is allowed. */
void nqm_bench_sample(nqm_bench *bench, int which);
/** The peak: the best sample of reading, the 90th percentile of arithmetic. */
double nqm_bench_meter_peak(const nqm_meter *meter);
/** The median of a meter's samples. */
double nqm_bench_meter_median(const nqm_meter *meter);
/** Room for the array of the reading meters; nqm_bench_release_memory() gives it back meanwhile. */
NQM_MUST_CHECK nqm_status nqm_bench_take_memory(nqm_bench *bench, nqm_error *err);
void nqm_bench_release_memory(nqm_bench *bench);

/* ---- timing and rows (bench.c) ----------------------------------------------------------------------------------- */

/** One of several ways that are timed in turns. */
typedef struct nqm_contender {
    void (*run)(void *user);
    void *user;
} nqm_contender;

/**
 * Time n contenders in turns, with samples of the meters of their entries between them, and add a row for each.
 *
 * @param entries  (n) hold everything but the times
 * @return NQM_ERR_CANCELLED, NQM_ERR_NOMEM
 */
NQM_MUST_CHECK nqm_status nqm_bench_race(nqm_bench *bench, size_t n, const nqm_contender *contenders,
                                         const nqm_bench_entry *entries, nqm_error *err);
/** An entry with nothing in it, for our own code with the kernels in use on all threads. */
nqm_bench_entry nqm_bench_entry_make(const char *bench_name, const char *name);
/** Arithmetic of an entry in a precision. */
void nqm_bench_entry_work(nqm_bench *bench, nqm_bench_entry *entry, nqm_precision precision, double flop);
/** Bytes that an entry must read each time. */
void nqm_bench_entry_reading(nqm_bench *bench, nqm_bench_entry *entry, size_t n_bytes);
/** A copy of `text` that lives as long as the rows; NULL when out of memory. */
const char *nqm_bench_keep_text(nqm_bench *bench, const char *text);
/** Add an entry with the seconds (n) of its rounds, which are sorted, and the processor time of all. NQM_ERR_NOMEM. */
NQM_MUST_CHECK nqm_status nqm_bench_add_times(nqm_bench *bench, const nqm_bench_entry *entry, size_t n, double *seconds,
                                              double cpu_s, nqm_error *err);
/** Add an entry whose times are in its row. NQM_ERR_NOMEM. */
NQM_MUST_CHECK nqm_status nqm_bench_add(nqm_bench *bench, const nqm_bench_entry *entry, nqm_error *err);
/** One more of bench->total things is done; NQM_ERR_CANCELLED when the user wants to stop. */
NQM_MUST_CHECK nqm_status nqm_bench_step(nqm_bench *bench, const char *stage, nqm_error *err);
static inline bool nqm_bench_wants(const nqm_bench *bench, nqm_precision precision) {
    return bench->options.precisions >> precision & 1;
}

/** Seconds of processor time of all threads. */
double nqm_process_clock_s(void);

/* ---- the process and the machine (machine.c) --------------------------------------------------------------------- */

/** Begin to count the largest resident memory anew, where the system can (Linux). */
void nqm_reset_peak_memory(void);
/** Largest resident memory since then, or since the process began, 1e6 bytes; NaN: not known. */
double nqm_peak_memory_mb(void);

/* ---- something to train on (pairs.c) ----------------------------------------------------------------------------- */

/** 10 labelled pairs for each of n_refs references, always the same, at `directions`, which are copied. */
NQM_MUST_CHECK nqm_status nqm_bench_pairs(size_t n_refs, const nqm_directions *directions, nqm_dataset **dataset_ret,
                                          nqm_error *err);

/* ---- oneDNN beside us (library.c) -------------------------------------------------------------------------------- */

/** C (m, n) = A (m, k) B (k, n). */
typedef struct nqm_library_shape {
    size_t m, n, k;
} nqm_library_shape;
/** A product by oneDNN's matrix product primitive, on memory of its own. */
typedef struct nqm_library_product nqm_library_product;
/**
 * Make one, with B in the layout that the library likes best.
 *
 * @param trans_a      A is stored as (k, m), and B row-major: both are activations, as in a weight gradient
 * @param product_ret  NULL, and NQM_OK, when the library cannot do it on this machine, or is not there
 */
NQM_MUST_CHECK nqm_status nqm_library_product_create(nqm_precision precision, bool trans_a,
                                                     const nqm_library_shape *shape, nqm_library_product **product_ret,
                                                     nqm_error *err);
void nqm_library_product_run(void *product);
void nqm_library_product_free(nqm_library_product *product);
/** oneDNN's sgemm on its own threads; only where there is a product of it. */
void nqm_library_sgemm(const nqm_gemm *g);

#endif
