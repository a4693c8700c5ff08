/* SPDX-License-Identifier: MIT
 *
 * nqm/bench.h - how fast this library is on this machine, beside what the machine can do: the peaks of its arithmetic and
 * of its memory are measured between the timings, so that every figure stands beside a limit of the same minutes.
 *
 * Other programs on the machine disturb timings in one direction only. So each figure is timed in several rounds that
 * take turns with the others; the best round counts, and the median and the worst say how quiet the machine was.
 */
#ifndef NQM_BENCH_H
#define NQM_BENCH_H

#include <nqm/train.h>

/** The machine; strings are lent by static storage. 0 or "": not known. */
typedef struct nqm_bench_machine {
    const char *cpu;     /**< model name of the processor */
    const char *system;  /**< operating system and release */
    size_t cores;        /**< that this process may use */
    size_t threads;      /**< that this process computes with */
    double mhz;          /**< clock as the system states it */
    size_t cache_kib[3]; /**< of one core's first, second and the shared third level of data cache */
    double memory_mb;    /**< of the machine, 1e6 bytes */
    double load;         /**< load average of the last minute: above 0.1 the machine is not quiet */
} nqm_bench_machine;
/** Find out; not while another thread does. */
nqm_bench_machine nqm_bench_get_machine(void);

/** One figure. What does not apply is NULL, 0 for counts, NaN for numbers, -1 for the precision. Strings are lent by the
 *  benchmark. */
typedef struct nqm_bench_row {
    const char *bench;   /**< "peak", "gemm", "train", "score", "load" */
    const char *name;    /**< what was timed: "layer 1 forward" */
    const char *subject; /**< the file or command */
    const char *model;   /**< the network: "paper", "default", a recipe */
    const char *by;      /**< whose code: "nqm", "onednn sgemm", "onednn" */
    const char *kernels; /**< nqm_kernels_name() in use */
    int precision;       /**< an nqm_precision */
    size_t batch, threads, epochs, seed;
    size_t pairs;          /**< of training, with the scaled copies */
    size_t layer;          /**< of the network, from 1 */
    size_t m, n, k;        /**< of a matrix product */
    size_t rounds;         /**< timings */
    double seconds;        /**< of the best round */
    double seconds_median; /**< of the rounds */
    double seconds_worst;  /**< of the rounds */
    double ms_per_pair;    /**< 1000 seconds / pairs */
    double gflop;          /**< arithmetic, 1e9 operations: a multiplication and an addition are two */
    double gflops;         /**< gflop / seconds */
    /** What the instructions of this precision reached on all threads meanwhile, in processor time: the 90th percentile of
     *  its samples. */
    double peak_gflops;
    double peak_median;     /**< median of the same samples */
    double megabytes;       /**< that must be read, 1e6 bytes */
    double gb_per_s;        /**< megabytes / seconds / 1000 */
    double peak_gb_per_s;   /**< best reading rate of an array of that size meanwhile */
    double floor_seconds;   /**< the longer of gflop / peak_gflops and megabytes / peak_gb_per_s */
    double floor_f32;       /**< gflop at the peak of float: shorter where 16 bits are no faster */
    double ratio;           /**< floor_seconds / seconds: 1 is all the machine can do */
    double times_floor;     /**< seconds / floor_seconds */
    double cpu_share;       /**< processor time / (seconds threads): below 1 waiting, or others had the processor */
    double max_rss_mb;      /**< largest resident memory of the process meanwhile, 1e6 bytes */
    double train_loss;      /**< of the last epoch */
    double validation_loss; /**< of the last epoch */
    double best_epoch_seconds;
    double seconds_100;       /**< extrapolated to 100 epochs, when there were fewer */
    double times_alternative; /**< seconds of the other way to the same result / seconds */
} nqm_bench_row;

/** What to measure how long. */
typedef struct nqm_bench_options {
    size_t rounds;       /**< timings of each figure; 1..1000; default 7 */
    double round_s;      /**< seconds that one timing takes at least; 1e-4..10; default 0.01 */
    int quick;           /**< 1: fewer and smaller problems: to see that everything works, not how fast; default 0 */
    unsigned precisions; /**< bits 1 << nqm_precision; default all */
    double memory_mb;    /**< size of the array that memory is read from, 1e6 bytes; above all caches; 1..65536; default
                              256 */
    nqm_progress_fn progress;
    void *progress_user;
} nqm_bench_options;
/** The defaults above. */
nqm_bench_options nqm_bench_options_default(void);

