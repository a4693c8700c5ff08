/* SPDX-License-Identifier: MIT
 *
 * human.h - answers of people: human_answers.c reads the CSV, human_file.c samples the BRDFs that the answers refer to.
 */
#ifndef NQM_SRC_DATA_HUMAN_H
#define NQM_SRC_DATA_HUMAN_H

#include "data/data.h"
#include "io/io.h"
#include <nqm/data.h>

/** Choices between two tests of a reference: how many people found test a (n_a) or b (n_b) more similar to it. */
typedef struct nqm_triplet {
    uint32_t group;
    uint32_t a, b; /* pairs of the dataset, a < b, with the same reference */
    double n_a, n_b;
} nqm_triplet;

struct nqm_human {
    nqm_human_kind kind;
    size_t n_rows; /* rows of the CSV */
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
