/* SPDX-License-Identifier: MIT
 *
 * Selects pairs of an evaluation according to the options.
 */
#include "judge/judge.h"

#include <string.h>

static bool is(const char *required, const char *value) {
    return !required || strcmp(required, value) == 0;
}

/* See nqm_eval_options.subset. */
static bool in_subset(const nqm_evaluation *ev, const char *subset, size_t kind) {
    const char *family = nqm_dataset_get_kind(ev->dataset, kind).family;
    if (!subset)
        return true;
    if (strcmp(subset, "unseen") == 0)
        return ev->unseen[kind];
    if (strcmp(subset, "seen") == 0)
        return ev->has_unseen && !ev->unseen[kind];
    const bool is_near = *family && strcmp(family, "far") != 0 && strcmp(family, "rounding") != 0;
    return strcmp(subset, "near") == 0 ? is_near : strcmp(subset, family) == 0;
}

static bool selected(const nqm_evaluation *ev, const nqm_eval_options *o, size_t pair) {
    const nqm_dataset *d = ev->dataset;
    const nqm_dataset_kind kind = nqm_dataset_get_kind(d, d->pair_kind[pair]);
    return nqm_evaluation_in_split(d, pair, o->split) && nqm_evaluation_in_split(d, pair, ev->split) &&
           (d->order_only || (d->jod[pair] >= o->jod_from && d->jod[pair] < o->jod_to)) && is(o->kind, kind.name) &&
           is(o->family, kind.family) && in_subset(ev, o->subset, d->pair_kind[pair]) &&
           is(o->source, nqm_dataset_ref_source(d, d->pair_ref[pair])) &&
           is(o->material_class, nqm_material_class_name(ev->ref_class[d->pair_ref[pair]]));
}

/* Sort the selected pairs by group, by counting. */
static void sort_pairs(const nqm_evaluation *ev, const nqm_eval_options *o, nqm_selection *s) {
    const nqm_dataset *d = ev->dataset;
    size_t *next = s->group_begin + 1; /* first the number of pairs of each group, one place further */
    for (size_t pair = 0; pair < d->n_pairs; ++pair)
        next[d->ref_group[d->pair_ref[pair]] + 1] += selected(ev, o, pair);
    for (size_t g = 0; g < d->n_groups; ++g)
        next[g + 1] += next[g];
    for (size_t pair = 0; pair < d->n_pairs; ++pair)
        if (selected(ev, o, pair))
            s->pairs[next[d->ref_group[d->pair_ref[pair]]]++] = pair;
    s->n = s->group_begin[d->n_groups];
    for (size_t g = 0; g < d->n_groups; ++g) /* leave out the groups without pairs */
        if (s->group_begin[g + 1] > s->group_begin[g])
            s->group_begin[s->n_groups++] = s->group_begin[g];
    s->group_begin[s->n_groups] = s->n;
}

nqm_status nqm_selection_create(const nqm_evaluation *ev, const nqm_eval_options *options, size_t n_predictors,
                                nqm_selection *s, nqm_error *err) {
    const size_t n_pairs = ev->dataset->n_pairs;
    *s = (nqm_selection){0};
    nqm_status status =
        nqm_alloc_arrays(NQM_ARRAYS({&s->group_begin, ev->dataset->n_groups + 2, sizeof *s->group_begin},
                                    {&s->pairs, n_pairs, sizeof *s->pairs}, {&s->label, n_pairs, sizeof *s->label},
                                    {&s->prediction, n_predictors, n_pairs * sizeof *s->prediction}),
                         err);
    if (status != NQM_OK)
        return status;
    sort_pairs(ev, options, s);
    if (s->n > 0)
        return NQM_OK;
    nqm_selection_free(s);
    return nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "no pair is left to judge on");
}

void nqm_selection_free(nqm_selection *s) {
    nqm_free(s->group_begin);
    *s = (nqm_selection){0};
}
