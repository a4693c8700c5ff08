/* SPDX-License-Identifier: MIT
 *
 * base.h - services for every module: error reporting, checked allocation, memory-mapped input files, output files that
 * appear only when complete, little-endian access, locale-independent number conversion, random numbers with explicit
 * state, parallel loops and SHA-256. It contains nothing specific to BRDFs.
 */
#ifndef NQM_SRC_BASE_H
#define NQM_SRC_BASE_H

#include <assert.h>
#include <nqm/base.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

/** Before a function: it is compiled for each width of vectors, and the widest that the processor has is called. */
#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(NQM_ONE_VECTOR_WIDTH)
#define NQM_FOR_EACH_VECTOR_WIDTH __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define NQM_FOR_EACH_VECTOR_WIDTH
#endif

/* ---- errors ------------------------------------------------------------------------------------------------------ */

/** Fill `err` (NULL allowed) and return `status`. Functions report every failure with `return nqm_fail(...)`. */
__attribute__((format(printf, 4, 5))) nqm_status nqm_fail(nqm_error *err, nqm_status status, int64_t byte_offset,
                                                          const char *format, ...);
/** Fail with NQM_ERR_NOMEM; the message states the requested size. */
nqm_status nqm_fail_nomem(nqm_error *err, size_t n_bytes);
/** Fail with NQM_ERR_ARG if one of n pointers is NULL; the message has its name. names: "first, second". */
NQM_MUST_CHECK nqm_status nqm_require(nqm_error *err, const char *function, const char *names, size_t n,
                                      const void *const *pointers);
