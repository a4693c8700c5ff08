/* SPDX-License-Identifier: MIT
 *
 * nqm/corpus.h - training corpora: labelled pairs of BRDFs. In libnqm-full only.
 */
#ifndef NQM_CORPUS_H
#define NQM_CORPUS_H

#include <nqm/data.h>
#include <nqm/fit.h>
#include <nqm/label.h>

#ifdef __cplusplus
extern "C" {
#endif

/** The splits in a dataset file. Test materials are never in a file with training materials. */
typedef enum nqm_corpus_part {
    NQM_CORPUS_TRAINING = 0, /**< train and validation; without the kinds of distortion that only the test part has */
    NQM_CORPUS_TEST          /**< test; all kinds */
} nqm_corpus_part;

typedef struct nqm_corpus_options {
    nqm_corpus_part part;    /**< default NQM_CORPUS_TRAINING */
    const char *root;        /**< folder of relative paths in the list; default NULL: the folder of the list */
    nqm_scene_options scene; /**< scene of the labels; its strings are borrowed during the call */
    const char
        *checkpoint; /**< folder for finished material groups, from which an interrupted run continues; processes with
                                  the same folder share the work: each makes groups that no other has started, and waits
                                  for the others at the end; default NULL: none */
    int work_only;   /**< 1: only make groups for other processes with the same `checkpoint`; default 0 */
    const char
        *models; /**< models of nqm_fit() that encode each reference, separated by commas; "": none; default NULL:
                                  all */
    size_t n_perturbations; /**< perturbed copies per reference, 0 to 1000; default 26 */
    size_t n_far;           /**< tests per reference that really differ from it: other materials, random parameters,
                                   mixtures, extremes; 0 to 1000; default 26 */
    size_t n_roundings;     /**< copies per reference with rounded values, 0 to 1000; default 3 */
    size_t n_variants; /**< at most this many variants per reference: changed specs, translations, tables, overfitted
                                   networks; 0 to 1000; default 8 */
    size_t every;      /**< keep one test in this many, for a small corpus of the same composition; 1 to 1000;
                                   default 1 */
    uint64_t seed;     /**< of perturbations and fits; default 1 */
    nqm_progress_fn progress; /**< called from the calling thread; NULL: silent */
    void *progress_user;
} nqm_corpus_options;

/** The defaults above. */
NQM_API nqm_corpus_options nqm_corpus_options_default(void);

/**
 * Make a dataset file from a list of materials: for each reference its encodings by the models of nqm_fit(), other forms of
 * the same material in the list or the presets, seeded perturbations, and BRDFs that really differ, among them other
 * materials of the same split; labels by rendering. Tests that cannot be fitted or rendered are left out and listed in the
 * manifest ("failures"). The manifest is stored in the file and, with the dataset's checksum, in PATH.json. The bytes are the same for any number of threads and processes.
 *
 * @param materials_csv  columns name, group, brdf (path or spec), source, split (train, validation, test);
 *                       models/scan.py writes one for a data folder
 * @param directions     sampling directions
 * @param path           the dataset file to write
 * @return NQM_ERR_ARG (options), NQM_ERR_INCOMPATIBLE (no material of this part), NQM_ERR_CANCELLED (finished groups stay in
 *         `checkpoint`), or the error of reading an input
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_corpus_build(const char *materials_csv, const nqm_directions *directions,
                                                   const nqm_corpus_options *options, const char *path, nqm_error *err);

#ifdef __cplusplus
}
#endif
#endif
