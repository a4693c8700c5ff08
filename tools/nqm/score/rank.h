/* SPDX-License-Identifier: MIT
 *
 * rank.h - what `nqm rank` orders and how it prints it.
 */
#ifndef NQM_TOOL_RANK_H
#define NQM_TOOL_RANK_H

#include "nqm/score/pair_list.h"
#include "nqm/score/score.h"

/** A pair with its place among those of its reference. */
typedef struct rank_row {
    size_t order, group; /* place in the arguments; that of the first with its reference */
    nqm_named_pair pair;
    nqm_score_result result;
    const nqm_error *err;
    size_t rank;           /* from 1; equal scores share one; 0: no score */
    double over_next;      /* share of people who prefer it to the next; NaN: there is none */
    double best_preferred; /* share who prefer the best to it; NaN for the best itself */
} rank_row;

typedef struct ranking {
    const nqm_model *model;
    nqm_precision precision;
    result_format format;
    size_t n_rows;
    rank_row *rows; /* (n_rows) by reference, then best first, those without a score last */
} ranking;

/** Give the rows, whose pairs and results are set, their order and ranks. */
void rank_rows(ranking *r);
/** Print on standard output. EXIT_OK or EXIT_OPEN. */
int print_ranking(const ranking *r);

#endif
