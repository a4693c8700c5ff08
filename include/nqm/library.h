/* SPDX-License-Identifier: MIT
 *
 * nqm/library.h - many materials at once: which of a folder look the same, which look most like another one, and what changed between
 * two versions. NQM_EXPERIMENTAL: it may change in any release.
 */
#ifndef NQM_LIBRARY_H
#define NQM_LIBRARY_H

#include <nqm/metric.h>
#include <nqm/texture.h>

#ifdef __cplusplus
extern "C" {
#endif

/** A material of a library, or a BRDF file. */
typedef struct nqm_library_member {
    const char *argument; /**< of nqm_brdf_open(), or of nqm_texture_open() if it is textured */
    const char *key;      /**< its name in the library: "gold", or in a folder "metals/a.gltf:gold" */
    int is_textured;      /**< 1: image maps change it */
} nqm_library_member;

/** Options of nqm_library_open(). */
typedef struct nqm_library_options {
    const char
        *ignore; /**< what of refused materials is ignored (<nqm/material.h>), "transmission,opacity"; NULL: nothing */
    const char *
        index; /**< a file that keeps the pictures for later libraries of the same files; it is written, complete or not at
                             all, unless it fits. NULL: none */
    const nqm_score_options *score; /**< NULL: the defaults. Scores have no scalar metrics */
    nqm_progress_fn progress;       /**< stages "read", "sample", "compare", "score"; NULL: silent */
    /** Called with what is left out, and why (status), or not used (NQM_OK): one line; NULL: silent. Both run on the calling thread. */
    void (*report)(void *user, nqm_status status, const char *message);
    void *user; /**< of both */
} nqm_library_options;

/** The materials of files and folders. It belongs to one thread at a time; its calls work on all threads of OpenMP. */
typedef struct nqm_library {
    size_t n;                          /**< materials */
    const nqm_library_member *members; /**< (n) in the order of the paths, then of the file */
    size_t
        n_failed; /**< that were left out because they cannot be read or have no values. nqm_library_near() leaves out the latter */
    const char *path; /**< the one path, or how many there are */
    struct nqm_library_state *state;
} nqm_library;

/**
 * List the materials of files, and of all files of folders and their folders; files of folders that are no materials are left out.
 * Nothing is sampled.
 *
 * @param where        (n) paths; "/dev/null" has no materials
 * @param model        that compares them, with a transport matrix ("default", "transport"); must outlive the library. NULL: they are
 *                     only listed, without an index
 * @param options      NULL: the defaults. Texts and scores need not outlive the call, `user` does
 * @param library_ret  receives the library; nqm_library_free() it
 * @return NQM_ERR_ARG (no such word, or the index is another file), NQM_ERR_IO and NQM_ERR_FORMAT (a file, or a folder without any
 *         material), NQM_ERR_CANCELLED, NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_library_open(size_t n, const char *const *where, const nqm_model *model,
                                                   const nqm_library_options *options, nqm_library **library_ret,
                                                   nqm_error *err);
/** Free it with the pairs that it has found; NULL is allowed. */
NQM_API void nqm_library_free(nqm_library *library);

/** The value of a property. */
typedef struct nqm_library_value {
    const char *text; /**< what a map computes, "col.png [8 0 0; 0 8 0]", or the model; NULL: numbers */
    size_t n; /**< numbers, 0 to 3; without text 0: the file has no value, so that it is the default of the model */
    double v[3];
} nqm_library_value;
/** A property or map that changed; "model": the shading model. */
typedef struct nqm_library_change {
    char property[48];
    nqm_library_value before, after;
} nqm_library_change;

/** Two materials, and the score of the second next to the first. */
typedef struct nqm_library_pair {
    size_t ref, test;        /**< number of the members; SIZE_MAX: it is none */
    nqm_named_pair names;    /**< their arguments; NULL: there is none */
    nqm_score_result result; /**< without metrics; of textures the near score. NaN unless both exist */
    nqm_error error;         /**< why there is no score; status NQM_OK: there is one */
    const nqm_texture_result
        *texture;         /**< of textures, unless the near score is all that was wanted; NULL: of two BRDFs */
    int is_refused_alike; /**< of versions: both are refused for the same property, value and reason */
    size_t n_changes;
    const nqm_library_change *changes; /**< (n_changes) of versions */
} nqm_library_pair;

/** What nqm_library_near() looks for. */
typedef struct nqm_library_query {
    const char *to; /**< path or spec: members that look like it; NULL: members that look like each other */
    size_t n;       /**< of `to`: at least so many are scored, if there are; 1 to 1000 */
    int is_apart;   /**< of `to`: 1: by the similarity to people who do not see both at once */
    double jod;     /**< without `to`: the least score of materials that look the same; 9 to 10 */
} nqm_library_query;

/**
 * Find members by pictures of all, and score the candidates. The first call samples the members and draws the pictures.
 *
 * With `to`: pairs of it and members, best first, those without a score last. Without: pairs of each member that looks like another
 * one in both orders, and the one that is kept for it; pairs of one kept member are together, and the members with the most
 * look-alikes are kept first.
 *
 * @param n_ret      receives how many pairs there are
 * @param pairs_ret  receives the pairs; the library has them until its next call
 * @return NQM_ERR_ARG, NQM_ERR_MODEL (there is none, or it has no transport matrix), NQM_ERR_CANCELLED, NQM_ERR_NOMEM; of `to`: as nqm_brdf_open() and
 *         nqm_texture_open(); of the index: NQM_ERR_IO
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_library_near(nqm_library *library, const nqm_library_query *query, size_t *n_ret,
                                                   const nqm_library_pair **pairs_ret, nqm_error *err);

/**
 * Pairs of two versions of a library: members of the same key; of keys that only one version has, those that look the same (JOD 9.5),
 * if the model has a transport matrix; and files of one material, whatever it is called.
 *
 * @param before, after  the versions. Model and options are those of `after`
 * @param pairs_ret      receives pairs with score and changes, worst first, those without a score before them; then members that are
 *                       gone (test SIZE_MAX), then new ones (ref SIZE_MAX). `after` has them until its next call
 * @return NQM_ERR_CANCELLED, NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_library_diff(nqm_library *before, nqm_library *after, size_t *n_ret,
                                                   const nqm_library_pair **pairs_ret, nqm_error *err);

#ifdef __cplusplus
}
#endif
#endif
