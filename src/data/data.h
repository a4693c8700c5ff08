/* SPDX-License-Identifier: MIT
 *
 * data.h - datasets of labelled pairs: building, reading, validating and writing.
 */
#ifndef NQM_SRC_DATA_H
#define NQM_SRC_DATA_H

#include "base/base.h"
#include "io/io.h"
#include "metric/metric.h"
#include "model/model.h"
#include "percept/percept.h"
#include "sample/sample.h"
#include <nqm/data.h>
#include <nqm/model.h>

/**
 * A dataset: references, tests (one per pair), labels and names. The split is stored per material group, not per pair
 * or reference, so that no file can assign one material to two splits. Created by nqm_dataset_begin() or by
 * nqm_dataset_parse().
 */
struct nqm_dataset {
    size_t n_directions, n_refs, n_groups, n_kinds, n_pairs;
    nqm_directions *directions; /* owned */
    /* Arrays, listed in dataset.c; only the code that builds a dataset writes to them. */
    double *directions_deg;   /* (n_directions, 3) theta_h, theta_d, phi_d */
    float *ref_rgb;           /* (n_refs, n_directions, 3) f_r in 1/sr, finite, >= 0 */
    float *test_rgb;          /* (n_pairs, n_directions, 3) */
    uint8_t *ref_used;        /* (n_refs, n_directions) 0: no value, 1: used; NULL: all are used */
    uint8_t *test_used;       /* (n_pairs, n_directions) as ref_used */
    uint32_t *pair_ref;       /* (n_pairs) index of the reference */
    uint32_t *pair_kind;      /* (n_pairs) index of the kind of distortion */
    double *delta_e;          /* (n_pairs) Delta-E ITP, >= 0 */
    double *jod;              /* (n_pairs) label; the loader accepts [0, 11]: human scores reach 10.26 */
    float *transport;         /* (n_directions, 3 NQM_TRANSPORT_POINTS) as `light` in nqm_transport; NULL: unknown */
    double *transport_points; /* (NQM_TRANSPORT_POINTS, 3) as in nqm_picture_points; NULL if transport is */
    double *parts;            /* (n_pairs, NQM_LABEL_PARTS) of the label; NULL: unknown */
    double *delta_e_error;    /* (n_pairs) standard error of delta_e, >= 0; NULL: unknown */
    uint32_t *ref_group;      /* (n_refs) index of the material group */
    uint8_t *group_split;     /* (n_groups) NQM_SPLIT_TRAIN, _VALIDATION or _TEST */
    nqm_names ref_names, group_names;
    nqm_names kind_names;    /* "ggx", "ward", "noise", ... */
    nqm_names kind_families; /* (n_kinds) "encoding", "published", ...; empty: unknown */
    nqm_names ref_sources;   /* (n_refs) "rgl", "nbrdf", ..., by the manifest; empty: unknown */
    nqm_names pair_names;    /* (n_pairs) the test: a BRDF spec, or "NAME_3" in the authors' layout */
    char *manifest;          /* JSON: how the dataset was made; NULL: unknown */
    bool is_anisotropic;     /* the manifest says that BRDFs may be anisotropic; the samples have phi_h = 0 only */
    bool order_only; /* `jod` contains scores on another scale, of which only the order is meaningful (human data) */
    char sha256[65]; /* SHA-256 of nqm's own file; of other sources nqm_dataset_hash() */
    nqm_map file;    /* the arrays above point into this mapped file, */
    void *block;     /* or into this block from nqm_alloc() */
};

/** The transport matrix of a dataset; `light` is NULL if it has none. */
static inline nqm_transport nqm_dataset_transport(const nqm_dataset *d) {
    return (nqm_transport){d->n_directions, d->transport, {NQM_TRANSPORT_POINTS, d->transport_points}};
}

/* ---- building (builder.c) ---------------------------------------------------------------------------------------- */

/** Sizes of a dataset under construction: nqm_dataset_begin(), nqm_dataset_add_...() and nqm_dataset_finish(). Its counts are those
 *  of the rows added so far, its arrays are zeroed; the caller writes the samples into ref_rgb and test_rgb, and the masks, before
 *  nqm_dataset_finish(). */
