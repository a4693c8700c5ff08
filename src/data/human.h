/* SPDX-License-Identifier: MIT
 *
 * human.h - answers of people: human_answers.c reads the CSV, human_file.c samples the BRDFs that the answers refer to.
 */
#ifndef NQM_SRC_DATA_HUMAN_H
#define NQM_SRC_DATA_HUMAN_H

#include "data/data.h"
#include "io/io.h"
#include <nqm/data.h>

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
nqm_human_options nqm_human_options_default(void);

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
