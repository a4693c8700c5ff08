/* SPDX-License-Identifier: MIT
 *
 * Access to the answers of people, and ceilings of the fraction of choices that a predictor can reproduce.
 */
#include "data/data.h"

#include <math.h>

const char *nqm_human_kind_name(nqm_human_kind kind) {
    static const char *const names[] = {"score", "jod", "distance", "choice"};
    return (size_t)kind < sizeof names / sizeof *names ? names[kind] : NULL;
}

void nqm_human_free(nqm_human *human) {
    if (!human)
        return;
    nqm_dataset_free(human->dataset);
    nqm_free(human->triplets);
    nqm_free(human);
}

/* ---- ceilings ---------------------------------------------------------------------------------------------------- */

/* Number of the n people with the same choice who agree with the majority of all other people: n - 1 with the same
 * choice and n_other with the opposite one. A tie counts half. */
static double follow_others(double n, double n_other) {
    double others = n - 1;
    return others > n_other ? n : others == n_other ? 0.5 * n : 0;
}

nqm_human_info nqm_human_get_info(const nqm_human *human) {
    assert(human);
    nqm_human_info info = {.kind = human->kind,
                           .kind_name = nqm_human_kind_name(human->kind),
                           .n_rows = human->n_rows,
                           .n_refs = human->dataset->n_refs,
                           .n_groups = human->dataset->n_groups,
                           .n_triplets = human->n_triplets};
    double met = 0, with_others = 0, followed = 0;
    for (size_t i = 0; i < human->n_triplets; ++i) {
        const nqm_triplet *t = &human->triplets[i];
        info.n_choices += t->n_a + t->n_b;
        met += fmax(t->n_a, t->n_b);
        if (t->n_a + t->n_b < 2)
            continue;
        with_others += t->n_a + t->n_b;
        followed += follow_others(t->n_a, t->n_b) + follow_others(t->n_b, t->n_a);
    }
    info.ceiling = human->kind != NQM_HUMAN_CHOICE ? human->ceiling : info.n_choices > 0 ? met / info.n_choices : NAN;
    info.ceiling_other_people = with_others > 0 ? followed / with_others : NAN;
    return info;
}
