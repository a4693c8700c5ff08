/* SPDX-License-Identifier: MIT
 *
 * base.h - services for every room: failing with a message, checked allocation, mapped input files, output files that
 * appear only when complete, little-endian access, conversion of numbers in any locale, random numbers with explicit
 * state, parallel loops and SHA-256. Knows nothing of BRDFs.
 */
#ifndef NQM_SRC_BASE_H
#define NQM_SRC_BASE_H

#include <nqm/base.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

/* ---- errors ------------------------------------------------------------------------------------------------------ */

/** Fill `err` (NULL allowed) and return `status`, so that `return nqm_fail(...)` is the one way to fail. */
__attribute__((format(printf, 4, 5))) nqm_status nqm_fail(nqm_error *err, nqm_status status, int64_t byte_offset,
                                                          const char *format, ...);
/** The usual out-of-memory failure; the message states the requested size. */
nqm_status nqm_fail_nomem(nqm_error *err, size_t n_bytes);

/* ---- memory ------------------------------------------------------------------------------------------------------ */

/** n * size zeroed bytes, 64-byte aligned; NULL when out of memory, when the product overflows, or in a test build when
 *  nqm_alloc_fail_after() asks for it. n or size 0 gives a unique non-NULL block. Free with nqm_free(). */
void *nqm_alloc(size_t n, size_t size);
/** Free a block of nqm_alloc(); NULL allowed. */
void nqm_free(void *block);
/** One of several arrays that share a block. */
typedef struct nqm_array {
    void *pointer;  /**< address of a pointer variable; receives the array's address */
    size_t n, size; /**< elements, and bytes of each */
} nqm_array;
/** Allocate zeroed, 64-byte aligned arrays in one block. The first array owns the block: nqm_free() of it frees all of them.
 *  On failure all pointers are NULL. */
NQM_MUST_CHECK nqm_status nqm_alloc_arrays(size_t n_arrays, const nqm_array *arrays, nqm_error *err);
/** The arguments of nqm_alloc_arrays() but the last, from {&pointer, n, size}, ... */
#define NQM_ARRAYS(...)                                                                                                \
    sizeof((nqm_array[]){__VA_ARGS__}) / sizeof(nqm_array), (const nqm_array[]) {                                      \
        __VA_ARGS__                                                                                                    \
    }
/** As nqm_alloc(), for large blocks that several threads fill: whole pages, large ones where the system has them, which are
 *  cleared when they are first touched, each by the thread that does. Free with nqm_free_pages(). */
void *nqm_alloc_pages(size_t n, size_t size);
/** Free a block of nqm_alloc_pages(), with its n and size; NULL allowed. */
void nqm_free_pages(void *block, size_t n, size_t size);
/** A copy of a string, or NULL when out of memory; free with nqm_free(). */
char *nqm_strdup(const char *text);
static inline size_t nqm_smaller(size_t a, size_t b) {
    return a < b ? a : b;
}
static inline size_t nqm_larger(size_t a, size_t b) {
    return a > b ? a : b;
}
/** a / b, rounded up; b is not 0. */
static inline size_t nqm_ceil_div(size_t a, size_t b) {
    return a / b + (a % b != 0);
}
/** true and *product = a * b, or false on overflow. */
bool nqm_mul_size(size_t a, size_t b, size_t *product);

/* ---- files ------------------------------------------------------------------------------------------------------- */

/** A file mapped read-only. `data` is NULL for an empty file. */
typedef struct nqm_map {
    const unsigned char *data;
    size_t n_bytes;
    const char *path; /**< borrowed; for messages */
    bool has_fd;      /**< the file is open as `fd`: nqm_map_open_sparse() */
    int fd;
} nqm_map;

/** A few bytes of a file, and where they go. */
typedef struct nqm_piece {
    size_t offset;
    void *out;
} nqm_piece;

/** Map a regular file. Directories, missing and unreadable files give NQM_ERR_IO with a plain message. The pages are
 *  not read until they are touched. `path` must outlive the map. */
NQM_MUST_CHECK nqm_status nqm_map_open(const char *path, nqm_map *map_ret, nqm_error *err);
/** The same for a file of which perhaps only a little is read: touching a page loads that page only, until
 *  nqm_map_expect(). The file stays open for nqm_map_gather(), unless the process has hundreds of files open. */
NQM_MUST_CHECK nqm_status nqm_map_open_sparse(const char *path, nqm_map *map_ret, nqm_error *err);
/** End the loading of single pages. `everything`: most of the map is read next, the system is asked to fetch it at once.
 */
void nqm_map_expect(const nqm_map *map, bool everything);
/** Copy n pieces of n_each bytes out of a map. Where the map has a file they are read from that: a page fault costs more
 *  than reading a piece. Pieces that are not cached are fetched from the disk concurrently, neighbours together.
 *  Bytes beyond the end of the file, even if it was truncated meanwhile, read as 0xff. Reorders `pieces`. */
void nqm_map_gather(const nqm_map *map, size_t n, nqm_piece *pieces, size_t n_each);
/** For maps that are kept but not gathered from: close their file, if they have one. */
void nqm_map_close_file(nqm_map *map);
/** Unmap; a zeroed map is allowed. */
void nqm_map_close(nqm_map *map);

/** An output file that is written under a temporary name in the same folder and renamed when complete. Devices, pipes and
 *  everything below /dev are written in place. */
typedef struct nqm_outfile {
    FILE *stream;
    char *path;      /* owned, with `temporary` in the same block */
    char *temporary; /* NULL: written in place */
} nqm_outfile;

