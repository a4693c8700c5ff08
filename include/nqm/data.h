/* SPDX-License-Identifier: MIT
 *
 * nqm/data.h - labelled pairs of sampled BRDFs: dataset files, the authors' layout, and what people said about pairs, from a
 * CSV of scores or of choices between two tests.
 */
#ifndef NQM_DATA_H
#define NQM_DATA_H

#include <nqm/samples.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Labelled pairs of sampled BRDFs. Immutable once loaded. */
typedef struct nqm_dataset nqm_dataset;

/** Which pairs of a dataset. A reference's material group belongs to one split only. */
typedef enum nqm_split { NQM_SPLIT_TRAIN = 0, NQM_SPLIT_VALIDATION, NQM_SPLIT_TEST, NQM_SPLIT_ALL } nqm_split;

/** Facts about a dataset; strings are lent by it. */
typedef struct nqm_dataset_info {
    size_t n_directions, n_refs, n_groups, n_pairs;
    size_t n_pairs_in[3]; /**< per split, before augmentation */
    const char *sha256;   /**< of the file; of the content for the authors' layout */
    const char *manifest; /**< JSON: how it was made; "" if unknown */
    const nqm_directions *directions;
} nqm_dataset_info;

/** Load nqm's own dataset file (safetensors; doc/files.md). */
NQM_API NQM_MUST_CHECK nqm_status nqm_dataset_load(const char *path, nqm_dataset **dataset_ret, nqm_error *err);

/**
 * Read the authors' layout: a CSV `material,model,level,DeltaE,JOD,class` (`class` is not used) and for each of its
 * rows, whose `material` is NAME, the files ROOT/ref/NAME.mat and ROOT/model/NAME.mat (MAT v5; r, g, b 500x1 and
 * random_locations 500x3 in degrees, the same in all files). NAME is a material and a running number, "brass_12": rows
 * that differ in the number only are one material group; a reference may also be stored once a material, as
 * ROOT/ref/brass.mat. Equal references are kept once. The kinds are the models: "sbrdf" at level 0, "sbrdf.2" at
 * level 2. Negative values count as 0; how many there were stands in the manifest.
 *
 * @param root        the folder
 * @param labels_csv  the CSV
 * @param split       the split that every row gets; NQM_SPLIT_ALL: training rows, split later by the options of
 * training
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_dataset_load_authors(const char *root, const char *labels_csv, nqm_split split,
                                                           nqm_dataset **dataset_ret, nqm_error *err);
/** Free a dataset; NULL is allowed. */
NQM_API void nqm_dataset_free(nqm_dataset *dataset);
/** Facts about `dataset`. */
NQM_API nqm_dataset_info nqm_dataset_get_info(const nqm_dataset *dataset);

/** The kinds of distortion in a dataset: how many, and the i-th ("ggx", "noise"); lent. */
NQM_API size_t nqm_dataset_kind_count(const nqm_dataset *dataset);
NQM_API const char *nqm_dataset_kind_name(const nqm_dataset *dataset, size_t i);
/** The family of the i-th kind; lent. Of corpora of this program: "encoding" (own fits), "published" (published
 *  parameters of the same material), "form" (other forms of the same material), "perturbation", "composed" (two
 *  perturbations, or one over an encoding). Of the authors' layout: "encoding". "" when the dataset does not say. */
NQM_API const char *nqm_dataset_kind_family(const nqm_dataset *dataset, size_t i);

enum { NQM_MATERIAL_CLASS_COUNT = 9 };
/** The i-th class of reference materials: "matte grey", "matte coloured", "satin grey", ..., "mirror-like coloured",
 *  "unclassified"; static storage. Satin, glossy, mirror-like: at theta_h below 3 degrees 3, 20, 200 times as bright (mean
 *  log luminance, theta_d below 60) as at 25 and more. Coloured: there, a channel of the mean f_r is more than exp(0.4)
 *  off the geometric mean of the three. Unclassified: no direction in one of these zones. */
NQM_API const char *nqm_material_class_name(size_t i);

/** One pair; strings are lent by the dataset. */
typedef struct nqm_dataset_pair {
    const char *ref, *group;    /**< the reference and its material group */
    const char *test, *kind;    /**< the test (a spec, or a name) and its kind of distortion */
    const char *family;         /**< of the kind: nqm_dataset_kind_family() */
    const char *material_class; /**< of the reference: a nqm_material_class_name() */
    nqm_split split;
    double delta_e, jod; /**< the label */
} nqm_dataset_pair;

