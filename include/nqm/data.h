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
    size_t n_kinds;       /**< kinds of distortion: nqm_dataset_get_kind() */
    size_t n_pairs_in[3]; /**< pairs in each split, before augmentation */
    const char *sha256;   /**< SHA-256 of the file; of the content for the authors' layout and for people's answers */
    const char *manifest; /**< JSON: how it was made; "" if unknown */
    const nqm_directions *directions;
} nqm_dataset_info;

/** Load nqm's own dataset file (safetensors; doc/files.md). NQM_ERR_IO, NQM_ERR_FORMAT, NQM_ERR_NOMEM; free with
 *  nqm_dataset_free(). */
NQM_API NQM_MUST_CHECK nqm_status nqm_dataset_load(const char *path, nqm_dataset **dataset_ret, nqm_error *err);

/**
 * Read the authors' layout (github.com/behnazkavoosi/neural-brdf-quality-metric): a CSV
 * `material,model,level,DeltaE,JOD,class` (`class` is ignored) and for each of its rows, whose `material` is NAME, the files
 * ROOT/ref/NAME.mat and ROOT/model/NAME.mat (MAT v5; r, g, b 500x1 and random_locations 500x3 in degrees, the same in all
 * files). NAME is a material and a running number, "brass_12": rows that differ in the number only form one material group.
 * ROOT/ref/brass.mat may be the reference of all of them. Equal references of a material are kept once. The kinds are the
 * models, "sbrdf" and "hbrdf" with their level, of which 0 is the finest: "ward", "sbrdf.0", "sbrdf.2". Negative values are
 * read as 0; the manifest says how many there were.
 *
 * @param split  the split of every row; NQM_SPLIT_ALL: training rows, from which the training options draw validation pairs
 * @return NQM_ERR_IO, NQM_ERR_FORMAT, NQM_ERR_INCOMPATIBLE (other directions in one of the files), NQM_ERR_LIMIT (more than
 *         100,000 directions), NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_dataset_load_authors(const char *root, const char *labels_csv, nqm_split split,
                                                           nqm_dataset **dataset_ret, nqm_error *err);
/** Free a dataset; NULL is allowed. */
NQM_API void nqm_dataset_free(nqm_dataset *dataset);
/** Facts about `dataset`. */
NQM_API nqm_dataset_info nqm_dataset_get_info(const nqm_dataset *dataset);

/** A kind of distortion. */
typedef struct nqm_dataset_kind {
    const char *name; /**< "ggx", "noise", ... */
    const char
        *family; /**< in corpora of this program: "encoding" (own fits), "published" (published parameters of the same
                             material), "form" (other representations of the same material), "perturbation", "composed" (two
                             perturbations, or one of an encoding), "far" (BRDFs that really differ), "rounding"; in the
                             authors' layout: "encoding"; "" if unknown */
} nqm_dataset_kind;
/** Kind i in [0, n_kinds); both members are NULL beyond. */
NQM_API nqm_dataset_kind nqm_dataset_get_kind(const nqm_dataset *dataset, size_t i);

enum { NQM_MATERIAL_CLASS_COUNT = 9 };
/** The i-th class of reference materials: "matte grey", "matte coloured", "satin grey", ..., "mirror-like coloured",
 *  "unclassified"; static storage; NULL beyond. Over directions with theta_d below 60 degrees, a material is satin, glossy or
 *  mirror-like when its luminance (geometric mean) at theta_h below 3 degrees is 3, 20, 200 times that at 25 degrees and
 *  more; it is coloured when one channel of the mean f_r of the latter differs by more than a factor exp(0.4) from the geometric
 *  mean of the three. Unclassified: no direction in one of these zones. */
NQM_API const char *nqm_material_class_name(size_t i);

/** One pair; strings are valid until the dataset is freed. */
typedef struct nqm_dataset_pair {
    const char *ref, *group;    /**< the reference and its material group */
    const char *test;           /**< a spec, or a name */
    const char *kind, *family;  /**< as in nqm_dataset_kind */
    const char *material_class; /**< class of the reference material: a nqm_material_class_name() */
    /** Where the reference comes from: "measured", "neural", "analytic" (of the corpus's sources rgl and merl, nbrdf and nps, sgd;
     *  also with a suffix, as in "rgl-..."), or another source by its own name, as "renderer" and "mirror"; "" if the manifest
     *  does not say it. */
    const char *source;
    nqm_split split;
    double delta_e, jod; /**< the labels: Delta-E ITP, and JOD 0..11 or a human score */
} nqm_dataset_pair;