/** Public functions begin with the pointers that must not be NULL. Those that return no status have assert() instead. */
#define NQM_REQUIRE(err, ...)                                                                                          \
    do {                                                                                                               \
        const void *const required[] = {__VA_ARGS__};                                                                  \
        if (nqm_require(err, __func__, #__VA_ARGS__, sizeof required / sizeof *required, required) != NQM_OK)          \
            return NQM_ERR_ARG;                                                                                        \
    } while (0)
/** The same for arrays of n elements. */
#define NQM_REQUIRE_IF(n, err, ...)                                                                                    \
    do {                                                                                                               \
        if (n)                                                                                                         \
            NQM_REQUIRE(err, __VA_ARGS__);                                                                             \
    } while (0)
/** The same for a function that makes an object: *ret is NULL then. */
#define NQM_MAKE(err, ret, ...)                                                                                        \
    do {                                                                                                               \
        if (ret)                                                                                                       \
            *(ret) = NULL;                                                                                             \
        NQM_REQUIRE(err, ret, __VA_ARGS__);                                                                            \
    } while (0)

/* ---- memory ------------------------------------------------------------------------------------------------------ */

/** Allocate n * size zeroed bytes, 64-byte aligned. Returns NULL when out of memory, when the product overflows, or
 *  when nqm_alloc_fail_after() makes this call fail. n or size 0 gives a unique non-NULL block. Free with
 *  nqm_free(). */
void *nqm_alloc(size_t n, size_t size);
/** Free a block returned by nqm_alloc(); NULL allowed. */
void nqm_free(void *block);
/** One of several arrays that share a block. */
typedef struct nqm_array {
    void *pointer;  /**< address of a pointer variable; receives the array's address. NULL: there is no such array */
    size_t n, size; /**< number of elements, and bytes per element */
} nqm_array;
/** Allocate zeroed, 64-byte aligned arrays in one block. The first array owns the block: nqm_free() of it frees all of
 *  them. On failure all pointers are NULL. */
NQM_MUST_CHECK nqm_status nqm_alloc_arrays(size_t n_arrays, const nqm_array *arrays, nqm_error *err);
/** Expands {&pointer, n, size}, ... to the arguments n_arrays and arrays of nqm_alloc_arrays(). */
#define NQM_ARRAYS(...)                                                                                                \
    sizeof((nqm_array[]){__VA_ARGS__}) / sizeof(nqm_array), (const nqm_array[]) {                                      \
        __VA_ARGS__                                                                                                    \
    }
/** As nqm_alloc(), for large blocks that several threads fill: whole pages, huge pages where the system supports them.
 *  The system zeroes a page when a thread first touches it. Free with nqm_free_pages(). */
void *nqm_alloc_pages(size_t n, size_t size);
/** Free a block returned by nqm_alloc_pages() for the same n and size; NULL allowed. */
void nqm_free_pages(void *block, size_t n, size_t size);
/** Enlarge a block of *max_n elements, if necessary, to at least n elements, and return it; *max_n at least doubles, so that
 *  appending is O(1) amortised. NULL when out of memory: the block is unchanged. Elements after the old ones are not zeroed. */
void *nqm_grow(void *block, size_t *max_n, size_t n, size_t size);
/** A copy of a string, or NULL when out of memory; free with nqm_free(). */
char *nqm_strdup(const char *text);
/** As sprintf(), into a string of its own; likewise. */
__attribute__((format(printf, 1, 2))) char *nqm_strdupf(const char *format, ...);
enum { NQM_REMARK_SIZE = 600 };
/** Append to a remark, of `size` bytes, what of an input is not used or is assumed: after "; ", unless it has it. A remark that gets too
 *  long ends with "...". */
__attribute__((format(printf, 3, 4))) void nqm_remark_add(char *remark, size_t size, const char *format, ...);
/** The path of a file that the file `path` names: `name` in the same folder; an absolute `name` unchanged. NULL when out of memory;
 *  free with nqm_free(). */
char *nqm_path_beside(const char *path, const char *name);
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
/** Store a * b in *product; false on overflow. */
bool nqm_mul_size(size_t a, size_t b, size_t *product);

/* ---- files ------------------------------------------------------------------------------------------------------- */

/** A file mapped read-only. `data` is NULL for an empty file. */
typedef struct nqm_map {
    const unsigned char *data;
    size_t n_bytes;
    const char *path; /**< owned by the caller; for messages */
    bool has_fd;      /**< the file is still open as `fd` (nqm_map_open_sparse()) */
    int fd;
} nqm_map;

/** The kind of a file is told from this many bytes at most, so that the time until a file is refused does not depend on
 *  its size. */
enum { NQM_PROBE_BYTES = 1 << 20 };

/** A short byte range of a file, and the buffer that receives it. */
typedef struct nqm_piece {
    size_t offset;
    void *out;
} nqm_piece;

/** Map a regular file. Directories, missing and unreadable files give NQM_ERR_IO. Pages are read when they are first
 *  touched. `path` must outlive the map. */
NQM_MUST_CHECK nqm_status nqm_map_open(const char *path, nqm_map *map_ret, nqm_error *err);
/** As nqm_map_open(), for a file that the same run may replace, because it continues what the file holds: it is no input. */
NQM_MUST_CHECK nqm_status nqm_map_open_own(const char *path, nqm_map *map_ret, nqm_error *err);
/** As nqm_map_open(), for a file of which often only a small part is read: read-ahead is off until nqm_map_expect(), so
 *  that touching a page loads only that page. The file stays open for nqm_map_gather(), unless the process has hundreds
 *  of files open. */
NQM_MUST_CHECK nqm_status nqm_map_open_sparse(const char *path, nqm_map *map_ret, nqm_error *err);
/** Turn read-ahead on again. `everything`: also prefetch the whole map, because most of it is read next. */
void nqm_map_expect(const nqm_map *map, bool everything);
/** Read n pieces of n_each bytes from the file of a map that has_fd: a page fault costs more than reading a piece. Pieces that are not
 *  in the page cache are fetched concurrently, adjacent ones together. Bytes beyond the end of the file, even if it was truncated
 *  meanwhile, are 0xff. Reorders `pieces`. */
void nqm_map_gather(const nqm_map *map, size_t n, nqm_piece *pieces, size_t n_each);
/** Unmap; a zeroed map is allowed. */
void nqm_map_close(nqm_map *map);

/** An output file that is written under a temporary name in the same folder and renamed when complete. Devices, pipes
 *  and everything below /dev are written in place. A file that is replaced passes on its permissions; through a symbolic
 *  link, the file that it points to is replaced. */
typedef struct nqm_outfile {
    FILE *stream;
    char *path;      /* owned, with `temporary` in the same block; of the file that a link points to */
    char *temporary; /* NULL: written in place */
} nqm_outfile;

/** Open `PATH.N.part` for writing, N the first number that no process is writing. NQM_ERR_IO for a write-protected file and for a
 *  symbolic link to nothing; NQM_ERR_ARG for an input of this run (nqm_roles_enforce()). */
NQM_MUST_CHECK nqm_status nqm_outfile_open(const char *path, nqm_outfile *out_ret, nqm_error *err);
/** Flush, sync and rename to the final name, and remove the temporary files that killed processes have left of it. On failure
 *  remove the temporary file. Closes the outfile in both cases. */
NQM_MUST_CHECK nqm_status nqm_outfile_commit(nqm_outfile *out, nqm_error *err);
/** Outputs that are replaced together: a material and its maps. Begin with {0}. */
typedef struct nqm_outset {
    size_t n, max_n;
    nqm_outfile *files; /* complete, under their temporary names */
} nqm_outset;

/** Complete an outfile as nqm_outfile_commit() does, but leave its renaming to the commit of the set, which owns it then.
 *  set: NULL: rename now. */
NQM_MUST_CHECK nqm_status nqm_outfile_keep(nqm_outfile *out, nqm_outset *set, nqm_error *err);
/** Rename all files of a set, in the order in which they were completed, if each of them may be renamed; else remove them all. */
NQM_MUST_CHECK nqm_status nqm_outset_commit(nqm_outset *set, nqm_error *err);
/** Remove the temporary files; a zeroed or committed set is allowed. */
void nqm_outset_abort(nqm_outset *set);
/** Remove the temporary file; a zeroed or committed outfile is allowed. */
void nqm_outfile_abort(nqm_outfile *out);
/** Unlink the temporary files of all outputs that are open. For signal handlers (it is async-signal-safe) of a process that ends
 *  at once. */
void nqm_outfile_unlink_all(void);

struct nqm_file_info; /* os.h */

/* Roles of files. No run of the tool replaces a file that it reads: the tool calls nqm_roles_enforce() first. From then on the
 * process keeps the identity of every file that it opens with nqm_map_open(), and of every existing file that it opens with
 * nqm_outfile_open(), by whatever path: 48 bytes for each, until it ends. Opening one as both, in either order, and renaming an
 * output over an input, give NQM_ERR_ARG. Threads may share the functions. */

/** Begin to keep and compare roles. There is no way back. */
void nqm_roles_enforce(void);
/** Make a file an input, for readers that do not use nqm_map_open(). */
NQM_MUST_CHECK nqm_status nqm_role_input(const struct nqm_file_info *file, const char *path, nqm_error *err);
/** Make a file an output, if it exists. */
NQM_MUST_CHECK nqm_status nqm_role_output(const char *path, nqm_error *err);
/** Remove the roles of a file that has been created or replaced: the system uses identities again. */
void nqm_role_forget(const struct nqm_file_info *file);

/* ---- little-endian values at any alignment ----------------------------------------------------------------------- */

enum { NQM_BIG_ENDIAN = __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__ };

/** Copy n values of n_each bytes (1, 2, 4 or 8) from the byte order of the host to little-endian, or back. The memory must not
 *  overlap. */
static inline void nqm_copy_little_endian(size_t n, size_t n_each, const void *from, void *to) {
    const unsigned char *bytes = (const unsigned char *)from;
    if (!NQM_BIG_ENDIAN)
        memcpy(to, from, n * n_each);
    for (size_t i = 0; NQM_BIG_ENDIAN && i < n * n_each; ++i)
        ((unsigned char *)to)[i] = bytes[i ^ (n_each - 1)]; /* the mirrored byte of the same value */
}

#define NQM_LITTLE_ENDIAN(NAME, TYPE)                                                                                  \
    static inline TYPE nqm_load_##NAME(const unsigned char *p) {                                                       \
        TYPE v;                                                                                                        \
        nqm_copy_little_endian(1, sizeof v, p, &v);                                                                    \
        return v;                                                                                                      \
    }                                                                                                                  \
    static inline void nqm_store_##NAME(unsigned char *p, TYPE v) {                                                    \
        nqm_copy_little_endian(1, sizeof v, &v, p);                                                                    \
    }
