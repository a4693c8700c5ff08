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

/* ---- regression on a file ----------------------------------------------------------------------------------------- */

/** nqm_regress() for a CSV with columns DeltaE and JOD (any order, any case; others ignored). */
NQM_API NQM_MUST_CHECK nqm_status nqm_regress_csv(const char *path, nqm_regress_report *report_ret, nqm_error *err);

/* ---- labels ------------------------------------------------------------------------------------------------------ */

/** Mean Delta-E ITP over the points (by their shares) of two renderings of the scene; equal pictures give exactly 0. */
NQM_API double nqm_scene_delta_e(const nqm_scene *scene, const double *ref_cdm2, const double *test_cdm2);
/** The same, point by point: delta_e (n_points). */
NQM_API void nqm_scene_delta_e_map(const nqm_scene *scene, const double *ref_cdm2, const double *test_cdm2,
                                   double *delta_e);

/* ---- comparing labels with somebody else's ----------------------------------------------------------------------- */

enum { NQM_COMPARE_MAX_ENCODINGS = 32 };

/** Our Delta-E beside theirs, over the references of one encoding. */
typedef struct nqm_compare_row {
    char encoding[32];
    size_t n;                          /**< references */
    double spearman, spearman_ci95[2]; /**< of ours with theirs; interval: bootstrap over references */
    double null_luminance; /**< of the mean luminance of the reference's picture with theirs: what an order of the
                                references alone reaches */
    double median_theirs, median_ours, median_ratio;
} nqm_compare_row;

typedef struct nqm_comparison {
    size_t n_encodings;
    nqm_compare_row rows[NQM_COMPARE_MAX_ENCODINGS]; /**< in the order of the file */
    nqm_compare_row pooled;                          /**< all pairs together; encoding "all" */
    double pooled_null_encoding; /**< Spearman of theirs with the median of the encoding over the other references */
    size_t n_triples, n_ordered; /**< references with ward, ggx and nbrdf; of them those with nbrdf < min(ggx, ward) in
                                        our Delta-E */
    size_t n_ordered_theirs;     /**< the same in theirs */
} nqm_comparison;

/**
 * Make our labels for pairs that somebody else has labelled, and compare: by rank over references, encoding by encoding,
 * because the encoding's name alone explains most of a pooled correlation.
 *
 * @param pairs_csv  columns reference, test (BRDFs; test `fit`: our own fit of the model that `encoding` names),
 *                   encoding, delta_e (theirs); rows of one reference side by side make it quicker
 * @param root       folder at which relative paths start; NULL: the current one
 * @param fit        options of the fits; NULL: the defaults
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_compare_labels(const char *pairs_csv, const char *root, const nqm_scene *scene,
                                                     const nqm_fit_options *fit, nqm_progress_fn progress,
                                                     void *progress_user, nqm_comparison *comparison_ret,
                                                     nqm_error *err);

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
 * @param materials_csv  columns name, group, brdf (path or spec), source, split (train, validation, test); see
 *                       nqm_corpus_scan()
 * @param directions     where to sample
 * @param path           the dataset file to write; not "-"
 * @return besides what reading the inputs gives: NQM_ERR_ARG (options), NQM_ERR_INCOMPATIBLE (no material of this part),
 *         NQM_ERR_CANCELLED (finished groups are kept in `checkpoint`)
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_corpus_build(const char *materials_csv, const nqm_directions *directions,
                                                   const nqm_corpus_options *options, const char *path, nqm_error *err);

/**
 * Write the material list of a data folder: DIR/rgl/ *.bsdf, the members of DIR/nbrdf/ *.zip, the rows of
 * DIR/nps/nps_latents.csv, and the presets `sgd:`. Paths are relative to DIR. All forms of one material make one group.
 * The materials of DIR/labels/labels_real.csv are the test split; a seeded 15 % of the other groups are validation.
 *
 * @param data_dir  DIR
 * @param path      the CSV to write ("-" is standard output)
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_corpus_scan(const char *data_dir, uint64_t seed, const char *path,
                                                  nqm_error *err);

#ifdef __cplusplus
}
#endif
#endif
