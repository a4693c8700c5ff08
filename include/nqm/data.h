/* SPDX-License-Identifier: MIT
 *
 * nqm/data.h - labelled pairs of sampled BRDFs: dataset files, the folder layout of the paper's authors, and CSVs of people's
 * answers (scores, or choices between two tests). nqm/corpus.h makes datasets.
 */
#ifndef NQM_DATA_H
#define NQM_DATA_H

#include <nqm/samples.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Labelled pairs of sampled BRDFs. Immutable; any thread. */
typedef struct nqm_dataset nqm_dataset;

/** Which pairs of a dataset. A reference's material group belongs to one split only. */
typedef enum nqm_split { NQM_SPLIT_TRAIN = 0, NQM_SPLIT_VALIDATION, NQM_SPLIT_TEST, NQM_SPLIT_ALL } nqm_split;

/** Facts about a dataset; pointers are valid until it is freed. */
typedef struct nqm_dataset_info {
    size_t n_directions, n_refs, n_groups, n_pairs;
    size_t n_kinds;       /**< kinds of distortion */
    size_t n_pairs_in[3]; /**< pairs in each split, before augmentation */
    const char *sha256;   /**< SHA-256 of the file; of the content for the authors' layout and for people's answers */
    const char *manifest; /**< JSON: how it was made; "" if unknown */
    const nqm_directions *directions;
} nqm_dataset_info;

/**
 * Load a dataset file of nqm (safetensors; doc/files.md), or the folder of the paper's authors.
 *
 * The authors' layout (github.com/behnazkavoosi/neural-brdf-quality-metric) is a CSV `material,model,level,DeltaE,JOD,class` (`class`
 * is ignored) and for each of its rows, whose `material` is NAME, the files PATH/ref/NAME.mat and PATH/model/NAME.mat (MAT v5; r, g,
 * b 500x1 and random_locations 500x3 in degrees, the same in all files). NAME is a material and a running number, "brass_12": rows
 * that differ in the number only form one material group. PATH/ref/brass.mat may be the reference of all of them. Equal references of
 * a material are kept once. The kinds are the models, "sbrdf" and "hbrdf" with their level, of which 0 is the finest: "ward",
 * "sbrdf.0", "sbrdf.2". Negative values are read as 0; the manifest says how many there were.
 *
 * @param labels_csv   NULL: `path` is a dataset file; otherwise a folder in the authors' layout with these labels
 * @param split        of every row of such labels; NQM_SPLIT_ALL: training rows, from which the training options draw validation pairs
 * @param dataset_ret  free with nqm_dataset_free()
 * @return NQM_ERR_IO, NQM_ERR_FORMAT, NQM_ERR_INCOMPATIBLE (other directions in one of the files of a folder), NQM_ERR_LIMIT (more than
 *         100,000 directions), NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_dataset_load(const char *path, const char *labels_csv, nqm_split split,
                                                   nqm_dataset **dataset_ret, nqm_error *err);
/** Free a dataset; NULL is allowed. */
NQM_API void nqm_dataset_free(nqm_dataset *dataset);
/** Facts about `dataset`. */
NQM_API nqm_dataset_info nqm_dataset_get_info(const nqm_dataset *dataset);

/** One pair; strings are valid until the dataset is freed. */
typedef struct nqm_dataset_pair {
    const char *ref, *group; /**< the reference and its material group */
    const char *test;        /**< a spec, or a name */
    const char *kind;        /**< of distortion: "ggx", "noise", ... */
    /** In corpora of this program: "encoding" (own fits), "published" (published parameters of the same material), "form"
     *  (other representations of the same material), "perturbation", "composed" (two perturbations, or one of an
     *  encoding), "far" (BRDFs that really differ), "rounding"; in the authors' layout: "encoding"; "" if unknown. */
    const char *family;
    /** Class of the reference material: "matte grey", "matte coloured", "satin grey", ..., "mirror-like coloured",
     *  "unclassified". Over directions with theta_d below 60 degrees, a material is satin, glossy or mirror-like when its
     *  luminance (geometric mean) at theta_h below 3 degrees is 3, 20, 200 times that at 25 degrees and more; it is
     *  coloured when one channel of the mean f_r of the latter differs by more than a factor exp(0.4) from the geometric
     *  mean of the three. Unclassified: no direction in one of these zones. */
    const char *material_class;
    /** Where the reference comes from: "measured", "neural", "analytic" (of the corpus's sources rgl and merl, nbrdf and nps, sgd;
     *  also with a suffix, as in "rgl-..."), or another source by its own name, as "renderer" and "mirror"; "" if the manifest
     *  does not say it. */
    const char *source;
    nqm_split split;
    double delta_e, jod; /**< the labels: Delta-E ITP, and JOD 0..11 or a human score */
} nqm_dataset_pair;

/** Pair i in [0, n_pairs). */
NQM_API nqm_dataset_pair nqm_dataset_get_pair(const nqm_dataset *dataset, size_t i);

#ifdef __cplusplus
}
#endif
#endif
