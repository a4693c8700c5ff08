/* SPDX-License-Identifier: MIT
 *
 * toy_dataset.h - a small labelled dataset computed from a few formulas, for the tests of datasets, training and
 * evaluation.
 */
#ifndef NQM_TESTS_TOY_DATASET_H
#define NQM_TESTS_TOY_DATASET_H

#include "train/train.h"

typedef struct toy_options {
    size_t n_directions, n_groups, pairs_per_ref;
    bool with_masks;     /* a few directions have no value */
    bool with_transport; /* a transport matrix of two scenes, and parts and errors of labels that it estimates well */
    bool splits;         /* assign groups to all three splits; otherwise all are training groups */
    const char *families[2]; /* of the kinds "gain" and "gloss" */
    const char *unseen;      /* kind that the manifest lists as unseen; NULL: none */
    uint64_t seed;
} toy_options;

/** 24 materials with two references each, 12 pairs per reference, 16 directions. */
toy_options toy_options_default(void);

/** Each reference is a constant diffuse term plus a random lobe; each test is a scaled copy ("gain") or has another
 * lobe ("gloss"), and its Delta-E increases with the mean difference of the logarithms. Free: nqm_dataset_free(). */
nqm_dataset *toy_dataset(const toy_options *options);

#endif
