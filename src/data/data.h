/* SPDX-License-Identifier: MIT
 *
 * data.h - labelled pairs in memory and in nqm's own dataset file.
 */
#ifndef NQM_SRC_DATA_H
#define NQM_SRC_DATA_H

#include "base/base.h"
#include "sample/sample.h"
#include <nqm/data.h>

enum { NQM_DATASET_MAX_BLOCKS = 24 };

/**
 * A dataset: references, tests (one a pair), labels and names. A split belongs to a material group, not to a pair or a
 * reference, so that no file can put one material on both sides of a split.
 *
 * To write one, zero-initialise it, point the arrays at memory of yours, and call nqm_dataset_write(). The fields
 * behind "owned" belong to the loaders.
 */
struct nqm_dataset {
    size_t n_directions, n_refs, n_groups, n_kinds, n_pairs;
    const double *directions_deg;   /* (n_directions, 3) theta_h, theta_d, phi_d */
    const float *ref_rgb;           /* (n_refs, n_directions, 3) f_r in 1/sr, finite, >= 0 */
    const float *test_rgb;          /* (n_pairs, n_directions, 3) */
    const uint8_t *ref_used;        /* (n_refs, n_directions) 0: no value there, 1: used; NULL: all are used */
    const uint8_t *test_used;       /* (n_pairs, n_directions) likewise */
    const uint32_t *pair_ref;       /* (n_pairs) index of the reference */
    const uint32_t *pair_kind;      /* (n_pairs) index of the kind of distortion */
    const double *delta_e;          /* (n_pairs) Delta-E ITP, >= 0 */
    const double *jod;              /* (n_pairs) label; the loader accepts [0, 11]: human scores pass 10 by a little */
    const uint32_t *ref_group;      /* (n_refs) index of the material group */
    const uint8_t *group_split;     /* (n_groups) NQM_SPLIT_TRAIN, _VALIDATION or _TEST */
    const char *const *ref_names;   /* (n_refs) */
    const char *const *group_names; /* (n_groups) */
    const char *const *kind_names;  /* (n_kinds) "ggx", "ward", "noise", ... */
    const char *const *kind_families; /* (n_kinds) "encoding", "published", ...; NULL: not known */
    const char *const *pair_names;    /* (n_pairs) the test: a spec, or "NAME_3" in the authors' layout */
    const char *manifest;             /* JSON: how it was made; NULL: unknown */
    bool order_only; /* `jod` holds scores of some other scale, of which only the order counts (human data) */

    /* owned by a loaded dataset */
    char sha256[65]; /* of the file; of the content for the authors' layout */
    nqm_directions *directions;
    nqm_map file;                         /* the arrays above point into it */
    void *blocks[NQM_DATASET_MAX_BLOCKS]; /* memory of whatever does not lie in the file */
    size_t n_blocks;
};

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

/** Memory that lives as long as the dataset: n * size zeroed bytes, or NULL. */
void *nqm_dataset_alloc(nqm_dataset *dataset, size_t n, size_t size);

/** Split of a pair, by way of its reference's material group. */
static inline nqm_split nqm_dataset_pair_split(const nqm_dataset *dataset, size_t pair) {
    return (nqm_split)dataset->group_split[dataset->ref_group[dataset->pair_ref[pair]]];
}

/** The class of a reference, an i of nqm_material_class_name(). */
size_t nqm_dataset_ref_class(const nqm_dataset *dataset, size_t ref);

/** The directions where both members of a pair have values: NULL when all, else `scratch` (n_directions), filled. */
const uint8_t *nqm_dataset_pair_used(const nqm_dataset *dataset, size_t pair, uint8_t *scratch);

#endif
