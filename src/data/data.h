/* SPDX-License-Identifier: MIT
 *
 * data.h - labelled pairs in memory: how they are built, read, checked and written.
 */
#ifndef NQM_SRC_DATA_H
#define NQM_SRC_DATA_H

#include "base/base.h"
#include "base/names.h"
#include "sample/sample.h"
#include <nqm/data.h>
#include <nqm/model.h>

/**
 * A dataset: references, tests (one per pair), labels and names. A split belongs to a material group, not to a pair or a
 * reference, so that no file can put one material on both sides of a split. Made by a nqm_dataset_builder or by
 * nqm_dataset_parse().
 */
struct nqm_dataset {
    size_t n_directions, n_refs, n_groups, n_kinds, n_pairs;
    nqm_directions *directions;   /* owned */
    const double *directions_deg; /* (n_directions, 3) theta_h, theta_d, phi_d */
    const float *ref_rgb;         /* (n_refs, n_directions, 3) f_r in 1/sr, finite, >= 0 */
    const float *test_rgb;        /* (n_pairs, n_directions, 3) */
    const uint8_t *ref_used;      /* (n_refs, n_directions) 0: no value there, 1: used; NULL: all are used */
    const uint8_t *test_used;     /* (n_pairs, n_directions) likewise */
    const uint32_t *pair_ref;     /* (n_pairs) index of the reference */
    const uint32_t *pair_kind;    /* (n_pairs) index of the kind of distortion */
    const double *delta_e;        /* (n_pairs) Delta-E ITP, >= 0 */
    const double *jod;            /* (n_pairs) label; the loader accepts [0, 11]: human scores reach 10.26 */
    const uint32_t *ref_group;    /* (n_refs) index of the material group */
    const uint8_t *group_split;   /* (n_groups) NQM_SPLIT_TRAIN, _VALIDATION or _TEST */
    nqm_names ref_names, group_names;
    nqm_names kind_names;    /* "ggx", "ward", "noise", ... */
    nqm_names kind_families; /* (n_kinds) "encoding", "published", ...; empty: unknown */
    nqm_names pair_names;    /* the test: a spec, or "NAME_3" in the authors' layout */
    char *manifest;          /* JSON: how it was made; NULL: unknown */
    bool order_only;         /* `jod` holds scores of another scale, of which only the order counts (human data) */
    char sha256[65];         /* of the file; of the content when it was not read from nqm's own file */
    nqm_map file;            /* the arrays above point into it, */
    void *block;             /* or into this block of nqm_alloc() */
};

/* ---- building (builder.c) ---------------------------------------------------------------------------------------- */

/** A dataset under construction: nqm_dataset_begin(), the nqm_dataset_add_...() calls, nqm_dataset_finish(). The caller fills
 *  the rows of samples itself, before nqm_dataset_finish(). */
typedef struct nqm_dataset_builder {
    nqm_dataset *dataset; /* its counts grow */
    size_t max_refs, max_pairs;
    float *ref_rgb, *test_rgb;     /* (max_refs, n_directions, 3), (max_pairs, n_directions, 3) f_r, zeroed */
    uint8_t *ref_used, *test_used; /* (max_refs, n_directions), (max_pairs, n_directions); NULL: without masks */
    uint32_t *pair_ref, *pair_kind, *ref_group;
    double *delta_e, *jod;
    uint8_t *group_split;
} nqm_dataset_builder;

/** What a builder reserves. */
typedef struct nqm_dataset_limits {
    size_t n_directions;
    const double *directions_deg; /* (n_directions, 3), copied */
    size_t max_refs, max_pairs;   /* references and pairs that may be added */
    bool has_masks;               /* reserve ref_used and test_used */
    bool borrows_samples; /* ref_rgb and test_rgb (and masks) stay NULL: the caller sets them to memory of its own,
                                     which must outlive the dataset */
} nqm_dataset_limits;

NQM_MUST_CHECK nqm_status nqm_dataset_begin(const nqm_dataset_limits *limits, nqm_dataset_builder *builder_ret,
                                            nqm_error *err);