/** Open `PATH.XXXXXX.part` for writing. */
NQM_MUST_CHECK nqm_status nqm_outfile_open(const char *path, nqm_outfile *out_ret, nqm_error *err);
/** Flush, sync and rename to the final name. On failure the temporary file is removed. Ends the outfile either way. */
NQM_MUST_CHECK nqm_status nqm_outfile_commit(nqm_outfile *out, nqm_error *err);
/** Remove the temporary file; a zeroed or committed outfile is allowed. */
void nqm_outfile_abort(nqm_outfile *out);

/* ---- little-endian values at any alignment ----------------------------------------------------------------------- */

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "files are read and written in the byte order of the host");

#define NQM_LITTLE_ENDIAN(NAME, TYPE)                                                                                  \
    static inline TYPE nqm_load_##NAME(const unsigned char *p) {                                                       \
        TYPE v;                                                                                                        \
        memcpy(&v, p, sizeof v);                                                                                       \
        return v;                                                                                                      \
    }                                                                                                                  \
    static inline void nqm_store_##NAME(unsigned char *p, TYPE v) {                                                    \
        memcpy(p, &v, sizeof v);                                                                                       \
    }
NQM_LITTLE_ENDIAN(u16, uint16_t)
NQM_LITTLE_ENDIAN(u32, uint32_t)
NQM_LITTLE_ENDIAN(u64, uint64_t)
NQM_LITTLE_ENDIAN(f32, float)
NQM_LITTLE_ENDIAN(f64, double)

/* ---- conversion of numbers in any locale -------------------------------------------------------------------------- */

/** Parse a decimal number at `text`; *end points after it. false when there is none. inf and nan are refused. */
bool nqm_parse_double(const char *text, const char **end, double *value);
/** Print with the fewest digits that read back to the same double ("0.1"). Returns `buffer` (32 bytes at least). */
char *nqm_format_double(char *buffer, size_t n_buffer, double value);
/** The double nearest to `value` with so many significant decimal digits (1..15), which then prints with no more. */
double nqm_round_digits(double value, int n_digits);

/* ---- random numbers (xoshiro256**, Blackman and Vigna 2021, DOI 10.1145/3460772) --------------------------------- */

typedef struct nqm_rng {
    uint64_t s[4];
} nqm_rng;

/** A generator for (seed, stream): different streams of one seed are independent. */
nqm_rng nqm_rng_make(uint64_t seed, uint64_t stream);
uint64_t nqm_rng_u64(nqm_rng *rng);
/** Uniform in [0, 1), 53 bits. */
double nqm_rng_uniform(nqm_rng *rng);
/** Standard normal (Box-Muller, one of the pair; no hidden state). */
double nqm_rng_normal(nqm_rng *rng);
/** Uniform integer in [0, n), n > 0, without bias. */
uint64_t nqm_rng_below(nqm_rng *rng, uint64_t n);
/** Shuffle idx[n] (Fisher-Yates). */
void nqm_rng_shuffle(nqm_rng *rng, size_t n, size_t *idx);
/** A counter-based hash: 64 well-mixed bits of (seed, counter); the same whatever the order of calls (splitmix64). */
uint64_t nqm_hash_u64(uint64_t seed, uint64_t counter);
/** The same in two steps, for loops: nqm_hash_u64(seed, counter) = nqm_hash_keyed(nqm_hash_key(seed), counter). */
static inline uint64_t nqm_hash_mix(uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}
#define NQM_GOLDEN 0x9e3779b97f4a7c15u /* 2^64 / golden ratio */
static inline uint64_t nqm_hash_key(uint64_t seed) {
    return nqm_hash_mix(seed + NQM_GOLDEN);
}
static inline uint64_t nqm_hash_keyed(uint64_t key, uint64_t counter) {
    return nqm_hash_mix(key + (counter + 1) * NQM_GOLDEN);
}

/* ---- parallel loops ---------------------------------------------------------------------------------------------- */

/** Call body(user, i) for i in [0, n) on the threads of OpenMP, dynamically scheduled. Bodies must write to places of
 *  their own, so that results do not depend on the number of threads. */
void nqm_parallel_for(size_t n, void (*body)(void *user, size_t i), void *user);

/* ---- SHA-256 ----------------------------------------------------------------------------------------------------- */

typedef struct nqm_sha256 {
    void *context;
} nqm_sha256;

/** Start; false when out of memory. */
bool nqm_sha256_begin(nqm_sha256 *sha);
void nqm_sha256_add(nqm_sha256 *sha, const void *data, size_t n_bytes);
/** Finish and free: 64 lower-case hex digits and NUL. */
void nqm_sha256_end(nqm_sha256 *sha, char hex[65]);

/* ---- progress ---------------------------------------------------------------------------------------------------- */

/** A progress callback with its user pointer, thinned to a few calls a second. A zeroed one is silent. */
typedef struct nqm_ticker {
    nqm_progress_fn fn;
    void *user;
    double next_s; /**< monotonic time of the next call */
} nqm_ticker;

/** Report done/total of `stage` if it is time to (always when done >= total). true: the caller must stop. */
bool nqm_tick(nqm_ticker *ticker, const char *stage, double done, double total);
/** Seconds of the monotonic clock; for progress and benchmarks only. */
double nqm_clock_s(void);

/* clang-tidy sees one file at a time: tell it that these never return NQM_OK. */
#ifdef __clang_analyzer__
#define nqm_fail(err, status, ...)   (nqm_fail((err), (status), __VA_ARGS__), (status))
#define nqm_fail_nomem(err, n_bytes) (nqm_fail_nomem((err), (n_bytes)), NQM_ERR_NOMEM)
#endif

#endif