typedef struct nqm_dataset_limits {
    size_t n_directions;
    const double *directions_deg; /* (n_directions, 3), copied */
    size_t max_refs, max_pairs;   /* references, and so groups, and pairs that may be added */
    bool has_masks;               /* allocate ref_used and test_used */
    bool has_parts;               /* allocate parts and delta_e_error; the caller sets them */
    bool has_transport;           /* the same of transport and transport_points */
    bool borrows_samples;         /* ref_rgb and test_rgb stay NULL: the caller sets them (and masks) to its own memory,
                                     which must outlive the dataset */
} nqm_dataset_limits;

NQM_MUST_CHECK nqm_status nqm_dataset_begin(const nqm_dataset_limits *limits, nqm_dataset **dataset_ret,
                                            nqm_error *err);
/** Find the material group called `name` (n_name bytes), or add it with this split. */
NQM_MUST_CHECK nqm_status nqm_dataset_add_group(nqm_dataset *dataset, const char *name, size_t n_name, nqm_split split,
                                                uint32_t *group_ret, nqm_error *err);
/** Find the kind called `name`, or add it. family: NULL for all kinds, or for none. */
NQM_MUST_CHECK nqm_status nqm_dataset_add_kind(nqm_dataset *dataset, const char *name, const char *family,
                                               uint32_t *kind_ret, nqm_error *err);
/** Append a reference (index dataset->n_refs) or a pair (index dataset->n_pairs); at most max_refs and max_pairs. */
NQM_MUST_CHECK nqm_status nqm_dataset_add_reference(nqm_dataset *dataset, const char *name, uint32_t group,
                                                    nqm_error *err);
NQM_MUST_CHECK nqm_status nqm_dataset_add_pair(nqm_dataset *dataset, uint32_t ref, const char *test, uint32_t kind,
                                               double delta_e, double jod, nqm_error *err);
/**
 * Complete the dataset: set its manifest (NULL: none) and the hash of its content.
 *
 * @param status  result of the previous calls; if it is not NQM_OK, the dataset is freed and `status` is returned
 * @param name    name for the messages of nqm_dataset_validate(); NULL: the dataset is not validated
 */
NQM_MUST_CHECK nqm_status nqm_dataset_finish(nqm_dataset *dataset, nqm_status status, const char *manifest,
                                             const char *name, nqm_dataset **dataset_ret, nqm_error *err);

/* ---- arrays (dataset.c) ------------------------------------------------------------------------------------------ */

enum { NQM_DATASET_ARRAYS = 15 };
/** The i-th array as a tensor of the dataset file: name, type, shape, and values (NULL: it does not have the array). */
nqm_tensor nqm_dataset_array(const nqm_dataset *dataset, size_t i);
/** Whether a dataset may lack the i-th array. */
bool nqm_dataset_array_is_optional(size_t i);
/** Set the values of the i-th array. */
void nqm_dataset_set_array(nqm_dataset *dataset, size_t i, const void *values);

/* ---- files and checks -------------------------------------------------------------------------------------------- */

/** Validate the dataset and write it as nqm's dataset file (doc/files.md). sha256_ret: NULL is allowed. */
NQM_MUST_CHECK nqm_status nqm_dataset_write(const nqm_dataset *dataset, const char *path, char sha256_ret[65],
                                            nqm_error *err);

/** Check a dataset: indices are in range, values are finite and in range. `name` is used in messages. */
NQM_MUST_CHECK nqm_status nqm_dataset_validate(const nqm_dataset *dataset, const char *name, nqm_error *err);

/** Parse a dataset file in memory. `data` must outlive the dataset; `name` is used in messages. */
NQM_MUST_CHECK nqm_status nqm_dataset_parse(const unsigned char *data, size_t n_bytes, const char *name,
                                            bool verify_checksum, nqm_dataset **dataset_ret, nqm_error *err);

/** SHA-256 of all content that training and evaluation use: 64 hex digits. */
NQM_MUST_CHECK nqm_status nqm_dataset_hash(const nqm_dataset *dataset, char sha256_ret[65], nqm_error *err);

/** The split of a pair, which is that of its reference's material group. */
static inline nqm_split nqm_dataset_pair_split(const nqm_dataset *dataset, size_t pair) {
    return (nqm_split)dataset->group_split[dataset->ref_group[dataset->pair_ref[pair]]];
}

