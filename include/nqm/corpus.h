/* SPDX-License-Identifier: MIT
 *
 * nqm/corpus.h - datasets of labelled pairs of BRDFs, from a list of the pairs. In libnqm-full only. NQM_EXPERIMENTAL.
 */
#ifndef NQM_CORPUS_H
#define NQM_CORPUS_H

#include <nqm/data.h>
#include <nqm/label.h>

#ifdef __cplusplus
extern "C" {
#endif

/** The splits in a dataset file. Test materials are never in a file with training materials. */
typedef enum nqm_corpus_part {
    NQM_CORPUS_TRAINING = 0, /**< train and validation */
    NQM_CORPUS_TEST          /**< test */
} nqm_corpus_part;

/** A pair to label. BRDFs are arguments of nqm_brdf_open(), or `fit:` specs (doc/brdf.md). A text that is NULL or ""
 *  has its default. */
typedef struct nqm_corpus_pair {
    const char *reference, *test;
    const char *name; /**< of the reference; default `reference`. A name has one reference, group and source */
    const char *
        group; /**< material: all forms of one material belong to one group, and a group to one split; default: `name` */
    const char *source; /**< of the reference, for the manifest; default "list" */
    const char *kind;   /**< of distortion; default "pair" */
    const char *family; /**< of the kind; default: `kind` */
    const char
        *other; /**< name of another reference that the test contains, which must be in the same split; default: none */
    nqm_split split;
} nqm_corpus_pair;

typedef struct nqm_corpus_options {
    nqm_corpus_part part;    /**< default NQM_CORPUS_TRAINING */
    const char *root;        /**< folder of relative paths in the list; default NULL: the working folder */
    nqm_scene_options scene; /**< scene of the labels; its strings are borrowed during the call */
    const char
        *checkpoint;  /**< folder for finished work, from which an interrupted run continues; processes with the same
                                  folder share the work: each labels pairs that no other has started, and waits for the others
                                  at the end; default NULL: none */
    int work_only;    /**< 1: only work for other processes with the same `checkpoint`; default 0 */
    const char *keep; /**< "FAMILY=N": keep at most N pairs of this family per reference, those whose JODs are spread
                                  most evenly; default NULL: all */
    int anisotropic;  /**< 1: pairs may be anisotropic. Samples have one azimuth, so that the dataset is for models like
                                  "anisotropic" alone; default 0: such pairs cannot be labelled */
    nqm_progress_fn progress; /**< called from the calling thread; NULL: silent */
    void *progress_user;
} nqm_corpus_options;

/** The defaults above. */
NQM_API nqm_corpus_options nqm_corpus_options_default(void);

/**
 * Label a list of pairs by rendering and write them as a dataset file. Pairs of a reference share its samples and
 * pictures and their fits. Pairs that cannot be opened, fitted or rendered are left out and listed in the manifest
 * ("failures"). The manifest is stored in the file and, with the dataset's checksum, in PATH.json. The bytes are the
 * same for any number of threads and processes.
 *
 * @param pairs       (n), borrowed during the call; those of other splits than options->part are left out
 * @param directions  sampling directions
 * @param path        the dataset file to write
 * @return NQM_ERR_ARG (options, pairs that contradict each other), NQM_ERR_INCOMPATIBLE (no pair of this part), NQM_ERR_CANCELLED
 *         (finished work stays in `checkpoint`), or the error of reading an input
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_corpus_build(size_t n, const nqm_corpus_pair *pairs,
                                                   const nqm_directions *directions, const nqm_corpus_options *options,
                                                   const char *path, nqm_error *err);

#ifdef __cplusplus
}
#endif
#endif