NQM_LITTLE_ENDIAN(u16, uint16_t)
NQM_LITTLE_ENDIAN(u32, uint32_t)
NQM_LITTLE_ENDIAN(u64, uint64_t)
NQM_LITTLE_ENDIAN(f32, float)
NQM_LITTLE_ENDIAN(f64, double)

/** Write n values of n_each bytes in little-endian order; the stream's error flag tells of failures. */
void nqm_write_values(FILE *stream, size_t n, size_t n_each, const void *values);

/** An unsigned integer of n_bytes (1 to 8) in either byte order. */
uint64_t nqm_load_integer(const unsigned char *p, size_t n_bytes, bool big_endian);
/** The type of a number in a file: a signed ('i') or unsigned ('u') integer of 1 to 8 bytes, or an IEEE float ('f') of 4 or
 *  8 bytes. */
typedef struct nqm_number_type {
    char kind;
    unsigned char n_bytes;
} nqm_number_type;
double nqm_load_number(const unsigned char *p, nqm_number_type type, bool big_endian);

/** Load a shared library with the functions of these names (n), and store their addresses in `functions`, a struct of n function
 *  pointers. It is never unloaded. false: it is not installed, or lacks a function. Linking a library would slow the start of every
 *  program, including those that never use it (doc/performance.md, "Loading and start"). */