/** Pair i in [0, n_pairs). */
NQM_API nqm_dataset_pair nqm_dataset_get_pair(const nqm_dataset *dataset, size_t i);

/* ---- answers of people ----------------------------------------------------------------------------------------------- */

/** What people gave; the columns of the CSV say which. */
typedef enum nqm_human_kind {
    NQM_HUMAN_SCORE = 0, /**< column `score`: opinions, higher is better */
    NQM_HUMAN_JOD,       /**< column `jod`: JOD, 10 is no visible difference */
    NQM_HUMAN_DISTANCE,  /**< column `distance`: seen differences, higher is worse */
    NQM_HUMAN_CHOICE /**< columns `test_a`, `test_b`: which looks more like the reference; `choice` (a or b, a person
                              a row) or `n_a`, `n_b` (people who chose each) */
} nqm_human_kind;

/** Answers of people, with the BRDFs that they are about. */
typedef struct nqm_human nqm_human;

/** How nqm_human_load() goes about it. Take the defaults from nqm_human_options_default(). */
typedef struct nqm_human_options {
    const char *root;                 /**< folder at which relative paths of BRDFs start; NULL: the current one */
    const nqm_directions *directions; /**< where BRDFs are looked at, lent during the call; NULL: the default set */
    double
        min_valid_fraction; /**< a pair with values in both BRDFs at fewer of the directions is refused; default 0.9 */
    nqm_progress_fn progress;
    void *progress_user;
} nqm_human_options;

/** The defaults above. */
NQM_API nqm_human_options nqm_human_options_default(void);

/**
 * Read answers and sample the BRDFs. The CSV has the columns `reference`, `test` (BRDFs as nqm_brdf_open() takes them)
 * and one of `score`, `jod`, `distance`; or `reference`, `test_a`, `test_b` and `choice` or `n_a`, `n_b`. Optional:
 * `material` (what is drawn for intervals, and inside what tests are compared; else the reference), `kind` (a name for
 * the sort of test; not with choices). Other columns are not looked at. Rows about the same three BRDFs are added up,
 * whichever of the tests is called a.
 *
 * @return NQM_ERR_FORMAT, NQM_ERR_IO, ... as the file and the BRDFs give; the message names the file and the row,
 *         counted from 1 behind the header; NQM_ERR_INCOMPATIBLE (too few valid directions, a reference of two
 *         materials), NQM_ERR_CANCELLED
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_human_load(const char *csv_path, const nqm_human_options *options,
                                                 nqm_human **human_ret, nqm_error *err);
/** Free; NULL is allowed. */
NQM_API void nqm_human_free(nqm_human *human);

/** Facts. */
typedef struct nqm_human_info {
    nqm_human_kind kind;
    size_t n_rows;               /**< of the file */
    size_t n_refs, n_groups;     /**< references, materials */
    size_t n_triplets;           /**< distinct ones; 0 for scores */
    double n_choices;            /**< of people */
    double ceiling;              /**< share of the choices that the best possible predictor meets: it says, for
                                          each triplet, what most people said; NaN for scores */
    double ceiling_other_people; /**< share that is met by what most of the others said (a draw counts half), over
                                          triplets with two choices or more; NaN without these */
} nqm_human_info;
NQM_API nqm_human_info nqm_human_get_info(const nqm_human *human);
/** "score", "jod", "distance" or "choice"; static storage. */
NQM_API const char *nqm_human_kind_name(nqm_human_kind kind);

/**
 * The pairs as a dataset, for nqm_evaluation_create(); lent, all of it test pairs. Scores: a pair a row, whose `jod` is
 * the score (a distance: times -1), so that nqm_evaluation_judge() is all that is needed; errors in JOD are given for
 * NQM_HUMAN_JOD only, and ranges of JOD do not apply otherwise. Choices: the distinct pairs, whose `jod` is NaN: only
 * nqm_human_judge_choices() can judge them.
 */
NQM_API const nqm_dataset *nqm_human_dataset(const nqm_human *human);

#ifdef __cplusplus
}
#endif
#endif
