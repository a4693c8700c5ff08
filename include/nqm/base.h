/* SPDX-License-Identifier: MIT
 *
 * nqm/base.h - version, status codes, errors and progress. Every other nqm header includes it.
 *
 * Conventions of the whole library:
 *
 *  - Directions are unit vectors that point away from the surface; z is the surface normal.
 *  - `wi` points to the light, `wo` to the viewer. BRDF values are f_r in 1/sr, WITHOUT the cosine.
 *  - RGB is linear, with BT.709 primaries. Angles are radians; degrees occur only in files and on the command line.
 *  - Arrays are row-major, the last index fastest; every array is documented with its shape (rows, columns).
 *  - Every fallible function returns an nqm_status and fills an optional nqm_error (NULL is allowed). When it fails,
 *    the pointers it would have returned are NULL and other outputs are untouched unless its documentation says
 *    otherwise.
 *  - A pointer may be NULL where its documentation says so, and if it is an array of 0 elements. Of other pointers that are NULL,
 *    functions that return a status name the first and return NQM_ERR_ARG. The others have no way to fail, and a made-up result would
 *    hide the fault of the program: they stop by an assertion that names it, and crash if the library was built with NDEBUG. They are
 *    nqm_brdf_get_info, nqm_brdf_eval, nqm_brdf_eval_half_diff, nqm_brdf_albedo, nqm_half_diff_to_directions,
 *    nqm_directions_to_half_diff, nqm_directions_get_info, nqm_directions_id, nqm_dataset_get_info, nqm_dataset_get_pair,
 *    nqm_materials_get, nqm_model_get_info, nqm_texture_get_info, nqm_scene_get_info, nqm_scene_compare,
 *    nqm_curve_jod, nqm_label_get_info, nqm_pairs_remarks and nqm_conform_kit_get_info.
 *  - `_open`, `_load`, `_create` make an object that the caller frees with the matching `_free` (NULL is allowed
 *    there). Pointers that getters return belong to the object and are valid until it is freed.
 *  - BRDFs, direction sets and models are immutable after creation and may be used by several threads at once. Other
 *    objects belong to one thread at a time.
 *  - The library never prints, never exits, never reads the environment and does not depend on the locale.
 *  - What a comment marks with the word NQM_EXPERIMENTAL (a header, or a function) is new: it may change in any release until it has been
 *    used for a while. doc/reference-c.md lists it.
 *  - Random numbers come from seeds that are arguments; results do not depend on the number of threads.
 *  - Large calls work on the threads of OpenMP, which the first such call starts. Without memory for them GCC's runtime
 *    library ends the process (OMP_NUM_THREADS=1 avoids it). The child of fork() uses one thread (omp_set_num_threads(1));
 *    fork() during a call, and more threads in the child, are not supported.
 */
#ifndef NQM_BASE_H
#define NQM_BASE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Library version; the build system reads it from here. */
#define NQM_VERSION_MAJOR 0
#define NQM_VERSION_MINOR 1
#define NQM_VERSION_PATCH 0

#if defined(__GNUC__)
#define NQM_API        __attribute__((visibility("default")))
#define NQM_MUST_CHECK __attribute__((warn_unused_result))
#else
#define NQM_API
#define NQM_MUST_CHECK
#endif

/** Outcome of a call. The command-line tool maps each to its exit code (in brackets). */
typedef enum nqm_status {
    NQM_OK = 0,                /**< success [0] */
    NQM_ERR_ARG = -1,          /**< an argument or a spec is outside its documented range [2] */
    NQM_ERR_IO = -2,           /**< a file cannot be opened, read or written [3] */
    NQM_ERR_FORMAT = -3,       /**< a file's content is malformed or of an unknown format [4] */
    NQM_ERR_INCOMPATIBLE = -4, /**< the inputs do not fit together, or too few valid samples remain [5] */
    NQM_ERR_MODEL = -5,        /**< a model is missing, or its checksum or tensors are wrong [6] */
    NQM_ERR_NOMEM = -6,        /**< out of memory [7] */
    NQM_ERR_LIMIT = -7,        /**< a documented size limit is exceeded [7] */
    NQM_ERR_NUMERIC = -8,      /**< a computation diverged or gave non-finite values [8] */
    NQM_ERR_CANCELLED = -9     /**< the progress callback requested a stop [130] */
} nqm_status;

/** Why a call failed. Zero-initialise it; only failing calls write to it. */
typedef struct nqm_error {
    nqm_status status;   /**< the status that the call returned */
    int64_t byte_offset; /**< position of the fault in its file, bytes from the start; -1 if there is none */
    char message[512];   /**< one line, UTF-8, NUL-terminated; gives the file and the byte if there are any */
} nqm_error;

/** A short constant English phrase for `status` ("malformed input"); never NULL. Any thread. */
NQM_API const char *nqm_status_text(nqm_status status);

/** "MAJOR.MINOR.PATCH" of the library that is running; static storage. Any thread. */
NQM_API const char *nqm_version(void);

/** One line that describes this build: libraries with their versions, and the fastest kernel set that this processor
 *  supports; static storage. Any thread. */
NQM_API const char *nqm_build_info(void);

/**
 * Progress callback of a long call. It runs on the calling thread, at most a few times per second.
 *
 * @param user   the pointer given together with the callback
 * @param stage  name of the current stage ("train", "label"); valid during the callback only
 * @param done   work done so far, in the unit of `total`
 * @param total  total work; 0 when unknown
 * @return 0 to continue; any other value stops the work as soon as it is safe, and the call returns NQM_ERR_CANCELLED
 */
typedef int (*nqm_progress_fn)(void *user, const char *stage, double done, double total);

/** Type of the factors in the matrix products of a training. Sums, LayerNorm, GELU and the output are float or double. */
typedef enum nqm_precision {
    NQM_PRECISION_F32 = 0, /**< float, as in scores */
    NQM_PRECISION_BF16,    /**< factors rounded to bfloat16 (8-bit significand), to nearest even */
    NQM_PRECISION_COUNT
} nqm_precision;

/** Read only files inside of a folder from now on, in the whole process: for services, whose users upload materials that may name
 *  any file as a map. Links are followed first. What lies outside, standard input and devices give NQM_ERR_IO; models that are
 *  built in are no files. folder: NULL: read all, as at the beginning. NQM_ERR_IO: no such folder; NQM_ERR_NOMEM. Do not call it
 *  while another thread uses the library. */
NQM_API NQM_MUST_CHECK nqm_status nqm_files_within(const char *folder, nqm_error *err);

#ifdef __cplusplus
}
#endif
#endif
