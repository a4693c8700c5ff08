/* SPDX-License-Identifier: MIT
 *
 * nqm/label.h - labels by rendering: Delta-E ITP between pictures of two BRDFs, and the making of training corpora. In libnqm-full only.
 */
#ifndef NQM_LABEL_H
#define NQM_LABEL_H

#include <nqm/data.h>
#include <nqm/fit.h>
#include <nqm/percept.h>
#include <nqm/render.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- labels ------------------------------------------------------------------------------------------------------ */

/** Mean Delta-E ITP over the points (by their shares) of two renderings of the scene; equal pictures give exactly 0. */
NQM_API double nqm_scene_delta_e(const nqm_scene *scene, const double *ref_cdm2, const double *test_cdm2);
/** The same, point by point: delta_e (n_points). */
NQM_API void nqm_scene_delta_e_map(const nqm_scene *scene, const double *ref_cdm2, const double *test_cdm2,
                                   double *delta_e);

/* ---- corpora ----------------------------------------------------------------------------------------------------- */

/** Which splits a dataset file holds. Test materials never share a file with training materials. */
typedef enum nqm_corpus_part {
    NQM_CORPUS_TRAINING = 0, /**< train and validation; without the kinds of distortion that are kept unseen */
    NQM_CORPUS_TEST          /**< test; all kinds */
} nqm_corpus_part;

typedef struct nqm_corpus_options {
    nqm_corpus_part part;    /**< default NQM_CORPUS_TRAINING */
    const char *root;        /**< folder at which relative paths of the list start; NULL: the list's own */
    nqm_scene_options scene; /**< where the labels are rendered; strings are lent */
    const char *checkpoint;  /**< folder that keeps finished groups, so that an interrupted run goes on; processes that
                                 share it share the work: each makes groups that no other has begun, and waits for the
                                 others' at the end; NULL: none */
    int work_only;           /**< 1: help those that share `checkpoint`, but write no dataset; default 0 */
    const char *models;      /**< models of nqm_fit() that encode each reference, with commas between them; "": none;
                                 NULL: all; default NULL */
    size_t n_perturbations;  /**< perturbed copies a reference; default 26 */
    uint64_t seed;           /**< default 1 */
    nqm_progress_fn progress;
    void *progress_user;
} nqm_corpus_options;

/** The defaults above. */
NQM_API nqm_corpus_options nqm_corpus_options_default(void);

/**
 * Make a dataset file from a list of materials: for each reference its encodings by every model of nqm_fit(), the other
 * forms of the same material that the list or the presets hold, and seeded perturbations; labels by rendering. What
 * cannot be fitted or rendered is left out and named in the manifest ("failures"). The manifest is stored in the file and
 * written beside it as PATH.json, there with the dataset's checksum. The file is the same for any number of threads and
 * processes.
 *
 * @param materials_csv  columns name, group, brdf (path or spec), source, split (train, validation, test);
 *                       models/scan.py writes one for a data folder
 * @param directions     where to sample
 * @param path           the dataset file to write; not "-"
 * @return besides what reading the inputs gives: NQM_ERR_ARG (options), NQM_ERR_INCOMPATIBLE (no material of this part),
 *         NQM_ERR_CANCELLED (finished groups are kept in `checkpoint`)
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_corpus_build(const char *materials_csv, const nqm_directions *directions,
                                                   const nqm_corpus_options *options, const char *path, nqm_error *err);

#ifdef __cplusplus
}
#endif
#endif