/** Pair i in [0, n_pairs). */
NQM_API nqm_dataset_pair nqm_dataset_get_pair(const nqm_dataset *dataset, size_t i);

/* ---- people's answers -------------------------------------------------------------------------------------------- */

/** What people were asked; the columns of the CSV decide. */
typedef enum nqm_human_kind {
    NQM_HUMAN_SCORE = 0, /**< column `score`: opinion scores, higher is better */
    NQM_HUMAN_JOD,       /**< column `jod`: JOD, 10 is no visible difference */
    NQM_HUMAN_DISTANCE,  /**< column `distance`: perceived differences, higher is worse */
    NQM_HUMAN_CHOICE /**< columns `test_a`, `test_b`: which is more like the reference; and `choice` (a or b, one person per
                              row) or `n_a`, `n_b` (number of people who chose each) */
} nqm_human_kind;

/** People's answers with the BRDFs that they are about. Immutable; any thread. */
typedef struct nqm_human nqm_human;

/** Options of nqm_human_load(); from nqm_human_options_default(). */
typedef struct nqm_human_options {
    const char *root;                 /**< folder of relative paths of BRDFs; NULL: the current folder */
    const nqm_directions *directions; /**< where BRDFs are sampled, used during the call only; NULL: the default set */
    double
        min_valid_fraction; /**< a pair whose BRDFs both have a value at a smaller fraction of the directions is refused;
                                    0..1, default 0.9 */
    nqm_progress_fn progress; /**< NULL: none */
    void *progress_user;
} nqm_human_options;

/** The defaults above. */
NQM_API nqm_human_options nqm_human_options_default(void);

/**
 * Read answers and sample the BRDFs. The CSV has the columns `reference`, `test` (BRDFs as for nqm_brdf_open()) and one of
 * `score`, `jod`, `distance`; or `reference`, `test_a`, `test_b` and `choice` or `n_a`, `n_b`. Optional: `material` (the unit of
 * resampling, and the set inside which tests are compared; default the reference) and `kind` (a name for the kind of test; not
 * with choices). Other columns are ignored. Rows about the same three BRDFs are added up, whichever test is called a.
 *
 * @param options  NULL: the defaults
 * @return NQM_ERR_ARG (options), NQM_ERR_FORMAT, NQM_ERR_IO and others from the CSV and the BRDFs; the message names the file and
 *         the row, counted from 1 after the header; NQM_ERR_INCOMPATIBLE (too few valid directions, a reference of two
 *         materials), NQM_ERR_CANCELLED, NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_human_load(const char *csv_path, const nqm_human_options *options,
                                                 nqm_human **human_ret, nqm_error *err);
/** Free; NULL is allowed. */
NQM_API void nqm_human_free(nqm_human *human);

/** Facts about people's answers. */
typedef struct nqm_human_info {
    nqm_human_kind kind;
    const char *kind_name;   /**< "score", "jod", "distance" or "choice"; static storage */
    size_t n_rows;           /**< rows of the CSV */
    size_t n_refs, n_groups; /**< references, materials */
    size_t n_triplets;       /**< distinct (reference, test, test); 0 for scores */
    double n_choices;        /**< answers of people; 0 for scores */
    double ceiling;          /**< fraction of the choices that agrees with the majority in its triplet: the best that a
                                      predictor can reach; NaN for scores */
    double
        ceiling_other_people; /**< fraction of the choices that agrees with the majority of the other people (a draw counts
                                      half), over triplets with at least two choices; NaN without these */
} nqm_human_info;
NQM_API nqm_human_info nqm_human_get_info(const nqm_human *human);

/**
 * The pairs as a dataset of test pairs for nqm_evaluation_create(), valid until `human` is freed. Scores: one pair per row, whose
 * `jod` is the score (a distance: times -1), to be judged by nqm_evaluation_judge(); errors in JOD are given for NQM_HUMAN_JOD
 * only, and ranges of JOD do not apply otherwise. Choices: the distinct pairs, whose `jod` is NaN; judge them with
 * nqm_human_judge_choices().
 */
NQM_API const nqm_dataset *nqm_human_dataset(const nqm_human *human);

#ifdef __cplusplus
}
#endif
#endif
