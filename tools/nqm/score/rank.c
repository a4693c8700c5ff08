/* SPDX-License-Identifier: MIT
 *
 * Sorting of scores, for `nqm rank` and `nqm report`.
 */
#include "nqm/score/score.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Scores that differ by less share a rank. The limit is ten times the rounding differences between groupings of
 * pairs. */
static const double tie_jod = 1e-4;

static bool has_score(const scored_pair *row) {
    return row->err.status == NQM_OK;
}

static int by_quality(const void *a, const void *b) {
    const scored_pair *x = a, *y = b;
    if (x->group != y->group)
        return x->group < y->group ? -1 : 1;
    if (has_score(x) != has_score(y))
        return has_score(x) ? -1 : 1;
    if (has_score(x) && x->result.jod != y->result.jod)
        return x->result.jod > y->result.jod ? -1 : 1;
    return x->order < y->order ? -1 : 1;
}

static int by_order(const void *a, const void *b) {
    const scored_pair *x = a, *y = b;
    return x->order < y->order ? -1 : 1;
}

static int by_reference(const void *a, const void *b) {
    const scored_pair *x = a, *y = b;
    int difference = strcmp(x->pair.ref, y->pair.ref);
    return difference ? difference : by_order(a, b);
}

/* Number the references by their first appearance. */
static void number_groups(score_run *r) {
    qsort(r->rows, r->n_rows, sizeof *r->rows, by_reference);
    size_t first = 0;
    for (size_t i = 0; i < r->n_rows; ++i) {
        bool new_one = i == 0 || strcmp(r->rows[i].pair.ref, r->rows[i - 1].pair.ref) != 0;
        first = new_one ? r->rows[i].order : first;
        r->rows[i].group = first; /* only the order of the numbers matters */
    }
}

static bool same_group(const score_run *r, size_t i, size_t k) {
    return k < r->n_rows && r->rows[i].group == r->rows[k].group;
}

void rank_rows(score_run *r) {
    number_groups(r);
    qsort(r->rows, r->n_rows, sizeof *r->rows, by_quality);
    size_t best = 0, leader = 0; /* first row of the reference; first row with an equal score */
    for (size_t i = 0; i < r->n_rows; ++i) {
        scored_pair *row = &r->rows[i];
        row->over_next = row->best_preferred = (double)NAN;
        if (i == 0 || !same_group(r, i - 1, i))
            best = leader = i;
        if (!has_score(row))
            continue;
        double jod = row->result.jod;
        if (r->rows[leader].result.jod - jod >= tie_jod)
            leader = i;
        row->rank = leader - best + 1;
        if (i != best)
            row->best_preferred = nqm_jod_preference(r->rows[best].result.jod, jod);
        if (same_group(r, i, i + 1) && has_score(&r->rows[i + 1]))
            row->over_next = nqm_jod_preference(jod, r->rows[i + 1].result.jod);
    }
}
