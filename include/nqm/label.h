/* SPDX-License-Identifier: MIT
 *
 * nqm/label.h - labels by rendering: Delta-E ITP between pictures of two BRDFs, and training corpora. In libnqm-full only.
 */
#ifndef NQM_LABEL_H
#define NQM_LABEL_H

#include <nqm/data.h>
#include <nqm/fit.h>
#include <nqm/model.h>
#include <nqm/percept.h>
#include <nqm/render.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- labels ------------------------------------------------------------------------------------------------------ */

/** Compare two renderings of the scene, (n_points, 3) cd/m2 each, clipped at the display's peak; points are weighted by
 *  nqm_scene_weights(). label.error is the standard error by the choice of the points, measured between four groups of them. */
NQM_API nqm_label nqm_scene_compare(const nqm_scene *scene, const double *ref_cdm2, const double *test_cdm2);
/** The same for pictures of nqm_scene_render_halves(), (3, n_points, 3) each. Noise of the light directions adds to Delta-E, which is
 *  a mean of absolute values: the label is extrapolated from halves and whole to the label without this noise, and half of the
 *  extrapolation counts as error. This is the label of `nqm label` and of corpora. Equal pictures have exactly 0. */
NQM_API nqm_label nqm_scene_compare_halves(const nqm_scene *scene, const double *ref_cdm2, const double *test_cdm2);
/** Delta-E ITP of each point: delta_e (n_points). */
NQM_API void nqm_scene_delta_e_map(const nqm_scene *scene, const double *ref_cdm2, const double *test_cdm2,
                                   double *delta_e);
/** Compare the random pictures of two BRDFs, and differentiate: a loss for training. Noise is common to both pictures: equal values
 *  give exactly 0. Where it makes them differ in shape it adds a little to Delta-E, less with more rays. Any thread.
 *
 * @param ref, test  (rays->n, 3) f_r in 1/sr at the rays
 * @param gradient   (rays->n, 3) receives the derivatives of label_ret->delta_e by `test`, exact but for points that are equal, black
 *                   or brighter than the display, which have 0; NULL allowed
 * @return NQM_ERR_NUMERIC (a value is not finite; the message names its row), NQM_ERR_NOMEM */
NQM_API NQM_MUST_CHECK nqm_status nqm_rays_compare(const nqm_rays *rays, const double *ref, const double *test,
                                                   nqm_label *label_ret, double *gradient, nqm_error *err);

/* ---- light transport --------------------------------------------------------------------------------------------- */

/**
 * Make a model without a network that estimates labels in a scene by light transport: with fixed light, the radiance of every
 * point is linear in the BRDF (precomputed radiance transfer: Sloan et al. 2002, DOI 10.1145/566654.566612), so a matrix makes
 * pictures of few points from samples. The model predicts labels with parts and has no intervals; nqm_model_save() writes it.
 * The directions are the nodes of a grid (nqm_directions_options.grid). More points make it more exact, larger (16.6 KB each) and slower;
 * doc/labels.md has the errors. The built-in model "transport" has the standard scenes.
 *
 * @param scene       NULL: the defaults, the standard scenes; its pixels, points and interreflection are not used, and n_lights 0
 *                    stands for 1024
 * @param n_points    of all scenes together: a multiple of 32 up to 4096
 * @param id          of the model; copied
 * @return NQM_ERR_ARG (an option or n_points is out of range), NQM_ERR_IO, NQM_ERR_FORMAT (light or shape), NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_transport_create(const nqm_scene_options *scene, size_t n_points, const char *id,
                                                       nqm_model **model_ret, nqm_error *err);

/* ---- corpora ----------------------------------------------------------------------------------------------------- */

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
