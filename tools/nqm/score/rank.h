/* SPDX-License-Identifier: MIT
 *
 * rank.h - sorting and printing of the rows of `nqm rank`.
 */
#ifndef NQM_TOOL_RANK_H
#define NQM_TOOL_RANK_H

#include "nqm/score/pair_list.h"
#include "nqm/score/score.h"

/** A pair and its rank among the pairs with the same reference. */
typedef struct rank_row {
    size_t order, group; /* index in the arguments; that of the first pair with the same reference */
    nqm_named_pair pair;
    nqm_score_result result;
    const nqm_error *err;
    size_t rank;           /* from 1; equal scores share one; 0: no score */
    double over_next;      /* fraction of people who prefer it to the next; NaN: there is none */
    double best_preferred; /* fraction of people who prefer the best to it; NaN for the best itself */
} rank_row;

typedef struct ranking {
    const nqm_model *model;
    nqm_precision precision;
    result_format format;
    size_t n_rows;
    rank_row *rows; /* (n_rows) by reference, then best first, those without a score last */
} ranking;

/** Sort the rows, whose order, pairs and results are set, and set the other members. */
void rank_rows(ranking *r);
/** Print on standard output. EXIT_OK or EXIT_OPEN. */
int print_ranking(const ranking *r);

#endif