/** Meters of the machine's peaks, and rows. Belongs to one thread. */
typedef struct nqm_bench nqm_bench;

/** Begin: measures the peaks for the first time. options NULL: the defaults. NQM_ERR_ARG, NQM_ERR_NOMEM,
 *  NQM_ERR_CANCELLED. */
NQM_MUST_CHECK nqm_status nqm_bench_create(const nqm_bench_options *options, nqm_bench **bench_ret, nqm_error *err);
/** Free it with its rows; NULL is allowed. */
void nqm_bench_free(nqm_bench *bench);

/**
 * The matrix products of the networks of `paper` and `default`, each hidden layer forward, back to its input and to its
 * weights' gradient, in the kernels in use (nqm_kernels_select()), beside oneDNN's. Batch 512; forward also 180 and 1.
 * Quick: layer 3 only.
 * NQM_ERR_NOMEM, NQM_ERR_CANCELLED.
 */
NQM_MUST_CHECK nqm_status nqm_bench_gemm(nqm_bench *bench, nqm_error *err);

/**
 * nqm_train() on a dataset made on the spot, of the paper's size: 5,344 training pairs and 668 for validation under the
 * recipe "paper". One row for each seed and precision (float, bfloat16): `seconds` is the whole training,
 * `best_epoch_seconds` the quickest epoch, seconds_median and _worst are those of the epochs times their number. Quick:
 * a thirtieth of the pairs.
 *
 * @param recipe   "paper", "notebook", "nqm"
 * @param epochs   0: the recipe's
 * @param n_seeds  trainings with the seeds 1 .. n_seeds
 * @return as nqm_train()
 */
NQM_MUST_CHECK nqm_status nqm_bench_train(nqm_bench *bench, const char *recipe, size_t epochs, size_t n_seeds,
                                          nqm_error *err);

/**
 * Scoring of 1, 9, 180 and 512 pairs in each precision: the network alone, and the chain from sampled pairs to JOD; each
 * pair with a reference of its own, and 9 tests with one reference, whose part of the first layer is then computed once.
 * The floor of one pair is reading the weights. Quick: 1 and 9 pairs. NQM_ERR_NOMEM, NQM_ERR_CANCELLED.
 */
NQM_MUST_CHECK nqm_status nqm_bench_score(nqm_bench *bench, const nqm_model *model, nqm_error *err);

/**
 * From a file to samples at `directions` - nqm_brdf_open(), nqm_sample(), nqm_brdf_free() - while its pages are in memory
 * ("warm"), and after they were dropped ("cold"; files on a disk only).
 *
 * @param folder  where a MERL table may lie for a moment, which is then loaded; NULL: no such table
 * @param files   (n_files) arguments for nqm_brdf_open()
 * @return as those functions, and NQM_ERR_CANCELLED
 */
NQM_MUST_CHECK nqm_status nqm_bench_load(nqm_bench *bench, const nqm_directions *directions, const char *folder,
                                         size_t n_files, const char *const *files, nqm_error *err);
/** A whole command from its start to its end, with its standard output thrown away. `name` is for the row.
 *
 * @param argv  the path of the program, its arguments, NULL
 * @return NQM_ERR_IO when it cannot be run or does not end with 0; NQM_ERR_CANCELLED
 */
NQM_MUST_CHECK nqm_status nqm_bench_command(nqm_bench *bench, const char *name, const char *const *argv,
                                            nqm_error *err);

/** Measure the peaks for the last time and settle all rows. NQM_ERR_NOMEM. */
NQM_MUST_CHECK nqm_status nqm_bench_finish(nqm_bench *bench, nqm_error *err);
/** Rows after nqm_bench_finish(): what was timed, in that order, then the peaks. */
size_t nqm_bench_count(const nqm_bench *bench);
nqm_bench_row nqm_bench_get_row(const nqm_bench *bench, size_t i);

#endif
