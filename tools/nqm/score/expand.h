/* SPDX-License-Identifier: MIT
 *
 * expand.h - what pairs mean whose members are files of several materials, and pairs that are refused on both sides.
 */
#ifndef NQM_TOOL_EXPAND_H
#define NQM_TOOL_EXPAND_H

#include "nqm/score/pair_list.h"
#include "nqm/tool.h"

typedef struct expansion {
    size_t n, max_n;
    expanded_pair *pairs; /* (n) in the order of the given pairs, materials in that of their file */
} expansion;

/**
 * A test that is a file of several materials stands for a pair with each of them. If the reference is such a file, too, its
 * materials are paired with those of the same names; one that the test lacks is a pair that cannot be opened, and one that only the
 * test has is reported and left out. Other pairs remain.
 *
 * @param names  (n) of the tests, NULL where there is none; NULL: there are none. Names of materials are appended.
 */
void expand_pairs(size_t n, const nqm_named_pair *pairs, const char *const *names, expansion *expansion);
/** The texts of its pairs are freed, too. */
void free_expansion(expansion *expansion);

/** A list whose pairs are expanded; the cells of a row are those of the row that it stands for. */
typedef struct expanded_list {
    nqm_pair_list list; /* uses the texts of the given list */
    const char **names; /* (n_rows) */
    expansion expansion;
    nqm_named_pair *pair;
} expanded_list;

void expand_list(const nqm_pair_list *list, const char *const *names, expanded_list *expanded);
/** NULL members are allowed. */
void free_expanded_list(expanded_list *expanded);

/** Whether both members are materials that nqm refuses for the same property, value and reason. */
bool has_same_refusal(const nqm_named_pair *pair);

#endif
