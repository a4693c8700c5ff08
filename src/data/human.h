/* SPDX-License-Identifier: MIT
 *
 * human.h - inside of the answers of people: human_answers.c reads them, human_file.c samples the BRDFs that they are
 * about, human.c judges choices.
 */
#ifndef NQM_SRC_TRAIN_HUMAN_H
#define NQM_SRC_TRAIN_HUMAN_H

#include "data/data.h"
#include "io/io.h"
#include <nqm/data.h>

/** How many people found which of two tests closer to their reference. */
typedef struct nqm_triplet {
    uint32_t group;
    uint32_t a, b; /* pairs of the dataset, a < b, with the same reference */
    double n_a, n_b;
} nqm_triplet;

struct nqm_human {
    nqm_human_kind kind;
    nqm_csv *csv; /* the dataset's names are its fields */
    nqm_dataset *dataset;
    size_t n_triplets;
    nqm_triplet *triplets; /* (n_triplets) distinct, by group */
};

/** The rows of a file. */
typedef struct nqm_answers {
    nqm_human_kind kind;
    const nqm_csv *csv;                                            /* lent */
    const char *path;                                              /* lent */
    int reference, test[2], value[2], choice, material, test_kind; /* columns; -1: not there */
    size_t n_rows, n_slots;                                        /* n_slots: tests of a row, 1 or 2 */
    double *values; /* (n_rows, n_slots) the score, or the number of people who chose each; nqm_free() */
} nqm_answers;

NQM_MUST_CHECK nqm_status nqm_answers_read(const nqm_csv *csv, const char *path, nqm_answers *answers_ret,
                                           nqm_error *err);

#endif