/** The index of the material group with that name (n_name bytes), which is added with that split when it is new. */
NQM_MUST_CHECK nqm_status nqm_dataset_add_group(nqm_dataset_builder *builder, const char *name, size_t n_name,
                                                nqm_split split, uint32_t *group_ret, nqm_error *err);
/** The index of the kind with that name, which is added when it is new. family: NULL for all kinds, or for none. */
NQM_MUST_CHECK nqm_status nqm_dataset_add_kind(nqm_dataset_builder *builder, const char *name, const char *family,
                                               uint32_t *kind_ret, nqm_error *err);
/** Add reference number dataset->n_refs, or pair number dataset->n_pairs. At most max_refs, max_pairs. */
NQM_MUST_CHECK nqm_status nqm_dataset_add_reference(nqm_dataset_builder *builder, const char *name, uint32_t group,
                                                    nqm_error *err);
NQM_MUST_CHECK nqm_status nqm_dataset_add_pair(nqm_dataset_builder *builder, uint32_t ref, const char *test,
                                               uint32_t kind, double delta_e, double jod, nqm_error *err);
/**
 * Complete the dataset with its manifest (NULL: none) and the hash of its content.
 *
 * @param status  of the calls so far: unless NQM_OK the dataset is freed, and the status returned
 * @param name    for the messages of nqm_dataset_validate(); NULL: it is not checked
 */
NQM_MUST_CHECK nqm_status nqm_dataset_finish(nqm_dataset_builder *builder, nqm_status status, const char *manifest,
                                             const char *name, nqm_dataset **dataset_ret, nqm_error *err);

/* ---- files and checks -------------------------------------------------------------------------------------------- */

/** Write nqm's dataset file (doc/files.md). The struct is checked as a loaded one is. sha256_ret (NULL allowed). */
NQM_MUST_CHECK nqm_status nqm_dataset_write(const nqm_dataset *dataset, const char *path, char sha256_ret[65],
                                            nqm_error *err);

/** Check everything a dataset promises: indices in range, numbers finite and in range. `name` is for messages. */
NQM_MUST_CHECK nqm_status nqm_dataset_validate(const nqm_dataset *dataset, const char *name, nqm_error *err);

/** Parse a dataset file that lies in memory and outlives the dataset; `name` is for messages. */
NQM_MUST_CHECK nqm_status nqm_dataset_parse(const unsigned char *data, size_t n_bytes, const char *name,
                                            bool verify_checksum, nqm_dataset **dataset_ret, nqm_error *err);

/** SHA-256 of everything that training and evaluation look at: 64 hex digits. */
NQM_MUST_CHECK nqm_status nqm_dataset_hash(const nqm_dataset *dataset, char sha256_ret[65], nqm_error *err);

/** Split of a pair: that of its reference's material group. */
static inline nqm_split nqm_dataset_pair_split(const nqm_dataset *dataset, size_t pair) {
    return (nqm_split)dataset->group_split[dataset->ref_group[dataset->pair_ref[pair]]];
}

/** The class of a reference, an i of nqm_material_class_name(). */
size_t nqm_dataset_ref_class(const nqm_dataset *dataset, size_t ref);

/** The directions where both members of a pair have values: NULL when all, else `scratch` (n_directions), filled. */
const uint8_t *nqm_dataset_pair_used(const nqm_dataset *dataset, size_t pair, uint8_t *scratch);

/** Predictions of a model for some pairs of a dataset. */
typedef struct nqm_dataset_prediction {
    const nqm_dataset *dataset;
    const nqm_model *model;
    nqm_precision precision;
    size_t n;
    const size_t *pairs; /* (n) */
    double *jod;         /* (n_pairs of the dataset) receives the JOD of each of the n pairs, by pair */
    nqm_status (*batch_done)(void *user, size_t n,
                             nqm_error *err); /* after every n pairs; NULL: not called. A failure ends
                                                                        the prediction */
    void *user;
} nqm_dataset_prediction;
/** NQM_ERR_INCOMPATIBLE: other directions; NQM_ERR_NUMERIC: a JOD is not finite; NQM_ERR_NOMEM; what batch_done returns. */
NQM_MUST_CHECK nqm_status nqm_dataset_predict(const nqm_dataset_prediction *prediction, nqm_error *err);

#endif