/** Set unseen (n_kinds): whether the manifest lists the kind as one that the training part of such corpora does not have.
 *  NQM_ERR_NOMEM. */
NQM_MUST_CHECK nqm_status nqm_dataset_unseen_kinds(const nqm_dataset *dataset, bool *unseen, nqm_error *err);

/** NQM_ERR_INCOMPATIBLE: the samples are of one azimuth of anisotropic BRDFs, which a model cannot be made of. */
NQM_MUST_CHECK nqm_status nqm_dataset_check_isotropic(const nqm_dataset *dataset, nqm_error *err);

/** Set the manifest (NULL: none), is_anisotropic, and ref_sources from it; these stay empty if it does not list the
 *  references. NQM_ERR_NOMEM. */
NQM_MUST_CHECK nqm_status nqm_dataset_set_manifest(nqm_dataset *dataset, const char *manifest, nqm_error *err);
/** The source of a reference: see nqm_dataset_pair; "" if unknown. */
const char *nqm_dataset_ref_source(const nqm_dataset *dataset, size_t ref);

/** A kind of distortion, as in nqm_dataset_pair. */
typedef struct nqm_dataset_kind {
    const char *name, *family;
} nqm_dataset_kind;
/** Kind i in [0, n_kinds); both members are NULL beyond. */
nqm_dataset_kind nqm_dataset_get_kind(const nqm_dataset *dataset, size_t i);

enum { NQM_MATERIAL_CLASS_COUNT = 9 };
/** The i-th class of reference materials; static storage; NULL beyond. */
const char *nqm_material_class_name(size_t i);
/** The material class of a reference: an index for nqm_material_class_name(). */
size_t nqm_dataset_ref_class(const nqm_dataset *dataset, size_t ref);

/** The samples of a pair. Its mask, where both BRDFs have values, is written to `scratch` (n_directions); it is NULL if the dataset
 *  has no masks. */
nqm_sample_pair nqm_dataset_samples(const nqm_dataset *dataset, size_t pair, uint8_t *scratch);

/** What is known of a pair without a network. */
typedef struct nqm_comparison {
    double metrics[NQM_METRIC_COUNT], scalars[NQM_SCALAR_COUNT];
    nqm_label estimate; /* by transport, if there is a matrix */
} nqm_comparison;
/** Compare n pairs of a dataset: to (n). transport: its `light` is NULL if there is none. NQM_ERR_NOMEM. */
NQM_MUST_CHECK nqm_status nqm_dataset_compare(const nqm_dataset *dataset, const nqm_transport *transport, size_t n,
                                              const size_t *pairs, nqm_comparison *to, nqm_error *err);

/** Predictions of a model for some pairs of a dataset. */
typedef struct nqm_dataset_prediction {
    const nqm_dataset *dataset;
    const nqm_model *model;
    size_t n;
    const size_t *pairs; /* (n) */
    nqm_prediction *to;  /* (n_pairs of the dataset) receives those of the n pairs, each at the pair's index */
    /* Called after each batch of n pairs; NULL: not called. A failure stops the prediction. */
    nqm_status (*batch_done)(void *user, size_t n, nqm_error *err);
    void *user;
} nqm_dataset_prediction;
/** @return NQM_ERR_INCOMPATIBLE: model and dataset have different directions; NQM_ERR_NUMERIC: a JOD or part is not finite;
 *          NQM_ERR_NOMEM; any failure of batch_done */
NQM_MUST_CHECK nqm_status nqm_dataset_predict(const nqm_dataset_prediction *prediction, nqm_error *err);

/** nqm_dataset_load() of the authors' layout. */
NQM_MUST_CHECK nqm_status nqm_dataset_read_authors(const char *root, const char *labels_csv, nqm_split split,
                                                   nqm_dataset **dataset_ret, nqm_error *err);

/* ---- answers of people (human_answers.c reads the CSV, human_file.c samples the BRDFs) --------------------------- */

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

