/* SPDX-License-Identifier: MIT
 *
 * bench.h - benchmarks of this library together with the limits of the machine: peaks of arithmetic and memory are
 * measured between the timings, so that each result has a limit from the same minutes.
 *
 * Other programs only ever make a timing longer. Each result is therefore timed in several rounds, in turns with the
 * others; the best round counts, and the median shows how busy the machine was.
 */
#ifndef NQM_BENCH_BENCH_H
#define NQM_BENCH_BENCH_H

#include "base/options.h"
#include "kernel/kernel.h"

#include <jansson.h>
#include <nqm/train.h>

/* ---- the machine (machine.c) ------------------------------------------------------------------------------------- */

/** Facts about the machine and this build, for the results. */
json_t *nqm_bench_machine(void);
/** Restart the measurement of the largest resident memory, where the system can (Linux). */
void nqm_bench_reset_peak_memory(void);
/** Largest resident memory since then, or since the process began, 1e6 bytes; NaN: unknown. */
double nqm_bench_peak_memory_mb(void);
/** Processor time of all threads, seconds. */
double nqm_bench_process_clock_s(void);

/* ---- benchmarks -------------------------------------------------------------------------------------------------- */

typedef struct nqm_bench_options {
    size_t rounds;       /* timings of each result; 1 to 1000; default 7 */
    int quick;           /* 1: fewer and smaller problems and rounds, which test the benchmarks but do not measure */
    int precision;       /* gemm, train: an nqm_precision; default 2: both */
    const char *kernels; /* nqm_kernels_name(); NULL: the best */
    const char *recipe;  /* train: default "paper" */
    size_t seeds;        /* train: repeat with seeds 1 to this; 1 to 100; default 1 */
    size_t epochs;       /* train: 1 to 10000; default 0: the recipe's */
    const char *model;   /* score: a built-in model or a file; NULL: all built-in models */
    size_t n_files;      /* load */
    const char *const *files; /* (n_files) arguments for nqm_brdf_open() */
} nqm_bench_options;
/** The defaults above. */
nqm_bench_options nqm_bench_options_default(void);
/** The options of the command line. */
extern const nqm_option_table nqm_bench_option_table;

/** Meters of the machine's peaks, and result rows. Use it from one thread only. */
typedef struct nqm_bench nqm_bench;

/** Create, and measure the peaks for the first time. NQM_ERR_ARG (an option outside its range), NQM_ERR_NOMEM. */
NQM_MUST_CHECK nqm_status nqm_bench_create(const nqm_bench_options *options, nqm_bench **bench_ret, nqm_error *err);
/** NULL is allowed. */
void nqm_bench_free(nqm_bench *bench);

/** A benchmark, which adds its rows. */
typedef nqm_status nqm_bench_fn(nqm_bench *bench, nqm_error *err);

/** The forward matrix products of layers 1 and 2 of the network of `paper` for a batch of 512. Quick: layer 2 only. */
NQM_MUST_CHECK nqm_bench_fn nqm_bench_gemm;
/** nqm_train() on a generated dataset of the paper's size: 5,344 training and 668 validation pairs under the recipe "paper".
 *  One row for each seed and precision. Median and worst time are those of the epochs times their number. Quick: a
 *  thirtieth of the pairs. */
NQM_MUST_CHECK nqm_bench_fn nqm_bench_train;
/** Scoring of 1, 9, 180 and 512 pairs: the network alone, everything from samples to JOD, and to its gradient (1 and 512
 *  pairs). Quick: 1 and 9 pairs. */
NQM_MUST_CHECK nqm_bench_fn nqm_bench_score;
/** From a file to samples at the default directions - nqm_brdf_open(), nqm_sample(), nqm_brdf_free() - with its pages in
 *  memory. */
NQM_MUST_CHECK nqm_bench_fn nqm_bench_load;

/** Measure the peaks for the last time, add them as rows after the timings, complete all rows, and return the document.
 *  NULL: out of memory. json_decref() it. */
json_t *nqm_bench_finish(nqm_bench *bench);

/* ==== shared by the benchmarks ==================================================================================== */

/* ---- loops that reach the peaks (loops.c) ------------------------------------------------------------------------ */

/** A kind of multiply-add instruction. */
typedef struct nqm_bench_unit {
    const char *name;           /* NULL ends the list */
    nqm_precision precision;    /* precision of the factors */
    const nqm_kernels *kernels; /* that processors with the unit can run */
    /* n steps of that instruction only, with enough independent accumulators to hide its latency; seed (64). */
    float (*run)(size_t n, const uint32_t *seed);
    double flop; /* operations per step; a multiplication and an addition are two */
} nqm_bench_unit;
/** All units of this architecture, those that this processor lacks included. */
extern const nqm_bench_unit nqm_bench_units[];
/** Whether this processor has a unit of this list. */
bool nqm_bench_has_unit(const nqm_bench_unit *unit);
/** Read n_bytes, a multiple of 512, at an address aligned to 64 bytes, by the widest loads. Returns a sum of it. */
uint64_t nqm_bench_read(size_t n_bytes, const void *data);