bool nqm_dynamic_load(const char *soname, size_t n, const char *const *names, void *functions);

/** A file that is embedded at build time (cmake/models.cmake). */
typedef struct nqm_embedded_file {
    const char *name;           /**< the file's name without folder and extension; NULL ends a table */
    const unsigned char *begin; /**< the whole file, 64-byte aligned */
    const unsigned char *end;
} nqm_embedded_file;
/** "default" in libnqm, "default" and "paper" in libnqm-full and the tool. */
extern const nqm_embedded_file nqm_embedded_models[];

/* ---- names ------------------------------------------------------------------------------------------------------- */

/** A list of strings; a zeroed list is empty. */
typedef struct nqm_names {
    size_t n, max_n, n_text, max_text;
    size_t *start; /* (n) offset of each string in `text` */
    char *text;    /* (n_text) NUL-terminated strings */
} nqm_names;

/** The i-th string, i < n; valid until the next string is added. */
static inline const char *nqm_name(const nqm_names *names, size_t i) {
    return names->text + names->start[i];
}
/** Append a string of n_bytes without NUL. */
NQM_MUST_CHECK nqm_status nqm_names_add(nqm_names *names, const char *name, size_t n_bytes, nqm_error *err);
/** Find a string, or append it; *index_ret is its index. The search is linear and starts at the end. */
NQM_MUST_CHECK nqm_status nqm_names_intern(nqm_names *names, const char *name, size_t n_bytes, uint32_t *index_ret,
                                           nqm_error *err);
void nqm_names_free(nqm_names *names);

/** Whether a file name ends in `suffix` (any case) and has something before it. */
bool nqm_name_ends_in(const char *path, const char *suffix);
/** Whether the first n characters of two strings are equal, ASCII letters in any case; n: SIZE_MAX: all. */
bool nqm_equal_any_case(const char *a, const char *b, size_t n);

/** The name among several that is most like a misspelt one. */
typedef struct nqm_nearest {
    const char *wanted;
    size_t distance;  /* distance of the nearest name so far; larger than the limit when there is none */
    char advice[120]; /* " (did you mean 'score'?)", or "" */
} nqm_nearest;
nqm_nearest nqm_nearest_begin(const char *wanted);
/** Offer a name. Names count as near when a third of the letters (at least 1, at most 4) must be inserted, deleted, replaced or
 *  exchanged with the next. Case, '-' and '_' make no difference. */
void nqm_nearest_add(nqm_nearest *nearest, const char *name);

/* ---- names to values --------------------------------------------------------------------------------------------- */

/** A key: a name in a scope. Scopes are equal by address, names by content. */
typedef struct nqm_index_key {
    const void *scope;
    const char *name;
} nqm_index_key;

/** A hash table of borrowed values that know their key: 16 to 32 bytes for each. */
typedef struct nqm_index {
    const void **slots; /* (n_slots), NULL: empty */
    size_t n_slots;
    nqm_index_key (*key_of)(const void *value);
} nqm_index;

/** Create an empty table with room for max_n values. */
NQM_MUST_CHECK nqm_status nqm_index_create(size_t max_n, nqm_index_key (*key_of)(const void *value),
                                           nqm_index *index_ret, nqm_error *err);
/** Make room for n values; a zeroed table with key_of is allowed. Unchanged on failure. */
NQM_MUST_CHECK nqm_status nqm_index_reserve(nqm_index *index, size_t n, nqm_error *err);
/** Add a value, unless there is one of the same key. */
void nqm_index_add(nqm_index *index, const void *value);
/** The first value that was added with this key; NULL: none. */
const void *nqm_index_find(const nqm_index *index, nqm_index_key key);
/** A zeroed table is allowed. */
void nqm_index_free(nqm_index *index);

/* ---- locale-independent number conversion ------------------------------------------------------------------------ */

/** Parse a decimal number at `text`; *end points after it. false when there is none, and for inf, nan and hexadecimal ones. */
bool nqm_parse_double(const char *text, const char **end, double *value);
/** Print with the fewest digits that read back to the same double ("0.1"). Returns `buffer` (32 bytes at least). */
char *nqm_format_double(char *buffer, size_t n_buffer, double value);
/** Print n of them with `separator` in between ("0.1, 0.2"); returns `buffer`. */
char *nqm_format_doubles(char *buffer, size_t n_buffer, size_t n, const double *values, const char *separator);
/** Round `value` to n_digits (1..15) significant decimal digits. */
double nqm_round_digits(double value, int n_digits);