/** Options of nqm_human_load(). */
typedef struct nqm_human_options {
    const char *root;                 /**< folder of relative paths of BRDFs; NULL: the current folder */
    const nqm_directions *directions; /**< where BRDFs are sampled, used during the call only; NULL: the default set */
    nqm_progress_fn progress;         /**< NULL: none */
    void *progress_user;
} nqm_human_options;

/**
 * Read answers and sample the BRDFs. The CSV has the columns `reference`, `test` (BRDFs as for nqm_brdf_open()) and one of
 * `score`, `jod`, `distance`; or `reference`, `test_a`, `test_b` and `choice` or `n_a`, `n_b`. Optional: `material` (the unit of
 * resampling, and the set inside which tests are compared; default the reference) and `kind` (a name for the kind of test; not
 * with choices). Other columns are ignored. Rows about the same three BRDFs are added up, whichever test is called a.
 *
 * @return NQM_ERR_FORMAT, NQM_ERR_IO and others from the CSV and the BRDFs; the message names the file and
 *         the row, counted from 1 after the header; NQM_ERR_INCOMPATIBLE (too few valid directions, a reference of two
 *         materials), NQM_ERR_CANCELLED, NQM_ERR_NOMEM
 */
NQM_MUST_CHECK nqm_status nqm_human_load(const char *csv_path, const nqm_human_options *options, nqm_human **human_ret,
                                         nqm_error *err);
/** Free; NULL is allowed. */
void nqm_human_free(nqm_human *human);

/** Facts about people's answers. */
typedef struct nqm_human_info {
    nqm_human_kind kind;
    const char *kind_name;   /**< "score", "jod", "distance" or "choice"; static storage */
    size_t n_rows;           /**< rows of the CSV */
    size_t n_refs, n_groups; /**< references, materials */
    size_t n_triplets;       /**< distinct (reference, test, test); 0 for scores */
    double n_choices;        /**< answers of people; 0 for scores */
    double ceiling;          /**< fraction of the choices that agrees with the majority in its triplet: the best that a
                                      predictor can reach; of scores, Pearson's correlation that the true means are expected to have
                                      with them, if columns sd and n or repeated rows say how noisy they are; else NaN */
    double
        ceiling_other_people; /**< fraction of the choices that agrees with the majority of the other people (a draw counts
                                      half), over triplets with at least two choices; NaN without these */
} nqm_human_info;
nqm_human_info nqm_human_get_info(const nqm_human *human);

/** Choices between two tests of a reference: how many people found test a (n_a) or b (n_b) more similar to it. */
typedef struct nqm_triplet {
    uint32_t group;
    uint32_t a, b; /* pairs of the dataset, a < b, with the same reference */
    double n_a, n_b;
} nqm_triplet;

struct nqm_human {
    nqm_human_kind kind;
    size_t n_rows;  /* rows of the CSV */
    double ceiling; /* of nqm_human_info for scores */
    /** The pairs as a dataset of test pairs for nqm_evaluation_create(). Scores: one pair per row, whose `jod` is the
     *  score (a distance: times -1), to be judged by nqm_evaluation_judge(); errors in JOD are given for NQM_HUMAN_JOD
     *  only, and ranges of JOD do not apply otherwise. Choices: the distinct pairs, whose `jod` is NaN; judge them with
     *  nqm_human_judge_choices(). */
    nqm_dataset *dataset;
    size_t n_triplets;
    nqm_triplet *triplets; /* (n_triplets) distinct triplets, sorted by group */
};

/** The columns and values of a CSV of answers. */
typedef struct nqm_answers {
    nqm_human_kind kind;
    const nqm_csv *csv;                                            /* owned by the caller */
    const char *path;                                              /* owned by the caller */
    int reference, test[2], value[2], choice, material, test_kind; /* columns; -1: missing */
    size_t n_rows, n_slots;                                        /* n_slots: tests per row, 1 or 2 */
    double *values; /* (n_rows, n_slots) the score, or the number of people who chose each test; nqm_free() */
} nqm_answers;

/** "score", "jod", "distance" or "choice"; the first three are also the names of CSV columns. NULL: no such kind. */
const char *nqm_human_kind_name(nqm_human_kind kind);

NQM_MUST_CHECK nqm_status nqm_answers_read(const nqm_csv *csv, const char *path, nqm_answers *answers_ret,
                                           nqm_error *err);

#endif