/* ---- meters (meter.c) -------------------------------------------------------------------------------------------- */

enum { NQM_METER_NONE = -1, NQM_MAX_METERS = 128, NQM_METER_SAMPLES = 512 };

/** A rate of all threads that is sampled repeatedly: operations or bytes per nanosecond. */
typedef struct nqm_bench_meter {
    const nqm_bench_unit *unit; /* arithmetic unit that is measured; NULL: reading is measured */
    size_t bytes;               /* size of the array that is read */
    size_t steps;               /* per timing */
    double best;
    double sample[NQM_METER_SAMPLES]; /* ring buffer of the latest ones */
    size_t n_samples;                 /* ever taken */
} nqm_bench_meter;

/** A result. Unknown numbers are 0. */
typedef struct nqm_bench_entry {
    void (*run)(void *user); /* what nqm_bench_race() times */
    void *user;
    json_t *row;         /* texts and counts that describe it; nqm_bench_finish() adds the numbers */
    double gflop;        /* 1e9 operations of a call; a multiplication and an addition are two */
    double megabytes;    /* data that a call must read, 1e6 bytes */
    double best, median; /* times of the rounds, seconds */
    double cpu;          /* least processor time of a round / threads, seconds: other programs hardly change it */
    double cpu_share;    /* processor time / (time * threads); below 1: waiting, or other programs ran */
    int peak, read;      /* meters, or NQM_METER_NONE */
} nqm_bench_entry;

struct nqm_bench {
    nqm_bench_options options;
    nqm_bench_meter meter[NQM_MAX_METERS];
    int n_meters;
    unsigned char *memory; /* (memory_bytes), for the reading meters */
    size_t memory_bytes;
    nqm_bench_entry *entry; /* (n_entries) */
    size_t n_entries, max_entries;
};

/** Make a meter for each unit that this processor has. */
void nqm_bench_add_units(nqm_bench *bench);
/** The meter of the quickest unit that can compute products of factors of a precision: a unit with wider factors can. */
int nqm_bench_peak_meter(const nqm_bench *bench, nqm_precision precision);
/** The meter of reading an array of n_bytes repeatedly. */
int nqm_bench_read_meter(nqm_bench *bench, size_t n_bytes);
/** Sample a meter for a few milliseconds; NQM_METER_NONE is allowed. */
void nqm_bench_sample(nqm_bench *bench, int which);
/** The peak: the best sample of reading, the 90th percentile of arithmetic. */
double nqm_bench_meter_peak(const nqm_bench_meter *meter);
/** Allocate the array of the reading meters, if it is not there; free it while a benchmark measures its own memory. */
NQM_MUST_CHECK nqm_status nqm_bench_take_memory(nqm_bench *bench, nqm_error *err);
void nqm_bench_release_memory(nqm_bench *bench);

/* ---- timings and rows (bench.c) ---------------------------------------------------------------------------------- */

/** Time n entries in turns, sample their meters in between, and add a row for each. entries (n): all but the times; takes
 *  their rows. NQM_ERR_NOMEM. */
NQM_MUST_CHECK nqm_status nqm_bench_race(nqm_bench *bench, size_t n, const nqm_bench_entry *entries, nqm_error *err);
/** An entry for our own code with the selected kernels on all threads. */
nqm_bench_entry nqm_bench_entry_make(const char *bench_name, const char *name, void (*run)(void *user), void *user);
/** Set precision and operations of an entry, and its meter of arithmetic. */
void nqm_bench_entry_work(nqm_bench *bench, nqm_bench_entry *entry, nqm_precision precision, double flop);
/** Set the bytes that each call must read, and the meter of reading. */
void nqm_bench_entry_reading(nqm_bench *bench, nqm_bench_entry *entry, size_t n_bytes);
/** Add a text, a count or a number to the row of an entry. */
static inline void nqm_bench_text(nqm_bench_entry *entry, const char *key, const char *text) {
    json_object_set_new(entry->row, key, json_string(text));
}
static inline void nqm_bench_count(nqm_bench_entry *entry, const char *key, size_t count) {
    json_object_set_new(entry->row, key, json_integer((json_int_t)count));
}
/** A number that is not finite and greater than 0 is not added. */
void nqm_bench_number(nqm_bench_entry *entry, const char *key, double number);
/** Add an entry with its times; takes its row. NQM_ERR_NOMEM. */
NQM_MUST_CHECK nqm_status nqm_bench_add(nqm_bench *bench, const nqm_bench_entry *entry, nqm_error *err);
static inline bool nqm_bench_has_precision(const nqm_bench *bench, nqm_precision precision) {
    return bench->options.precision > NQM_PRECISION_BF16 || bench->options.precision == (int)precision;
}

/* ---- pairs for training and scoring (pairs.c) -------------------------------------------------------------------- */

/** 10 labelled pairs for each of n_refs generated references, always the same, at `directions`, which are copied. */
NQM_MUST_CHECK nqm_status nqm_bench_pairs(size_t n_refs, const nqm_directions *directions, nqm_dataset **dataset_ret,
                                          nqm_error *err);

#endif