/* ---- random numbers (xoshiro256**, Blackman and Vigna 2021, DOI 10.1145/3460772) --------------------------------- */

typedef struct nqm_rng {
    uint64_t s[4];
} nqm_rng;

/** Create a generator for (seed, stream); different streams of one seed are independent. */
nqm_rng nqm_rng_make(uint64_t seed, uint64_t stream);
uint64_t nqm_rng_u64(nqm_rng *rng);
/** Uniform in [0, 1), 53 bits. */
double nqm_rng_uniform(nqm_rng *rng);
/** Standard normal (Box-Muller). The second value of the pair is discarded, so that the state is only `s`. */
double nqm_rng_normal(nqm_rng *rng);
/** Uniform integer in [0, n), n > 0, without bias. */
uint64_t nqm_rng_below(nqm_rng *rng, uint64_t n);
/** Shuffle idx[n] (Fisher-Yates). */
void nqm_rng_shuffle(nqm_rng *rng, size_t n, size_t *idx);
/** Counter-based hash (splitmix64) of (seed, counter), 64 bits; it does not depend on the order of calls. */
uint64_t nqm_hash_u64(uint64_t seed, uint64_t counter);
/** The same hash in two steps, for loops: nqm_hash_u64(seed, counter) =
 *  nqm_hash_mix(nqm_hash_key(seed) + (counter + 1) NQM_GOLDEN). */
static inline uint64_t nqm_hash_mix(uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}
#define NQM_GOLDEN 0x9e3779b97f4a7c15u /* 2^64 / golden ratio */
static inline uint64_t nqm_hash_key(uint64_t seed) {
    return nqm_hash_mix(seed + NQM_GOLDEN);
}

/* ---- parallel loops ---------------------------------------------------------------------------------------------- */

/** Call body(user, i) for i in [0, n) on OpenMP threads with dynamic scheduling. Bodies must write to disjoint memory,
 *  so that results do not depend on the number of threads. */
void nqm_parallel_for(size_t n, void (*body)(void *user, size_t i), void *user);
/** Limit the threads of parallel loops that the calling thread starts from now on; returns the limit before. For small loops
 *  called thousands of times, in which threads wait longer than they work. */
int nqm_limit_threads(int n_threads);

/* ---- SHA-256 ----------------------------------------------------------------------------------------------------- */

typedef struct nqm_sha256 {
    void *context;
} nqm_sha256;

/** Begin a hash; false when out of memory. */
bool nqm_sha256_begin(nqm_sha256 *sha);
void nqm_sha256_add(nqm_sha256 *sha, const void *data, size_t n_bytes);
/** Add n values of n_each bytes in little-endian order, so that the hash does not depend on the host. */
void nqm_sha256_add_values(nqm_sha256 *sha, size_t n, size_t n_each, const void *values);
/** Store the hash as 64 lower-case hex digits and NUL, and free the context. */
void nqm_sha256_end(nqm_sha256 *sha, char hex[65]);

/* ---- progress ---------------------------------------------------------------------------------------------------- */

/** A progress callback with its user pointer, limited to 5 calls per second. A zeroed ticker calls nothing. */
typedef struct nqm_ticker {
    nqm_progress_fn fn;
    void *user;
    double next_s; /**< earliest time of the next call, on the clock of nqm_clock_s() */
} nqm_ticker;

/** Report done/total of `stage` if 0.2 s have passed since the last report, or if done >= total > 0. true: the caller
 *  must stop. */
bool nqm_tick(nqm_ticker *ticker, const char *stage, double done, double total);
/** nqm_parallel_for() in pieces of about 20 ms, between which the ticker is asked; body must do little in one call. true: stopped
 *  by the ticker. NULL or a ticker without a callback: one piece. */
bool nqm_parallel_ticking(nqm_ticker *ticker, const char *stage, size_t n, void (*body)(void *user, size_t i),
                          void *user);
/** Monotonic time, s; for progress and benchmarks only. */
double nqm_clock_s(void);

/* The static analyser sees one file at a time: tell it that these functions never return NQM_OK. */
#ifdef __clang_analyzer__
#define nqm_fail(err, status, ...)   (nqm_fail((err), (status), __VA_ARGS__), (status))
#define nqm_fail_nomem(err, n_bytes) (nqm_fail_nomem((err), (n_bytes)), NQM_ERR_NOMEM)
#endif

#endif
