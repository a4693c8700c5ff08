/* SPDX-License-Identifier: MIT
 *
 * nqm/human.h - what people said about pairs of BRDFs, from a CSV: scores, or choices between two tests; and how well
 * models and metrics agree with them.
 */
#ifndef NQM_HUMAN_H
#define NQM_HUMAN_H

#include <nqm/train.h>

#ifdef __cplusplus
extern "C" {
#endif

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

/** How well one predictor meets the choices. */
typedef struct nqm_choice_agreement {
    const char *name;                    /**< as in nqm_agreement */
    double agreement, agreement_ci95[2]; /**< share of the choices for the test that it finds better; ties count half */
    double majority; /**< share of the triplets in which it sides with most people (ties half), without drawn ones */
    int best_of_family, best_baseline; /**< as in nqm_agreement, by `agreement` */
} nqm_choice_agreement;

/**
 * Judge every predictor of an evaluation of nqm_human_dataset() on the choices, with intervals as those of
 * nqm_evaluation_judge() (n_bootstrap and seed of `options`; NULL: the defaults).
 *
 * @param results      (nqm_evaluation_count())
 * @return NQM_ERR_ARG for scores or another dataset; NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_human_judge_choices(const nqm_human *human, const nqm_evaluation *evaluation,
                                                          const nqm_eval_options *options,
                                                          nqm_choice_agreement *results, nqm_error *err);
/** `agreement` of predictor `first` less that of `second`, on the same resamples. */
NQM_API NQM_MUST_CHECK nqm_status nqm_human_contrast_choices(const nqm_human *human, const nqm_evaluation *evaluation,
                                                             const nqm_eval_options *options, size_t first,
                                                             size_t second, nqm_difference *difference_ret,
                                                             nqm_error *err);

#ifdef __cplusplus
}
#endif
#endif
